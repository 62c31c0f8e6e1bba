//! The window: panels in tiles, what is dropped on it, light and dark.

use std::path::{Path, PathBuf};

use egui::{Key, Modifiers};
use egui_tiles::{Tile, TileId, Tiles, Tree, UiResponse};
use formats::manifest::QueueId;

use crate::inputs::quoted;
use crate::model::what_if::WHAT_IF;
use crate::model::{Context, Selection};
use crate::panels::{Entry, PANELS, Panel};
use crate::theme::{self, Theme};

/// A tile: the name of the panel that it shows.
type Pane = String;

/// Under which name the layout is kept between runs.
const LAYOUT_KEY: &str = "tiles";

/// Everything in the window.
pub struct App {
    /// What panels see.
    pub context: Context,
    panels: Vec<Box<dyn Panel>>,
    tree: Tree<Pane>,
    is_help_open: bool,
}

impl App {
    /// With these recordings, in a window of this format.
    pub fn new(paths: &[PathBuf], format: wgpu::TextureFormat) -> Self {
        let mut app = Self {
            context: Context::default(),
            panels: PANELS.iter().map(|entry| (entry.make)(format)).collect(),
            tree: layout(),
            is_help_open: false,
        };
        for path in paths {
            app.open(path);
        }
        app
    }

    /// Opens one more recording; what goes wrong is shown.
    pub fn open(&mut self, path: &Path) {
        let problems = self.context.problems.len();
        self.context.add(path);
        if self.context.problems.len() > problems {
            let is_problems = |tile: &Tile<Pane>| match tile {
                Tile::Pane(name) => name == "problems",
                Tile::Container(_) => false,
            };
            self.tree.make_active(|_, tile| is_problems(tile));
        }
    }

    /// Puts panels where they were in an earlier run, unless that one had other panels.
    fn arrange(&mut self, kept: Option<Tree<Pane>>) {
        let has_all = |tree: &Tree<Pane>| {
            PANELS.iter().all(|entry| tree.tiles.find_pane(&entry.name.to_owned()).is_some())
        };
        if let Some(tree) = kept.filter(has_all)
            && self.context.problems.is_empty()
        {
            self.tree = tree;
        }
    }

    /// The command that draws this window into a file; none for an order that no recording has.
    fn command(&self) -> Option<String> {
        if self.context.selection.method == WHAT_IF {
            return None;
        }
        let path = quoted(self.context.recording()?.dump.root());
        let Selection { queue: QueueId { pass, bounce, kind }, method, ray, cell, filter, .. } =
            &self.context.selection;
        let ray = ray.map_or(String::new(), |ray| format!(" --ray {ray}"));
        let cell = cell.map_or(String::new(), |cell| format!(" --cell {cell}"));
        let filter =
            filter.in_force().map(|filter| format!(" --filter {}", quoted(Path::new(filter.text()))));
        let filter = filter.unwrap_or_default();
        let queue = format!("--pass {pass} --bounce {bounce} --kind {kind} --method {method}");
        Some(format!("inspector shot {path} --view window {queue}{ray}{cell}{filter} --out window.png"))
    }

    /// All of the window.
    pub fn show(&mut self, ui: &mut egui::Ui) {
        let window = ui.ctx().clone();
        self.context.wake_with(move || window.request_repaint());
        self.take_dropped(ui);
        self.take_keys(ui);
        egui::Panel::top("menu").show(ui, |ui| self.menu(ui));
        let tiles = egui::Frame::central_panel(ui.style()).inner_margin(2.0);
        egui::CentralPanel::default().frame(tiles).show(ui, |ui| {
            let mut shown = Shown { panels: &mut self.panels, context: &mut self.context };
            self.tree.ui(&mut shown, ui);
        });
        if self.is_help_open {
            self.help(ui);
        }
    }

    fn menu(&mut self, ui: &mut egui::Ui) {
        egui::MenuBar::new().ui(ui, |ui| {
            ui.menu_button("File", |ui| {
                if ui.button("Open...").clicked() {
                    if let Some(folder) = rfd::FileDialog::new().set_title("Open NAME.raydump").pick_folder()
                    {
                        self.open(&folder);
                    }
                    ui.close();
                }
                let command = self.command();
                let copy = egui::Button::new("Copy command of this picture");
                if ui.add_enabled(command.is_some(), copy).clicked() {
                    ui.ctx().copy_text(command.unwrap_or_default());
                    ui.close();
                }
                if ui.button("Quit").clicked() {
                    ui.ctx().send_viewport_cmd(egui::ViewportCommand::Close);
                }
            });
            ui.menu_button("Window", |ui| {
                for at in 0..PANELS.len() {
                    self.toggle(ui, at);
                }
                ui.separator();
                if ui.button("Arrange as at first").clicked() {
                    self.tree = layout();
                    ui.close();
                }
            });
            ui.menu_button("Theme", |ui| {
                let mut theme = ui.ctx().options(|options| options.theme_preference);
                for (choice, name) in [
                    (egui::ThemePreference::Light, "Light"),
                    (egui::ThemePreference::Dark, "Dark"),
                    (egui::ThemePreference::System, "As the system"),
                ] {
                    if ui.selectable_value(&mut theme, choice, name).clicked() {
                        ui.ctx().set_theme(theme);
                    }
                }
            });
            ui.toggle_value(&mut self.is_help_open, "?").on_hover_text("Keys and words");
            if let Some(problem) = self.context.problems.last() {
                let text = egui::RichText::new(&problem.what).color(Theme::of(ui.ctx()).problem());
                ui.label(text).on_hover_text(&problem.why);
            }
        });
    }

