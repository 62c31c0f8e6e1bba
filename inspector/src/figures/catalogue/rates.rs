//! Rays traced a second, per bounce and method, over those of unsorted rays.

use formats::key::method::UNSORTED;
use formats::manifest::Stage;
use formats::ray::Kind;

use super::building::{by_method, each, figure, of, panel_title, recordings, settings};
use super::{Findings, Made};
use crate::analysis::{QueueAnalysis, RecordingAnalysis};
use crate::figures::model::{Axis, Content, Panel, Point};

/// Trace rate per bounce and method.
pub fn rays_per_second(findings: &Findings<'_>) -> Made {
    let panel = |recording, kind| panel(findings, recording, kind);
    figure(
        "Trace rate per bounce and method, over that of unsorted rays",
        caption(findings),
        settings(recordings(findings)),
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
        Axis::ratios("rate over unsorted"),
        Content::Lines(by_method(findings, points)),
    )
    .with_reference("unsorted", 1.0)
}

fn point(recording: &RecordingAnalysis, queue: &QueueAnalysis, method: &str) -> Option<Point> {
    let line = queue.order(method)?.trace_speedup.known()?;
    let of = of(recording, queue.kind, Some(queue.bounce), method);
    Some(Point { x: queue.bounce.into(), y: line.ratio, spread: line.interval, n: line.n, of })
}

/// How to read it, and what 1 stands for.
fn caption(findings: &Findings<'_>) -> String {
    let rates = recordings(findings).into_iter().flat_map(|recording| {
        recording.measured().filter_map(|queue| {
            let time = &queue.order(UNSORTED)?.stage(Stage::Trace)?.time;
            let (of, rate) = (&recording.label, time.mrays_per_second);
            Some(format!("{of}, bounce {}, {}: {rate:.1}", queue.bounce, queue.kind))
        })
    });
    format!(
        "Rays traced a second over those of the same rays unsorted, the cost of sorting not included; 95 % intervals, of six rounds or more, stand in the CSV. Bounce 0 of closest rays are camera rays. Unsorted, Mrays/s: {}.",
        rates.collect::<Vec<_>>().join("; ")
    )
}
