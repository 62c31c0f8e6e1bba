//! Trace and net speedup per scene and method, trace speedup per kernel and method: the whole frame, and its bounces.

use formats::key::method::UNSORTED;
use formats::manifest::Stage;
use formats::metrics::speedup::geometric_mean;

use super::building::{
    figure, in_rows, methods, methods_in_rows, of, of_method, reason, recordings, rows_of, settings,
};
use super::headline::rate;
use super::{Findings, Made};
use crate::analysis::summary::{MeanSpeedup, RayClass, distinct};
use crate::analysis::timing::SpeedupLine;
use crate::analysis::{FrameAnalysis, Metric, OrderAnalysis, QueueAnalysis, RecordingAnalysis};
use crate::figures::model::{Axis, Of, Point, Series};

/// What a speedup counts of the time in another order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Counted {
    /// The trace alone.
    Trace,
    /// All that tracing in that order takes.
    Everything,
}

impl Counted {
    fn of_queue(self, order: &OrderAnalysis) -> &Metric<SpeedupLine> {
        match self {
            Self::Trace => &order.trace_speedup,
            Self::Everything => &order.net_speedup,
        }
    }

    fn of_frame<'a>(
        self,
        recording: &'a RecordingAnalysis,
        rays: RayClass,
        method: &str,
    ) -> Option<&'a SpeedupLine> {
        let FrameAnalysis { trace_speedup, net_speedup, .. } = recording.frame(rays, method)?;
        match self {
            Self::Trace => trace_speedup.known(),
            Self::Everything => net_speedup.known(),
        }
    }
}

/// How to read such a figure.
const READING: &str = "Each marker is the whole frame: times of unsorted rays over those in the order, both summed over all bounces, round by round; the thick line is the 95 % interval of that ratio, by bootstrap over six rounds or more. Small dots are the bounces by themselves";

/// The same where there are several recordings.
const OVER_SCENES: &str = "Of several recordings markers are geometric means, of methods that all of them have, and small dots the recordings";

/// Unsorted trace over sorted trace.
pub fn trace(findings: &Findings<'_>) -> Made {
    let words = Words {
        title: "Trace speedup per scene and method",
        axis: "trace speedup",
        reference: "unsorted",
        what: "Trace time of unsorted rays over that of sorted rays, without the cost of sorting: gathered ones, but of auto as it has them traced",
    };
    speedups(findings, Counted::Trace, &words)
}

/// Recordings that have panels of their own; of more the means alone are readable, with a dot for each scene.
const MOST_DETAILED: usize = 3;

/// Unsorted trace over everything that sorting takes.
pub fn net(findings: &Findings<'_>) -> Made {
    let words = Words {
        title: "Net speedup per scene and method",
        axis: "net speedup",
        reference: "break-even",
        what: "Trace time of unsorted rays over all that tracing in another order takes: keys, sort, gather, trace and scatter or trace through indices, accumulate, and deciding where auto does",
    };
    speedups(findings, Counted::Everything, &words)
}

struct Words {
    title: &'static str,
    axis: &'static str,
    reference: &'static str,
    what: &'static str,
}