    fn toggle(&mut self, ui: &mut egui::Ui, at: usize) {
        let Entry { name, about, .. } = PANELS[at];
        let Some(tile) = self.tree.tiles.find_pane(&name.to_owned()) else { return };
        let mut is_visible = self.tree.is_visible(tile);
        if ui.checkbox(&mut is_visible, self.panels[at].title()).on_hover_text(about).clicked() {
            self.tree.set_visible(tile, is_visible);
        }
    }

    fn take_dropped(&mut self, ui: &egui::Ui) {
        let dropped = ui.input(|input| input.raw.dropped_files.clone());
        for file in dropped {
            self.open(file.path());
        }
    }

    fn take_keys(&mut self, ui: &egui::Ui) {
        if ui.ctx().egui_wants_keyboard_input() {
            return;
        }
        let pressed = |key: Key| ui.input_mut(|input| input.consume_key(Modifiers::NONE, key));
        if pressed(Key::Escape) {
            self.context.selection.clear();
            self.is_help_open = false;
        }
        if ui.input(|input| {
            input.events.iter().any(|event| matches!(event, egui::Event::Text(text) if text == "?"))
        }) {
            self.is_help_open = !self.is_help_open;
        }
        for (key, step) in [(Key::ArrowDown, 1), (Key::ArrowUp, -1)] {
            if pressed(key) {
                self.next_order(step);
            }
        }
        for (key, step) in [(Key::ArrowRight, 1), (Key::ArrowLeft, -1)] {
            if pressed(key) {
                self.next_bounce(step);
            }
        }
    }

    /// Goes to the next order of the queue, or the one before.
    fn next_order(&mut self, step: isize) {
        let methods = self.context.methods();
        let now = methods.iter().position(|method| *method == self.context.selection.method);
        let next = now.and_then(|now| now.checked_add_signed(step)).and_then(|next| methods.get(next));
        if let Some(next) = next.cloned() {
            self.context.selection.order_by(&next);
            self.context.select_ray(self.context.selection.ray);
        }
    }

    /// Goes to the same rays one bounce later or earlier.
    fn next_bounce(&mut self, step: i32) {
        let now = self.context.selection.queue;
        let Some(bounce) = now.bounce.checked_add_signed(step) else { return };
        let next = QueueId { bounce, ..now };
        let exists = |open: &crate::model::Recording| open.queues().iter().any(|record| record.id == next);
        if self.context.recording().is_some_and(exists) {
            self.context.go_to(next);
        }
    }

    fn help(&mut self, ui: &egui::Ui) {
        egui::Window::new("Keys").open(&mut self.is_help_open).resizable(false).show(ui.ctx(), |ui| {
            egui::Grid::new("keys").num_columns(2).spacing([16.0, 3.0]).show(ui, |ui| {
                for (keys, about) in KEYS {
                    ui.monospace(keys);
                    ui.label(about);
                    ui.end_row();
                }
            });
        });
    }
}

const KEYS: [(&str, &str); 12] = [
    ("up, down", "the order before, the next order"),
    ("left, right", "the bounce before, the next bounce"),
    ("escape", "nothing is selected"),
    ("click", "choose the ray, row, pixel or cell under the pointer"),
    ("drag", "orbit; with shift or the middle button, move"),
    ("drag right", "look around"),
    ("wheel", "nearer, farther"),
    ("W A S D Q E", "fly, over the scene"),
    ("F", "frame what is selected"),
    ("C, R", "the recording's camera, an overview"),
    ("space", "play along the order"),
    ("?", "this"),
];

