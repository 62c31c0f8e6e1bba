//! What each stage of a method takes, against the trace that it is to make faster.

use formats::key::method::UNSORTED;
use formats::manifest::Stage;

use super::building::{
    categories, figure, linear, methods, order, panel_title, queues, rays_title, recordings, settings,
};
use super::{Material, Skipped};
use crate::analysis::summary::Rays;
use crate::analysis::timing::STAGES;
use crate::analysis::{QueueAnalysis, RecordingAnalysis};
use crate::figures::model::{Content, Figure, Panel, Point, Reference, Series};

/// Time of each stage per method, stacked.
pub fn overhead(material: &Material<'_>) -> Result<Figure, Skipped> {
    let mut panels = Vec::new();
    for rays in Rays::ALL {
        for recording in recordings(material) {
            panels.push(panel(material, recording, rays));
        }
    }
    let parts = Figure {
        name: "overhead".to_owned(),
        title: "Where the time goes, per method".to_owned(),
        caption: "Median times of the stages, summed over bounces. Gather, trace and scatter count, or the trace through indices: what the recording chose for the method. A method whose stack stays below the line, the trace of unsorted rays, pays off.".to_owned(),
        settings: settings(material),
        panels,
    };
    figure(parts, "no stage of any method was timed")
}

fn panel(material: &Material<'_>, recording: &RecordingAnalysis, rays: Rays) -> Panel {
    let measured: Vec<&QueueAnalysis> = queues(recording, rays).collect();
    let has_method = |method: &&str| measured.iter().any(|queue| order(queue, method).is_some());
    let methods: Vec<&str> = methods(material).into_iter().filter(has_method).collect();
    let series = |(style, stage): (usize, Stage)| -> Series {
        let points = methods.iter().enumerate().filter_map(|(place, method)| {
            let (ns, n) = stage_time(&measured, method, stage)?;
            let name = format!("{}, {}, {method}, {}", recording.label, rays.name(), words(stage));
            Some(Point { x: place as f64, y: ns / 1e6, spread: None, n, name })
        });
        Series { label: words(stage).to_owned(), style, points: points.collect() }
    };
    let unsorted = stage_time(&measured, UNSORTED, Stage::Trace);
    let reference = unsorted.map(|(ns, _)| Reference {
        label: "break-even: trace of unsorted rays".to_owned(),
        y: ns / 1e6,
        span: None,
    });
    Panel {
        title: panel_title(material, recording, &rays_title(rays)),
        x: categories("method", methods.iter().copied()),
        y: linear("time (ms)", true),
        content: Content::Stacks(STAGES.into_iter().enumerate().map(series).collect()),
        references: reference.into_iter().collect(),
    }
}

/// Sum over queues of a stage's median times, and its samples; `None` if it is not part of the way taken.
fn stage_time(queues: &[&QueueAnalysis], method: &str, stage: Stage) -> Option<(f64, usize)> {
    let orders = queues.iter().filter_map(|queue| order(queue, method));
    let times: Vec<(f64, usize)> = orders
        .filter(|order| order.way.counts(stage))
        .filter_map(|order| {
            let time = &order.stages.iter().find(|found| found.stage == stage)?.time;
            Some((time.median_ns, time.samples_ns.len()))
        })
        .collect();
    let ns = times.iter().map(|(ns, _)| ns).sum();
    Some((ns, times.iter().map(|(_, n)| *n).min()?))
}

/// What a stage is called in legends.
pub fn words(stage: Stage) -> &'static str {
    match stage {
        Stage::TraceIndirect => "trace through indices",
        other => other.name(),
    }
}
