//! Achieved bandwidth per stage and method.

use formats::manifest::Stage;

use super::building::{categories, figure, logarithmic, methods, of_method, order, recordings, settings};
use super::overhead::words;
use super::{Material, Skipped};
use crate::analysis::RecordingAnalysis;
use crate::analysis::summary::Rays;
use crate::analysis::timing::STAGES;
use crate::figures::model::{Content, Figure, Panel, Point, Series};

/// Bytes that each stage must read and write, over its time.
pub fn bandwidth(material: &Material<'_>) -> Result<Figure, Skipped> {
    let panels = recordings(material).into_iter().map(|recording| panel(material, recording)).collect();
    let parts = Figure {
        name: "bandwidth".to_owned(),
        title: "Achieved bandwidth per stage".to_owned(),
        caption: "Bytes that a stage must read and write, over its median time, all secondary and shadow rays together; whiskers are the lowest and highest queue. A lower bound: the hierarchy that trace reads is not counted. Sort counts a histogram, a read and a write per 8 bits of the key. It skips passes over digits that all keys share, so that a queue whose keys do is shown faster than memory was; camera rays, whose keys mostly do, are left out.".to_owned(),
        settings: settings(material),
        panels,
    };
    figure(parts, "no stage of any method was timed")
}

fn panel(material: &Material<'_>, recording: &RecordingAnalysis) -> Panel {
    let series = |method: &str| -> Series {
        let stages = STAGES.into_iter().enumerate();
        let points = stages.filter_map(|(place, stage)| point(recording, method, stage, place)).collect();
        of_method(material, method, points)
    };
    Panel {
        title: if material.analysis.recordings.len() > 1 { recording.label.clone() } else { String::new() },
        x: categories("stage", STAGES.map(words)),
        y: logarithmic("bandwidth (GB/s)", 10),
        content: Content::Bars(methods(material).into_iter().map(series).collect()),
        references: Vec::new(),
    }
}

fn point(recording: &RecordingAnalysis, method: &str, stage: Stage, place: usize) -> Option<Point> {
    let (mut bytes, mut ns, mut n) = (0.0, 0.0, 0);
    let mut each = Vec::new();
    for queue in recording.measured().filter(|queue| Rays::of(queue).is_some()) {
        let Some(order) = order(queue, method) else { continue };
        let Some(found) = order.stages.iter().find(|found| found.stage == stage) else { continue };
        let Some(bytes_per_ray) = found.bytes_per_ray else { continue };
        bytes += bytes_per_ray as f64 * queue.rays as f64;
        ns += found.time.median_ns;
        n += found.time.samples_ns.len();
        each.extend(found.bytes_per_second.map(|rate| rate / 1e9));
    }
    let name = format!("{}, {method}, {}", recording.label, words(stage));
    // Bytes a nanosecond are gigabytes a second.
    (ns > 0.0).then(|| Point {
        x: place as f64,
        y: bytes / ns,
        spread: super::building::range(&each),
        n,
        name,
    })
}
