//! The row at the top of the window.

use egui::{Button, Ui};

use super::ask::Asking;
use super::{App, Task, layout};
use crate::panels::PANELS;
use crate::theme::Theme;

impl App {
    pub(super) fn menu(&mut self, ui: &mut Ui) {
        egui::MenuBar::new().ui(ui, |ui| {
            ui.menu_button("File", |ui| self.file_menu(ui));
            ui.menu_button("Edit", |ui| self.edit_menu(ui));
            ui.menu_button("Window", |ui| self.window_menu(ui));
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
            if let Some(figure) = self.exports.now() {
                ui.spinner();
                ui.weak(format!("making {figure}"));
            }
            if let Some(problem) = self.context.problems.last() {
                let text = egui::RichText::new(&problem.what).color(Theme::of(ui.ctx()).problem());
                let label = ui.add(egui::Label::new(text).sense(egui::Sense::click()));
                if label.on_hover_text(&problem.why).clicked() {
                    layout::bring_forward(&mut self.tree, "problems");
                }
            }
        });
    }

    fn file_menu(&mut self, ui: &mut Ui) {
        let is_open = self.context.recording().is_some();
        self.item(ui, ["Open...", "Ctrl+O"], true, Task::Ask(Asking::OpenRecording));
        ui.menu_button("Open recent", |ui| self.recent_menu(ui));
        self.item(ui, ["Refresh", "F5"], is_open, Task::Refresh);
        ui.separator();
        self.item(ui, ["Open session...", ""], true, Task::Ask(Asking::OpenSession));
        self.item(ui, ["Save session...", "Ctrl+S"], is_open, Task::Ask(Asking::SaveSession));
        ui.separator();
        let picture = Task::Ask(Asking::SavePicture(None));
        self.item(ui, ["Save picture of the window...", ""], is_open, picture);
        let command = Task::Ask(Asking::SaveCommand("window"));
        self.item(ui, ["Show command of the window...", ""], is_open, command);
        ui.separator();
        if ui.button("Quit").clicked() {
            ui.ctx().send_viewport_cmd(egui::ViewportCommand::Close);
        }
    }

    /// A line of a menu that has something done.
    fn item(&mut self, ui: &mut Ui, [name, keys]: [&str; 2], is_enabled: bool, task: Task) {
        if ui.add_enabled(is_enabled, Button::new(name).shortcut_text(keys)).clicked() {
            self.task = Some(task);
            ui.close();
        }
    }

    fn recent_menu(&mut self, ui: &mut Ui) {
        if self.recent.paths().is_empty() {
            ui.weak("nothing was opened yet");
            return;
        }
        for path in self.recent.paths() {
            if ui.add_enabled(path.is_dir(), Button::new(path.display().to_string())).clicked() {
                self.task = Some(Task::Open(path.clone()));
                ui.close();
            }
        }
        ui.separator();
        if ui.button("Forget all").clicked() {
            self.recent.clear();
            ui.close();
        }
    }

    fn edit_menu(&mut self, ui: &mut Ui) {
        let (can_undo, can_redo) = self.history.can();
        self.item(ui, ["Undo selection", "Ctrl+Z"], can_undo, Task::Undo);
        self.item(ui, ["Redo selection", "Ctrl+Shift+Z"], can_redo, Task::Redo);
    }

    fn window_menu(&mut self, ui: &mut Ui) {
        for panel in PANELS {
            let Some(tile) = self.tree.tiles.find_pane(&panel.name.to_owned()) else { continue };
            let mut is_visible = self.tree.is_visible(tile);
            if ui.checkbox(&mut is_visible, panel.title).on_hover_text(panel.about).clicked() {
                self.tree.set_visible(tile, is_visible);
            }
        }
        ui.separator();
        if ui.button("Arrange as at first").clicked() {
            self.tree = layout::at_first();
            ui.close();
        }
    }
}
