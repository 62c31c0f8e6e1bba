//! Rays traced a second, per bounce and method.

use formats::manifest::Stage;
use formats::ray::Kind;

use super::building::{
    figure, kind_title, linear, methods, of_method, order, panel_title, recordings, settings,
};
use super::{Material, Skipped};
use crate::analysis::{QueueAnalysis, RecordingAnalysis};
use crate::figures::model::{Content, Figure, Panel, Point, Series};

/// Trace rate per bounce and method.
pub fn rays_per_second(material: &Material<'_>) -> Result<Figure, Skipped> {
    let mut panels = Vec::new();
    for kind in Kind::ALL {
        for recording in recordings(material) {
            panels.push(panel(material, recording, kind));
        }
    }
    let parts = Figure {
        name: "rays-per-second".to_owned(),
        title: "Trace rate per bounce and method".to_owned(),
        caption: "Million rays traced a second, the cost of sorting not included: medians, whiskers from the first to the third quartile of the repeats. Bounce 0 of closest rays are camera rays.".to_owned(),
        settings: settings(material),
        panels,
    };
    figure(parts, "no trace was timed")
}

fn panel(material: &Material<'_>, recording: &RecordingAnalysis, kind: Kind) -> Panel {
    let queues: Vec<&QueueAnalysis> = recording.measured().filter(|queue| queue.kind == kind).collect();
    let series = |method: &str| -> Series {
        let points = queues.iter().filter_map(|queue| point(recording, queue, method)).collect();
        of_method(material, method, points)
    };
    Panel {
        title: panel_title(material, recording, &kind_title(kind)),
        x: linear("bounce", true),
        y: linear("trace rate (Mrays/s)", true),
        content: Content::Lines(methods(material).into_iter().map(series).collect()),
        references: Vec::new(),
    }
}

fn point(recording: &RecordingAnalysis, queue: &QueueAnalysis, method: &str) -> Option<Point> {
    let stages = &order(queue, method)?.stages;
    let time = &stages.iter().find(|stage| stage.stage == Stage::Trace)?.time;
    let rate = |ns: f64| queue.rays as f64 / ns.max(f64::MIN_POSITIVE) * 1e3;
    let (fast, slow) = time.quartiles_ns;
    Some(Point {
        x: f64::from(queue.bounce),
        y: time.mrays_per_second,
        spread: (time.samples_ns.len() > 1).then(|| (rate(slow), rate(fast))),
        n: time.samples_ns.len(),
        name: format!("{}, bounce {}, {}, {method}", recording.label, queue.bounce, queue.kind),
    })
}
