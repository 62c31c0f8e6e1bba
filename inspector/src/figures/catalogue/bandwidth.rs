//! Achieved bandwidth per stage and method.

use formats::manifest::Stage;

use super::building::{by_method, figure, range, recordings, settings};
use super::overhead::stage_name;
use super::{Findings, Made};
use crate::analysis::RecordingAnalysis;
use crate::analysis::summary::RayClass;
use crate::analysis::timing::STAGES;
use crate::figures::model::{Axis, Content, Panel, Point};

/// Bytes that each stage must read and write, over its time.
pub fn bandwidth(findings: &Findings<'_>) -> Made {
    figure(
        "Achieved bandwidth per stage",
        "Bytes that a stage must read and write, over its median time, all secondary and shadow rays together; whiskers are the lowest and highest queue. A lower bound: the hierarchy that trace reads is not counted. Sort counts a histogram, a read and a write per 8 bits of the key. It skips passes over digits that all keys share, so that a queue whose keys do is shown faster than memory was; camera rays, whose keys mostly do, are left out.",
        settings(findings),
        recordings(findings).into_iter().map(|recording| panel(findings, recording)),
        "no stage of any method was timed",
    )
}

fn panel(findings: &Findings<'_>, recording: &RecordingAnalysis) -> Panel {
    let points = |method: &str| {
        let stages = STAGES.into_iter().enumerate();
        stages.filter_map(|(place, stage)| point(recording, method, stage, place)).collect()
    };
    Panel::new(
        if findings.analysis.recordings.len() > 1 { recording.label.as_str() } else { "" },
        Axis::categories("stage", STAGES.map(stage_name)),
        Axis::logarithmic("bandwidth (GB/s)", 10),
        Content::Bars(by_method(findings, points)),
    )
}

fn point(recording: &RecordingAnalysis, method: &str, stage: Stage, place: usize) -> Option<Point> {
    let (mut bytes, mut ns, mut n) = (0.0, 0.0, 0);
    let mut each = Vec::new();
    for queue in recording.measured().filter(|queue| RayClass::of(queue).is_some()) {
        let Some(found) = queue.order(method).and_then(|order| order.stage(stage)) else { continue };
        let Some(bytes_per_ray) = found.bytes_per_ray else { continue };
        bytes += bytes_per_ray as f64 * queue.rays as f64;
        ns += found.time.median_ns;
        n += found.time.samples_ns.len();
        each.extend(found.bytes_per_second.map(|rate| rate / 1e9));
    }
    let name = format!("{}, {method}, {}", recording.label, stage_name(stage));
    // Bytes a nanosecond are gigabytes a second.
    (ns > 0.0).then(|| Point { x: place as f64, y: bytes / ns, spread: range(&each), n, name })
}
