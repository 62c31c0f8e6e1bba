//! The window: panels in tiles, files opened and saved, keys, light and dark.
//!
//! - `layout`, `tiles`: where panels are, and what can be saved of each
//! - `strip`: which rays and orders, and by how much B is faster than A
//! - `menu`, `keys`, `help`: what is done to the window as a whole
//! - `welcome`, [`demo`]: before a recording is open
//! - `ask`, `saving`, `screenshot`, `command`: files, and the command that draws the same without a window
//! - `figures`: figures for a paper
//! - [`run`]: the window on a screen; `kept`: from one to the next

mod ask;
mod command;
pub mod demo;
mod figures;
mod help;
mod kept;
mod keys;
mod layout;
mod menu;
pub mod run;
mod saving;
mod screenshot;
mod strip;
mod tiles;
mod welcome;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use egui_tiles::Tree;

use self::ask::{Asked, Asking, Prompt};
use self::demo::Demo;
use self::figures::Exports;
use self::layout::Pane;
use self::screenshot::Screenshot;
use self::strip::Strip;
use self::tiles::PanelTiles;
use crate::model::context::Problem;
use crate::model::history::History;
use crate::model::{Context, Selection};
use crate::panels::space::ViewSetup;
use crate::panels::{PANELS, Panel};
use crate::recent::Recent;
use crate::render::gpu::errors::Errors;
use crate::session::Session;

/// What is done once all of the window is drawn.
enum Task {
    Ask(Asking),
    Open(PathBuf),
    Refresh,
    Undo,
    Redo,
    /// Copies the data of a panel.
    CopyData(&'static str),
}

/// A command that is shown.
struct Shown {
    /// What was done by now.
    said: String,
    command: String,
}

/// A panel of each kind, by their names.
type Panels = BTreeMap<&'static str, Box<dyn Panel>>;

/// Everything in the window.
pub struct App {
    /// What panels see.
    pub context: Context,
    /// Recordings that were opened before.
    pub recent: Recent,
    /// A recording of the demo, if there is one.
    pub demo: Demo,
    panels: Panels,
    strip: Strip,
    tree: Tree<Pane>,
    history: History,
    task: Option<Task>,
    prompt: Option<Prompt>,
    screenshot: Option<Screenshot>,
    places: BTreeMap<&'static str, egui::Rect>,
    exports: Exports,
    shown: Option<Shown>,
    is_help_open: bool,
    setup: ViewSetup,
    gpu_errors: Errors,
}

impl App {
    /// With these recordings, in a window of this format.
    pub fn new(paths: &[PathBuf], format: wgpu::TextureFormat) -> Self {
        Self::showing(Context::open(paths), format.into())
    }

    /// With what is open and selected already.
    pub fn showing(context: Context, setup: ViewSetup) -> Self {
        let mut app = Self {
            context,
            recent: Recent::default(),
            demo: Demo::with(demo::find_recorder()),
            panels: panels(&setup),
            strip: Strip::default(),
            tree: layout::at_first(),
            history: History::default(),
            task: None,
            prompt: None,
            screenshot: None,
            places: BTreeMap::new(),
            exports: Exports::default(),
            shown: None,
            is_help_open: false,
            setup,
            gpu_errors: Errors::default(),
        };
        app.greet();
        app
    }

    /// Remembers the recordings that are open, and shows what went wrong.
    fn greet(&mut self) {
        for recording in &self.context.recordings {
            self.recent.note(recording.dump.root());
        }
        self.show_problems();
    }

    fn show_problems(&mut self) {
        if !self.context.problems.is_empty() {
            layout::bring_forward(&mut self.tree, "problems");
        }
    }

    /// Opens one more recording; what goes wrong is shown.
    pub fn open(&mut self, path: &Path) {
        if self.context.add(path) {
            self.recent.note(path);
        } else {
            layout::bring_forward(&mut self.tree, "problems");
        }
    }

