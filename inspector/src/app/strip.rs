//! The strip above all panels: which rays, which two orders, and by how much B is faster than A.

use std::collections::BTreeSet;

use egui::{RichText, Ui};
use formats::key::method::UNSORTED;
use formats::manifest::QueueId;
use formats::metrics::speedup::Verdict;
use formats::ray::Kind;

use crate::analysis::summary::RayClass;
use crate::analysis::timing::SpeedupLine;
use crate::analysis::{Metric, OrderAnalysis, Versus};
use crate::model::selection::Selection;
use crate::model::what_if::WHAT_IF;
use crate::model::{Context, Recording};
use crate::output::{counted, times};
use crate::panels::notes::{choose, swatch};
use crate::theme::Theme;

/// Below this width the numbers stand under what is chosen, points.
const NARROW: f32 = 1000.0;
/// Size of the numbers of the whole frame, and of those of the selected rays, points.
const LARGE: f32 = 24.0;
const SMALLER: f32 = 17.0;
/// Height of the numbers with what they are of, or of a sentence in their place, so that nothing below moves, points.
const HEIGHT: f32 = 66.0;

/// What the numbers depend on: both recordings, as they were opened, both orders and the queue.
type Key = ([u64; 2], [String; 2], QueueId);

/// The strip.
#[derive(Default)]
pub(super) struct Strip {
    /// On the whole frame and on the selected rays; nothing without times.
    known: Option<(Key, Option<[Versus; 2]>)>,
}

impl Strip {
    /// Draws it and takes what is chosen.
    pub(super) fn show(&mut self, ui: &mut Ui, context: &mut Context) {
        let is_narrow = ui.available_width() < NARROW;
        ui.horizontal(|ui| {
            ui.vertical(|ui| {
                ui.horizontal(|ui| rays(ui, context));
                ui.horizontal(|ui| orders(ui, context));
            });
            if !is_narrow {
                ui.separator();
                self.outcomes(ui, context);
            }
        });
        if is_narrow {
            ui.horizontal(|ui| self.outcomes(ui, context));
        }
    }

    /// By how much B is faster, on the frame and on the selected rays.
    fn outcomes(&mut self, ui: &mut Ui, context: &Context) {
        ui.set_min_height(HEIGHT);
        let Some((a, b)) = context.baseline_recording().zip(context.recording()) else { return };
        let Selection { baseline, method, queue, recording, .. } = &context.selection;
        if baseline.method == *method && baseline.recording.is_none_or(|at| at == *recording) {
            ui.label("A and B are the same order: choose another one in the table, with shift for A.");
            return;
        }
        let key = ([a.opening, b.opening], [baseline.method.clone(), method.clone()], *queue);
        if [method, &baseline.method].iter().any(|method| *method == WHAT_IF) {
            ui.label("The what-if order is made here and not timed: Methods has its area and SIMD beside the others'.");
            return;
        }
        if self.known.as_ref().is_none_or(|(known, _)| *known != key) {
            self.known = Some((key, context.versus()));
        }
        let Some((_, Some([frame, selected]))) = &self.known else {
            ui.label("The recording is not finished: times are shown once it is (F5 reads it again).");
            return;
        };
        let kinds: Vec<&str> = frame.rays.iter().map(|rays| rays.name()).collect();
        let kinds = match kinds.len() {
            0 => String::new(),
            some if some < RayClass::ALL.len() => format!(" ({} rays alone)", kinds.join(" + ")),
            _ => format!(" ({} rays)", kinds.join(" + ")),
        };
        let frame_of = format!("B over A, whole frame{kinds}");
        outcome(ui, &frame_of, frame, LARGE);
        ui.separator();
        let is_own = baseline.method == UNSORTED && baseline.recording.is_none_or(|at| at == *recording);
        let order = b.times_of(*queue).and_then(|queue| queue.order(method));
        if is_own && order.is_some_and(OrderAnalysis::is_left_alone) {
            ui.label(format!("{method} left these rays alone: A and B are the same order."));
            return;
        }
        outcome(
            ui,
            &format!("B over A, bounce {}, {} rays", queue.bounce, queue.kind.name()),
            selected,
            SMALLER,
        );
    }
}

