//! What went wrong, and what to do about it.

use crate::analysis::summary::RayClass;
use crate::analysis::timing::SpeedupLine;
use crate::model::context::Problem;
use crate::model::{Context, Recording};
use crate::output::times;
use crate::panels::panel::Panel;
use crate::shown;
use crate::theme::Theme;

pub(super) struct ProblemsPanel;

impl Panel for ProblemsPanel {
    fn show(&mut self, ui: &mut egui::Ui, context: &mut Context) {
        let controls: Vec<Problem> = context.recordings.iter().flat_map(bad_controls).collect();
        let colour = Theme::of(ui.ctx()).problem();
        egui::ScrollArea::vertical().show(ui, |ui| {
            if context.problems.is_empty() && controls.is_empty() {
                ui.label("No problems.");
            }
            for problem in context.problems.iter().chain(&controls) {
                ui.label(egui::RichText::new(&problem.what).strong().color(colour));
                ui.add(egui::Label::new(shown::sentence(problem.why.clone())).wrap());
                ui.add_space(6.0);
            }
            if !context.problems.is_empty() && ui.button("Dismiss").clicked() {
                context.problems.clear();
            }
            for recording in &context.recordings {
                for notice in &recording.shown.notices {
                    let noted = format!("{}, noted when it was made: {notice}", recording.label);
                    ui.add(egui::Label::new(noted).wrap());
                }
            }
        });
    }
}

/// What the controls of a recording say of its times.
fn bad_controls(recording: &Recording) -> Vec<Problem> {
    let controls = recording.times.iter().flat_map(|times| times.bad_controls());
    let problem = |(rays, line): &(RayClass, SpeedupLine)| {
        let (ratio, interval) = (times(line.ratio), line.interval_text());
        let separator = if interval.is_empty() { "" } else { " " };
        Problem {
            what: format!("{}: the control is off by {:+.1} %", recording.label, 100.0 * (line.ratio - 1.0)),
            why: format!(
                "Canonical order through the same steps must take as long as unsorted rays; of {} rays it is {ratio}{separator}{interval}. \
                 Speedups of this recording are no truer than that: record it again with nothing else running, and with more --repeats.",
                rays.name()
            ),
        }
    };
    controls.map(problem).collect()
}