    /// Says what went wrong.
    fn problem(&mut self, what: impl Into<String>, why: impl ToString) {
        self.context.problems.push(Problem { what: what.into(), why: why.to_string() });
        layout::bring_forward(&mut self.tree, "problems");
    }

    /// All that the window shows; light and dark as the window has it.
    pub fn session(&self, window: &egui::Context) -> Session {
        let states = self.panels.iter().map(|(name, panel)| ((*name).to_owned(), panel.state()));
        let kept = states.filter(|(_, state)| !state.is_null()).collect();
        let theme = window.options(|options| options.theme_preference).into();
        Session::of(&self.context, theme, Some(self.tree.clone()), kept)
    }

    /// A panel by its name.
    pub(crate) fn panel(&mut self, name: &str) -> Option<&mut Box<dyn Panel>> {
        self.panels.get_mut(name)
    }

    /// Shows what a session says, but light or dark; what is not there any more is a problem.
    pub fn restore(&mut self, session: &Session) {
        self.context = session.open();
        self.arrange_as(session);
    }

    /// Shows what a session says of the recordings that are open.
    ///
    /// # Errors
    /// If what is selected is not there. What panels cannot show is a problem.
    pub(crate) fn show_session(&mut self, session: &Session) -> Result<(), String> {
        self.context.what_if.clone_from(&session.what_if);
        session.selection.select(&mut self.context)?;
        self.arrange_as(session);
        Ok(())
    }

    /// Shows one panel alone.
    pub(crate) fn show_panel(&mut self, name: &str, ui: &mut egui::Ui) {
        if let Some(panel) = self.panels.get_mut(name) {
            panel.show(ui, &mut self.context);
        }
    }

    /// Arranges panels as a session has them.
    fn arrange_as(&mut self, session: &Session) {
        self.history.clear();
        self.panels = panels(&self.setup);
        self.tree = layout::of_all_panels(session.layout.clone()).unwrap_or_else(layout::at_first);
        // Null is what a panel has that keeps nothing, or kept nothing when the session was saved.
        for (name, state) in session.panels.iter().filter(|(_, state)| !state.is_null()) {
            let restored = match self.panel(name) {
                Some(panel) => panel.set_state(state.clone()).map_err(|error| error.to_string()),
                None => Err("there is no such panel".to_owned()),
            };
            if let Err(why) = restored {
                self.problem(format!("the panel {name} cannot be as the session says"), why);
            }
        }
        self.greet();
    }

    /// Opens a session from a file; what goes wrong is shown.
    pub fn open_session(&mut self, path: &Path, window: &egui::Context) {
        match Session::read(path) {
            Ok(session) => {
                window.set_theme(egui::ThemePreference::from(session.theme));
                self.restore(&session);
            }
            Err(error) => self.problem("the session cannot be opened", error),
        }
    }

    /// Puts panels where they were in an earlier run, unless that one had other panels.
    fn arrange(&mut self, kept: Option<Tree<Pane>>) {
        if let Some(tree) = layout::of_all_panels(kept) {
            self.tree = tree;
            self.show_problems();
        }
    }

    /// All of the window.
    pub fn show(&mut self, ui: &mut egui::Ui) {
        let window = ui.ctx().clone();
        self.context.wake_with(move || window.request_repaint());
        for error in self.gpu_errors.take() {
            self.problem("the GPU cannot draw all of the window", error);
        }
        self.take_dropped(ui);
        self.take_keys(ui);
        self.take_demo(ui);
        egui::Panel::top("menu").show(ui, |ui| self.menu(ui));
        if self.context.recording().is_some() {
            egui::Panel::top("strip").show(ui, |ui| self.strip.show(ui, &mut self.context));
        }
        let tiles = egui::Frame::central_panel(ui.style()).inner_margin(2.0);
        egui::CentralPanel::default().frame(tiles).show(ui, |ui| {
            if self.context.recordings.is_empty() {
                self.welcome(ui);
            } else {
                self.tiles(ui);
            }
        });
        self.help(ui);
        self.command_window(ui);
        self.history.note(&self.context.selection);
        self.take_prompt(ui);
        self.take_screenshot(ui);
        self.take_exported();
        if let Some(task) = self.task.take() {
            self.perform(task, ui.ctx());
        }
    }