fn speedups(findings: &Findings<'_>, counted: Counted, words: &Words) -> Made {
    let recordings = recordings(findings);
    let configurations = distinct(recordings.iter().map(|recording| recording.configuration.as_str()));
    let (mut panels, mut has_frames) = (Vec::new(), false);
    for configuration in &configurations {
        let same = recordings.iter().filter(|recording| recording.configuration == *configuration);
        let same: Vec<&RecordingAnalysis> = same.copied().collect();
        let title = |of: &str, rays: RayClass| {
            let machine = if configurations.len() > 1 { format!(", {configuration}") } else { String::new() };
            format!("{of}{} rays{machine}", rays.name())
        };
        // Panels of both kinds of rays stand beside each other, with the same rows, unless there are no others.
        let is_single = same.len() == 1 && configurations.len() == 1;
        let both = |name: &str, series: [Vec<Series>; 2]| {
            let shared = rows_of(findings, &series.concat());
            RayClass::ALL
                .into_iter()
                .zip(series)
                .map(move |(rays, series)| {
                    let rows = if is_single { rows_of(findings, &series) } else { shared.clone() };
                    in_rows(&rows, title(name, rays), Axis::ratios(words.axis), series)
                })
                .collect::<Vec<_>>()
        };
        if same.len() > 1 {
            let means = RayClass::ALL.map(|rays| means(findings, &same, rays, counted));
            panels.extend(both("All recordings: ", means));
        }
        let are_too_many = same.len() > 1 && recordings.len() > MOST_DETAILED;
        let detailed = if are_too_many { &[] } else { same.as_slice() };
        has_frames |= !detailed.is_empty();
        for recording in detailed {
            let of = if same.len() > 1 { format!("{}: ", recording.label) } else { String::new() };
            let totals = RayClass::ALL.map(|rays| totals(findings, recording, rays, counted));
            panels.extend(both(&of, totals));
        }
    }
    let panels = panels.into_iter().map(|panel| panel.with_reference(words.reference, 1.0));
    let reading = match (has_frames, recordings.len() > configurations.len()) {
        (true, false) => READING.to_owned(),
        (true, true) => format!("{READING}. {OVER_SCENES}"),
        (false, _) => format!("{OVER_SCENES}, by times summed over all bounces, round by round"),
    };
    let caption = format!(
        "{}. {reading}. Secondary rays are closest rays of bounces ≥ 1. The control is canonical order through the same stages: what its trace misses 1 by is the instrument's error, and net it has the cost of gather and scatter. None is given for two-point-real, which must trace the rays before it can sort them, nor, by recording, for auto where it left all of them alone: in a mean it counts there with what unsorted rays measured under its name.",
        words.what
    );
    let reason = reason(
        findings,
        move |order| counted.of_queue(order),
        "no method was measured on secondary or shadow rays",
    );
    figure(words.title, caption, settings(recordings), panels, reason)
}

/// The totals of a recording and the speedups of its bounces, a series each for each method.
fn totals(
    findings: &Findings<'_>,
    recording: &RecordingAnalysis,
    rays: RayClass,
    counted: Counted,
) -> Vec<Series> {
    let point = |line: &SpeedupLine, bounce, method: &str| {
        number(line.ratio, line.interval, line.n, of(recording, rays.name(), bounce, method))
    };
    let total = |method: &str| {
        let line = counted.of_frame(recording, rays, method)?;
        Some(of_method(findings, method, vec![point(line, None, method)]))
    };
    let bounces = |method: &str| {
        let bounce = |queue: &QueueAnalysis| {
            let line = counted.of_queue(queue.order(method)?).known()?;
            Some(point(line, Some(queue.bounce), method))
        };
        let points = recording.measured_of(rays).filter_map(bounce).collect();
        Series { is_part: true, ..of_method(findings, method, points) }
    };
    let is_order = |method: &&str| {
        let is_left_alone = recording.frame(rays, method).is_some_and(|frame| frame.left_alone);
        *method != UNSORTED && !is_left_alone
    };
    let sorted: Vec<&str> = methods(findings).into_iter().filter(is_order).collect();
    sorted
        .iter()
        .filter_map(|method| total(method))
        .chain(sorted.iter().map(|method| bounces(method)))
        .collect()
}

/// Geometric means of the totals of several recordings, where all have one, and those totals: means over other
/// recordings would not be comparable.
fn means(
    findings: &Findings<'_>,
    recordings: &[&RecordingAnalysis],
    rays: RayClass,
    counted: Counted,
) -> Vec<Series> {
    let orders: Vec<&str> = methods(findings).into_iter().filter(|method| *method != UNSORTED).collect();
    let has_any = |recording: &&&RecordingAnalysis| {
        orders.iter().any(|method| counted.of_frame(recording, rays, method).is_some())
    };
    let all = recordings.iter().filter(has_any).count();
    let mean_and_scenes = |method: &str| -> Option<[Series; 2]> {
        let totals = recordings
            .iter()
            .filter_map(|recording| Some((recording, counted.of_frame(recording, rays, method)?)));
        let totals: Vec<_> = totals.collect();
        let mean = MeanSpeedup::of(totals.iter().map(|(_, line)| *line))?;
        let scenes = totals.iter().map(|(recording, line)| {
            number(line.ratio, line.interval, line.n, of(recording, rays.name(), None, method))
        });
        let parts = Series { is_part: true, ..of_method(findings, method, scenes.collect()) };
        let (kind, method) = (rays.name().to_owned(), method.to_owned());
        let point = number(mean.mean, None, mean.n, Of { kind, method, ..Of::detail("all scenes") });
        let points = if mean.n == all { vec![point] } else { Vec::new() };
        Some([Series { points, is_part: false, ..parts.clone() }, parts])
    };
    orders.iter().copied().filter_map(mean_and_scenes).flatten().collect()
}