/// Which rays of which recording.
fn rays(ui: &mut Ui, context: &mut Context) {
    let Some(recording) = context.recording() else { return };
    ui.label("Recording");
    let mut at = context.selection.recording;
    let open = context.recordings.iter().enumerate();
    let open = open.map(|(at, open)| (at, open.label.clone(), Some(open.dump.root().display().to_string())));
    ui.scope(|ui| choose(ui, ("recording", &recording.label), &mut at, open.collect::<Vec<_>>()))
        .response
        .on_hover_text(facts(recording));
    let now = context.selection.queue;
    let mut next = now;
    let bounces: BTreeSet<u32> = recording.queues().iter().map(|record| record.id.bounce).collect();
    let bounces = bounces.into_iter().map(|bounce| (bounce.to_string(), QueueId { bounce, ..now }));
    let kinds = Kind::ALL.into_iter().map(|kind| (kind.name().to_owned(), QueueId { kind, ..now }));
    let passes: BTreeSet<u32> = recording.queues().iter().map(|record| record.id.pass).collect();
    let passes = passes.into_iter().map(|pass| (pass.to_string(), QueueId { pass, ..now }));
    let rows = [
        (
            "Bounce",
            "0: the camera's rays; 1: those that leave the first surface",
            bounces.collect::<Vec<_>>(),
        ),
        (
            "Rays",
            "closest: those that look for the nearest hit; shadow: those that ask for a light",
            kinds.collect(),
        ),
        (
            "Pass",
            "Each pass has another sample of every pixel; methods are measured in the last",
            passes.collect(),
        ),
    ];
    for (name, about, choices) in rows.into_iter().filter(|(_, _, choices)| choices.len() > 1) {
        ui.add_space(8.0);
        ui.label(name).on_hover_text(about);
        for (text, choice) in choices {
            let button = egui::Button::selectable(choice == now, text);
            if ui.add_enabled(recording.queue(choice).is_some(), button).clicked() {
                next = choice;
            }
        }
    }
    if at != context.selection.recording {
        context.select_recording(at);
    } else if next != now {
        context.go_to(next);
    }
}

/// What was recorded, and on what.
fn facts(recording: &Recording) -> String {
    let header = &recording.shown;
    let options = &header.options;
    let size = match recording.is_imported() && options.height == 1 {
        true => "imported rays".to_owned(),
        false => format!("{} × {} pixels", options.width, options.height),
    };
    let triangles = counted(header.scene.triangles, "triangle", "triangles");
    let keys = format!("keys of {} bits", options.key_bits);
    let traced = format!("traced by {} on {}", options.trace_kernel, header.adapter.name);
    [recording.dump.root().display().to_string(), triangles, size, keys, traced].join("\n")
}

/// Which orders are held against each other.
fn orders(ui: &mut Ui, context: &mut Context) {
    let mut baseline = context.selection.baseline.clone();
    ui.strong("A");
    swatch(ui, context.style_of(&baseline.method));
    if context.recordings.len() > 1 {
        let open = context.recordings.iter().enumerate();
        let own = context.selection.recording;
        let open = open.map(|(at, open)| (Some(at).filter(|at| *at != own), open.label.clone(), None));
        let label = context.baseline_recording().map_or("", |open| open.label.as_str());
        choose(ui, ("recording of A", label), &mut baseline.recording, open.collect::<Vec<_>>());
    }
    let named = |methods: Vec<String>| methods.into_iter().map(|name| (name.clone(), name, None));
    let methods = context.methods_of(baseline.recording.unwrap_or(context.selection.recording));
    let now = baseline.method.clone();
    choose(ui, ("A", &now), &mut baseline.method, named(methods));
    ui.add_space(8.0);
    let mut method = context.selection.method.clone();
    ui.strong("B");
    swatch(ui, context.style_of(&method));
    let now = method.clone();
    choose(ui, ("B", &now), &mut method, named(context.methods()));
    if baseline != context.selection.baseline {
        context.hold_against(baseline.recording, &baseline.method);
    }
    if method != context.selection.method {
        context.order_by(&method);
    }
}

/// A net speedup and that of the trace below it, with their intervals.
fn outcome(ui: &mut Ui, of: &str, versus: &Versus, size: f32) {
    ui.vertical(|ui| {
        ui.spacing_mut().item_spacing.y = 1.0;
        ui.small(of);
        for (line, what, about, size) in [
            (&versus.net, "net", "With all that sorting costs: key, sort, gather, scatter", size),
            (
                &versus.trace,
                "trace",
                "Tracing gathered rays alone; net may trace them through indices",
                0.7 * size,
            ),
        ] {
            ui.horizontal(|ui| speedup(ui, line, (what, about), size));
        }
    });
}

fn speedup(ui: &mut Ui, line: &Metric<SpeedupLine>, (what, about): (&str, &str), size: f32) {
    let theme = Theme::of(ui.ctx());
    match line {
        Metric::Known(line) => {
            let colour = theme.verdict(line.verdict).unwrap_or(ui.visuals().strong_text_color());
            ui.label(RichText::new(times(line.ratio)).size(size).color(colour));
            ui.label(what);
            let said = match line.verdict {
                Verdict::Faster | Verdict::Slower => String::new(),
                verdict => format!(" {}", verdict.words()),
            };
            ui.label(line.speedup().interval_text() + &said)
        }
        Metric::Missing { missing } => {
            ui.label(RichText::new("\u{2013}").size(size));
            ui.label(what);
            ui.weak(missing)
        }
    }
    .on_hover_text(about);
}
