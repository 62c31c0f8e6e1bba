//! What the window shows before a recording is open: how to get one.

use egui::{RichText, ScrollArea, Ui};

use super::ask::Asking;
use super::demo::News;
use super::{App, Task};
use crate::theme::Theme;

/// Widest that the page is, points.
const WIDTH: f32 = 620.0;

impl App {
    /// The page in place of the tiles.
    pub(super) fn welcome(&mut self, ui: &mut Ui) {
        ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
            let margin = (0.5 * (ui.available_width() - WIDTH)).max(12.0);
            ui.add_space(24.0);
            ui.horizontal(|ui| {
                ui.add_space(margin);
                ui.vertical(|ui| {
                    ui.set_max_width(WIDTH.min(ui.available_width() - 12.0));
                    self.page(ui);
                });
            });
        });
    }

    fn page(&mut self, ui: &mut Ui) {
        ui.heading("Rayscope inspector");
        ui.label("Shows what happens to rays when a GPU path tracer reorders them.");
        self.said_problems(ui);
        ui.add_space(16.0);
        ui.strong("Open a recording");
        ui.label("A recording is a folder NAME.raydump that `recorder record` writes. Drop it here, or:");
        ui.horizontal(|ui| {
            if ui.button("Open recording...").clicked() {
                self.task = Some(Task::Ask(Asking::OpenRecording));
            }
            if ui.button("Open session...").clicked() {
                self.task = Some(Task::Ask(Asking::OpenSession));
            }
        });
        self.recent_list(ui);
        ui.add_space(16.0);
        ui.strong("Record the demo");
        self.demo_part(ui);
    }

    fn said_problems(&mut self, ui: &mut Ui) {
        let colour = Theme::of(ui.ctx()).problem();
        for problem in &self.context.problems {
            ui.add_space(8.0);
            ui.label(RichText::new(&problem.what).strong().color(colour));
            ui.label(&problem.why);
        }
    }

    fn recent_list(&mut self, ui: &mut Ui) {
        if self.recent.paths().is_empty() {
            return;
        }
        ui.add_space(16.0);
        ui.strong("Recent");
        for path in self.recent.paths() {
            let exists = path.is_dir();
            let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
            ui.horizontal(|ui| {
                if ui.add_enabled(exists, egui::Button::new(name)).clicked() {
                    self.task = Some(Task::Open(path.clone()));
                }
                let folder = path.parent().map_or_else(String::new, |folder| folder.display().to_string());
                ui.weak(if exists { folder } else { format!("{folder} (not there any more)") });
            });
        }
    }

    fn demo_part(&mut self, ui: &mut Ui) {
        if !self.demo.has_program() {
            ui.label(
                "The program `recorder` was found neither beside this one nor on the PATH. Build it with \
                 `cargo build --release`, which puts both into target/release, or run `recorder demo` \
                 yourself and open demo.raydump here.",
            );
            return;
        }
        ui.label("A built-in scene with all methods: under a minute on two cores, and about 100 MB.");
        let mut failed = None;
        ui.horizontal(|ui| {
            if self.demo.is_running() {
                ui.spinner();
                if ui.button("Cancel").clicked() {
                    self.demo.cancel();
                }
                ui.label(self.demo.progress().unwrap_or_default());
                return;
            }
            if ui.button("Record the demo").clicked() {
                let window = ui.ctx().clone();
                failed = self.demo.start(move || window.request_repaint()).err();
            }
            ui.label("into");
            ui.add(egui::TextEdit::singleline(&mut self.demo.folder).desired_width(f32::INFINITY));
        });
        if let Some(why) = failed {
            self.problem("the demo cannot be recorded", why);
        }
        if !self.demo.log.is_empty() {
            ScrollArea::vertical().max_height(220.0).stick_to_bottom(true).show(ui, |ui| {
                for line in &self.demo.log {
                    ui.monospace(line);
                }
            });
        }
    }

    /// Opens the demo once it is recorded.
    pub(super) fn take_demo(&mut self, ui: &Ui) {
        match self.demo.news() {
            News::Nothing => {}
            News::Recorded(recording) => self.open(&recording),
            News::Failed(why) => self.problem("the demo could not be recorded", why),
        }
        if self.demo.is_running() {
            // The program may end without a last word.
            ui.ctx().request_repaint_after(std::time::Duration::from_millis(300));
        }
    }
}
