//! Achieved bandwidth per stage and method.

use formats::manifest::Stage;

use super::building::{by_method, figure, methods, of, recordings, settings};
use super::{Findings, Made};
use crate::analysis::RecordingAnalysis;
use crate::analysis::summary::RayClass;
use crate::analysis::timing::stage_name;
use crate::figures::model::{Axis, Content, Of, Panel, Point, Series};
use crate::figures::style::STAGE_STYLES;

/// Bytes that each stage must read and write, over its time.
pub fn bandwidth(findings: &Findings<'_>) -> Made {
    figure(
        "Achieved bandwidth per stage",
        "Bytes that a stage must read and write, over its median time, all secondary and shadow rays of all methods together; small dots are methods. A lower bound: the hierarchy that trace reads is not counted. Sort counts a histogram, a read and a write per 8 bits of the key. It skips passes over digits that all keys share, so that a queue whose keys do is shown faster than memory was; camera rays, whose keys mostly do, are left out.",
        settings(recordings(findings)),
        recordings(findings).into_iter().map(|recording| panel(findings, recording)),
        "no stage of any method was timed",
    )
}

fn panel(findings: &Findings<'_>, recording: &RecordingAnalysis) -> Panel {
    let is_timed =
        |stage: &Stage| methods(findings).iter().any(|method| traffic(recording, method, *stage).is_some());
    let stages: Vec<Stage> = Stage::OF_ORDERS.into_iter().filter(is_timed).collect();
    let of_stages = |methods: &[&str], what: &str| -> Vec<Point> {
        let sum = |stage: Stage| {
            let all = methods.iter().filter_map(|method| traffic(recording, method, stage));
            all.reduce(|one, other| Traffic {
                bytes: one.bytes + other.bytes,
                ns: one.ns + other.ns,
                n: one.n + other.n,
            })
        };
        let point = |(place, stage): (usize, &Stage)| {
            let Traffic { bytes, ns, n } = sum(*stage)?;
            let of = Of { detail: stage_name(*stage).to_owned(), ..of(recording, "", None, what) };
            // Bytes a nanosecond are gigabytes a second.
            Some(Point::new(place as f64, bytes / ns, n, of))
        };
        stages.iter().enumerate().filter_map(point).collect()
    };
    let all = of_stages(&methods(findings), "");
    let all = Series::new("", STAGE_STYLES, all);
    let parts = by_method(findings, |method| of_stages(&[method], method));
    let parts = parts.into_iter().map(|series| Series { is_part: true, ..series });
    Panel::new(
        if findings.analysis.recordings.len() > 1 { recording.label.as_str() } else { "" },
        Axis::categories("", stages.iter().map(|stage| stage_name(*stage))),
        Axis::logarithmic("bandwidth (GB/s)", 10),
        Content::Dots(parts.chain([all]).collect()),
    )
}

/// What a stage of a method moved, over all queues.
struct Traffic {
    bytes: f64,
    ns: f64,
    n: usize,
}

/// `None` if the stage was not timed, or what it moves is not known.
fn traffic(recording: &RecordingAnalysis, method: &str, stage: Stage) -> Option<Traffic> {
    let mut sum = Traffic { bytes: 0.0, ns: 0.0, n: 0 };
    for queue in recording.measured().filter(|queue| RayClass::of(queue).is_some()) {
        let Some(found) = queue.order(method).and_then(|order| order.stage(stage)) else { continue };
        let Some(bytes_per_ray) = found.bytes_per_ray else { continue };
        sum.bytes += bytes_per_ray as f64 * queue.rays as f64;
        sum.ns += found.time.median_ns;
        sum.n += found.time.samples_ns.len();
    }
    (sum.ns > 0.0).then_some(sum)
}
