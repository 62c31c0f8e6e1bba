//! Rays traced a second, per bounce and method.

use formats::manifest::Stage;
use formats::ray::Kind;

use super::building::{by_method, each, figure, panel_title, rate, recordings, settings};
use super::{Findings, Made};
use crate::analysis::{QueueAnalysis, RecordingAnalysis};
use crate::figures::model::{Axis, Content, Panel, Point};

/// Trace rate per bounce and method.
pub fn rays_per_second(findings: &Findings<'_>) -> Made {
    let panel = |recording, kind| panel(findings, recording, kind);
    figure(
        "Trace rate per bounce and method",
        "Million rays traced a second, the cost of sorting not included: medians, whiskers from the first to the third quartile of the repeats. Bounce 0 of closest rays are camera rays.",
        settings(findings),
        each(Kind::ALL, &recordings(findings), panel),
        "no trace was timed",
    )
}

fn panel(findings: &Findings<'_>, recording: &RecordingAnalysis, kind: Kind) -> Panel {
    let queues = || recording.measured().filter(|queue| queue.kind == kind);
    let points = |method: &str| queues().filter_map(|queue| point(recording, queue, method)).collect();
    Panel::new(
        panel_title(findings, recording, &format!("{kind} rays")),
        Axis::from_zero("bounce"),
        Axis::from_zero("trace rate (Mrays/s)"),
        Content::Lines(by_method(findings, points)),
    )
}

fn point(recording: &RecordingAnalysis, queue: &QueueAnalysis, method: &str) -> Option<Point> {
    let samples_ns = &queue.order(method)?.stage(Stage::Trace)?.time.samples_ns;
    let name = format!("{}, bounce {}, {}, {method}", recording.label, queue.bounce, queue.kind);
    rate(queue.bounce.into(), queue.rays, samples_ns, name)
}
