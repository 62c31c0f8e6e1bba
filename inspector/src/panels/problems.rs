//! What went wrong, and what to do about it.

use crate::model::Context;
use crate::panels::panel::Panel;
use crate::shown;
use crate::theme::Theme;

pub(super) struct ProblemsPanel;

impl Panel for ProblemsPanel {
    fn show(&mut self, ui: &mut egui::Ui, context: &mut Context) {
        if context.problems.is_empty() {
            ui.label("No problems.");
            return;
        }
        let colour = Theme::of(ui.ctx()).problem();
        egui::ScrollArea::vertical().show(ui, |ui| {
            for problem in &context.problems {
                ui.label(egui::RichText::new(&problem.what).strong().color(colour));
                ui.add(egui::Label::new(shown::sentence(problem.why.clone())).wrap());
                ui.add_space(6.0);
            }
            if ui.button("Dismiss").clicked() {
                context.problems.clear();
            }
        });
    }
}