/// Where panels are at first: the scene in the middle, numbers to its right.
fn layout() -> Tree<Pane> {
    let mut tiles = Tiles::default();
    let mut pane = |name: &str| tiles.insert_pane(name.to_owned());
    let [navigator, problems] = ["navigator", "problems"].map(&mut pane);
    let pictures = ["order", "table"].map(&mut pane);
    let numbers = ["coherence", "what-if", "timings"].map(&mut pane);
    let rays = ["ray", "rays"].map(&mut pane);
    let scenes = ["scene", "compare"].map(&mut pane);
    let tabs = |tiles: &mut Tiles<Pane>, of: &[TileId]| tiles.insert_tab_tile(of.to_vec());
    let left_parts = [tabs(&mut tiles, &[navigator]), tabs(&mut tiles, &[rays[0], problems])];
    let left = tiles.insert_vertical_tile(left_parts.to_vec());
    let middle_parts = [tabs(&mut tiles, &scenes), tabs(&mut tiles, &[rays[1]])];
    let middle = tiles.insert_vertical_tile(middle_parts.to_vec());
    let right = [tabs(&mut tiles, &pictures), tabs(&mut tiles, &numbers)];
    let right = tiles.insert_vertical_tile(right.to_vec());
    let root = tiles.insert_horizontal_tile(vec![left, middle, right]);
    share(&mut tiles, root, &[(left, 0.66), (middle, 1.5), (right, 1.1)]);
    share(&mut tiles, left, &[(left_parts[0], 1.5), (left_parts[1], 1.0)]);
    share(&mut tiles, middle, &[(middle_parts[0], 2.2), (middle_parts[1], 1.0)]);
    Tree::new(egui::Id::unique("tiles"), root, tiles)
}

fn share(tiles: &mut Tiles<Pane>, container: TileId, shares: &[(TileId, f32)]) {
    if let Some(Tile::Container(egui_tiles::Container::Linear(linear))) = tiles.get_mut(container) {
        for (tile, share) in shares {
            linear.shares.set_share(*tile, *share);
        }
    }
}

/// Panels as tiles show them.
struct Shown<'a> {
    panels: &'a mut [Box<dyn Panel>],
    context: &'a mut Context,
}

impl egui_tiles::Behavior<Pane> for Shown<'_> {
    fn pane_ui(&mut self, ui: &mut egui::Ui, _tile: TileId, pane: &mut Pane) -> UiResponse {
        if let Some(panel) = place(pane).and_then(|at| self.panels.get_mut(at)) {
            egui::Frame::new().inner_margin(6.0).show(ui, |ui| {
                ui.set_clip_rect(ui.max_rect().expand(4.0).intersect(ui.clip_rect()));
                panel.show(ui, self.context);
            });
        }
        UiResponse::None
    }

    fn tab_title_for_pane(&mut self, pane: &Pane) -> egui::WidgetText {
        place(pane).and_then(|at| self.panels.get(at)).map_or("", |panel| panel.title()).into()
    }

    fn simplification_options(&self) -> egui_tiles::SimplificationOptions {
        egui_tiles::SimplificationOptions { all_panes_must_have_tabs: true, ..Default::default() }
    }
}

/// Place of a panel in [`PANELS`].
fn place(name: &str) -> Option<usize> {
    PANELS.iter().position(|entry| entry.name == name)
}

impl eframe::App for App {
    fn ui(&mut self, ui: &mut egui::Ui, _frame: &mut eframe::Frame) {
        self.show(ui);
    }

    fn save(&mut self, storage: &mut dyn eframe::Storage) {
        eframe::set_value(storage, LAYOUT_KEY, &self.tree);
    }
}

/// Leaves OpenGL out: the recorder does without it too, and to look for it takes time.
pub(crate) fn only_own_backends(setup: &mut egui_wgpu::WgpuSetup) {
    if let egui_wgpu::WgpuSetup::CreateNew(setup) = setup {
        setup.instance_descriptor.backends &= wgpu::Backends::PRIMARY;
    }
}

/// Opens the window and stays until it is closed.
///
/// # Errors
/// If there is no screen, or nothing that can draw on it.
pub fn run(paths: Vec<PathBuf>) -> anyhow::Result<()> {
    let viewport = egui::ViewportBuilder::default()
        .with_title("Rayscope inspector")
        .with_app_id("rayscope-inspector")
        .with_inner_size([1440.0, 900.0])
        .with_drag_and_drop(true);
    let mut options = eframe::NativeOptions { viewport, ..eframe::NativeOptions::default() };
    only_own_backends(&mut options.wgpu_options.wgpu_setup);
    let make = move |creation: &eframe::CreationContext<'_>| -> Result<Box<dyn eframe::App>, _> {
        let state = creation.wgpu_render_state.as_ref().ok_or("the window has no GPU to draw with")?;
        theme::set_up(&creation.egui_ctx);
        let mut app = App::new(&paths, state.target_format);
        let kept = creation.storage.and_then(|storage| eframe::get_value(storage, LAYOUT_KEY));
        app.arrange(kept);
        Ok(Box::new(app))
    };
    eframe::run_native("Rayscope inspector", options, Box::new(make)).map_err(|error| {
        anyhow::anyhow!(
            "cannot open the window: {error}; it needs a screen and a driver for Vulkan, Metal or DX12, and \
             `inspector shot` draws into a file without a screen"
        )
    })
}
