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
        let recordings = context.recordings.iter();
        let of_times = recordings.flat_map(|recording| bad_controls(recording).chain(disturbed(recording)));
        let of_times: Vec<Problem> = of_times.collect();
        let colour = Theme::of(ui.ctx()).problem();
        egui::ScrollArea::vertical().show(ui, |ui| {
            if context.problems.is_empty() && of_times.is_empty() {
                ui.label("No problems.");
            }
            for problem in context.problems.iter().chain(&of_times) {
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
fn bad_controls(recording: &Recording) -> impl Iterator<Item = Problem> {
    let controls = recording.times.iter().flat_map(|times| times.bad_controls());
    let problem = |(rays, line): &(RayClass, SpeedupLine)| {
        let (ratio, interval) = (times(line.ratio), line.speedup().interval_text());
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
    controls.map(problem)
}

/// What disturbed the times of a recording, if it was much.
fn disturbed(recording: &Recording) -> impl Iterator<Item = Problem> {
    let sentences = recording.times.iter().flat_map(|times| times.noise.sentences());
    let what = format!("{}: its times were disturbed", recording.label);
    sentences.map(move |why| Problem { what: what.clone(), why: format!("{why}.") })
}