    fn tiles(&mut self, ui: &mut egui::Ui) {
        self.places.clear();
        let Self { panels, context, places, task, .. } = self;
        self.tree.ui(&mut PanelTiles { panels, context, places, task }, ui);
    }

    fn take_dropped(&mut self, ui: &egui::Ui) {
        let dropped = ui.input(|input| input.raw.dropped_files.clone());
        for file in dropped {
            let path = file.path();
            if path.is_file() && path.extension().is_some_and(|extension| extension == "json") {
                self.open_session(path, ui.ctx());
            } else {
                self.open(path);
            }
        }
    }

    fn perform(&mut self, task: Task, window: &egui::Context) {
        match task {
            Task::Ask(asking) => {
                let asked = asking.by_dialog();
                self.answer(asking, asked, window);
            }
            Task::Open(path) => self.open(&path),
            Task::Refresh => self.context.refresh(),
            Task::Undo => {
                let before = self.history.undo();
                self.select_again(before);
            }
            Task::Redo => {
                let after = self.history.redo();
                self.select_again(after);
            }
            Task::CopyData(panel) => self.copy_data(panel, window),
        }
        window.request_repaint();
    }

    fn select_again(&mut self, selection: Option<Selection>) {
        if let Some(selection) = selection.filter(|found| found.recording < self.context.recordings.len()) {
            self.context.selection = selection;
        }
    }

    fn answer(&mut self, asking: Asking, asked: Asked, window: &egui::Context) {
        let path = match asked {
            Asked::Chosen(path) => path,
            Asked::Cancelled => return,
            Asked::Unavailable => {
                self.prompt = Some(Prompt::new(asking));
                return;
            }
        };
        match asking {
            Asking::OpenRecording => self.open(&path),
            Asking::OpenSession => self.open_session(&path, window),
            Asking::SaveSession => {
                if let Err(error) = self.session(window).write(&path) {
                    self.problem("the session cannot be saved", error);
                }
            }
            Asking::SaveCommand(panel) => match self.command(panel, &path, window) {
                Ok(command) => {
                    self.shown = Some(Shown { said: format!("saved as {}", path.display()), command });
                }
                Err(error) => self.problem("the session cannot be saved", error),
            },
            Asking::SavePicture(panel) => self.screenshot = Some(Screenshot::of(panel, path)),
            Asking::SaveData(panel) => self.save_data(panel, &path),
            Asking::ExportFigure(name) => self.export_figure(name, path),
        }
    }

    fn take_prompt(&mut self, ui: &egui::Ui) {
        let Some(prompt) = &mut self.prompt else { return };
        let Some(asked) = prompt.show(ui) else { return };
        let asking = prompt.asking.clone();
        self.prompt = None;
        self.answer(asking, asked, ui.ctx());
    }
}

fn panels(setup: &ViewSetup) -> Panels {
    PANELS.iter().map(|panel| (panel.name, (panel.make)(setup))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A path that cannot be opened does not cost the places of panels, which are kept when the window closes.
    #[test]
    fn panels_stay_where_they_were_when_there_are_problems() {
        let mut kept = layout::at_first();
        layout::bring_forward(&mut kept, "timings");
        let context = Context::open(&[PathBuf::from("nowhere.raydump")]);
        let mut app = App::showing(context, wgpu::TextureFormat::Rgba8Unorm.into());
        app.arrange(Some(kept.clone()));
        layout::bring_forward(&mut kept, "problems");
        assert_eq!(serde_json::to_value(&app.tree).unwrap(), serde_json::to_value(&kept).unwrap());
    }
}