/// A number whose row is found later.
fn number(y: f64, spread: Option<(f64, f64)>, n: usize, of: Of) -> Point {
    Point { x: 0.0, y, spread, n, of }
}

/// Unsorted rays of a recording traced a second, millions.
fn unsorted_rate(recording: &RecordingAnalysis, rays: RayClass) -> Option<f64> {
    let unsorted = recording.frame(rays, UNSORTED)?;
    let trace = unsorted.stages.iter().find(|found| found.stage == Stage::Trace)?;
    let all: u64 = recording.measured_of(rays).map(|queue| queue.rays).sum();
    Some(all as f64 / trace.median_ns * 1e3)
}

/// Trace speedup by kernel, of scenes that several kernels traced: a panel per kernel, machine and kind of rays, with
/// means over recordings where there are several.
pub fn kernels(findings: &Findings<'_>) -> Made {
    let recordings = recordings(findings);
    let is_compared = |recording: &RecordingAnalysis| {
        let mut same_scene = recordings.iter().filter(|other| other.scene == recording.scene);
        same_scene.any(|other| other.options.trace_kernel != recording.options.trace_kernel)
    };
    let compared: Vec<&RecordingAnalysis> =
        recordings.iter().copied().filter(|recording| is_compared(recording)).collect();
    let kernels = distinct(compared.iter().map(|recording| recording.options.trace_kernel.as_str()));
    let configurations = distinct(compared.iter().map(|recording| recording.configuration.as_str()));
    let (mut panels, mut rates) = (Vec::new(), Vec::new());
    for configuration in &configurations {
        let same = compared.iter().copied().filter(|recording| recording.configuration == *configuration);
        let same: Vec<&RecordingAnalysis> = same.collect();
        let is_named = kernels.len() == configurations.len();
        let name = if is_named { &same[0].options.trace_kernel } else { *configuration };
        for rays in RayClass::ALL {
            let unsorted = geometric_mean(same.iter().filter_map(|recording| unsorted_rate(recording, rays)));
            rates.extend(
                unsorted.map(|unsorted| format!("{name} {} of {} rays", rate(unsorted), rays.name())),
            );
            let (label, paper) = match rays {
                RayClass::Secondary => ("Meister et al. 2020, secondary rays: 1.41×", 1.41),
                RayClass::Shadow => ("Meister et al. 2020, shadow rays: 2.21×", 2.21),
            };
            let series = match same.as_slice() {
                [recording] => totals(findings, recording, rays, Counted::Trace),
                several => means(findings, several, rays, Counted::Trace),
            };
            let title = format!("{name}: {} rays", rays.name());
            let panel = methods_in_rows(findings, title, Axis::ratios("trace speedup"), series);
            panels.push(panel.with_reference(label, paper));
        }
    }
    let caption = format!(
        "Trace time of unsorted rays over that of sorted rays, without the cost of sorting, by trace kernel. A gain over a kernel that is slower to begin with may be none over a faster one: unsorted Mrays/s are {}. {READING}. {OVER_SCENES}. The dashed line is what Meister et al. 2020, \"On Ray Reordering Techniques for Faster GPU Ray Tracing\", give as the mean of their software kernel (CUDA, RTX 2080 Ti, scenes of their own).",
        rates.join(", ")
    );
    figure(
        "Trace speedup per kernel and method",
        caption,
        settings(compared),
        panels,
        "it takes two or more trace kernels on one scene: replay a recording with another --trace",
    )
}
