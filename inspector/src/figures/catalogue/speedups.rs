//! Trace and net speedup per scene and method.

use super::building::{
    categories, figure, linear, methods, of_method, order, queues, rays_title, reason, recordings, settings,
};
use super::{Material, Skipped};
use crate::analysis::summary::{MeanSpeedup, Rays, distinct};
use crate::analysis::timing::SpeedupLine;
use crate::analysis::{Metric, OrderAnalysis, RecordingAnalysis};
use crate::figures::model::{Content, Figure, Panel, Point, Reference, Series};

type Speedup = fn(&OrderAnalysis) -> &Metric<SpeedupLine>;

/// Unsorted trace over sorted trace.
pub fn trace(material: &Material<'_>) -> Result<Figure, Skipped> {
    speedups(
        material,
        |order| &order.trace_speedup,
        &Words {
            name: "trace-speedup",
            title: "Trace speedup",
            axis: "trace speedup (×)",
            reference: "unsorted",
            what: "Trace time of unsorted rays over that of sorted rays, without the cost of sorting",
        },
    )
}

/// Unsorted trace over everything that sorting takes.
pub fn net(material: &Material<'_>) -> Result<Figure, Skipped> {
    speedups(
        material,
        |order| &order.net_speedup,
        &Words {
            name: "net-speedup",
            title: "Net speedup",
            axis: "net speedup (×)",
            reference: "break-even",
            what: "Trace time of unsorted rays over all that tracing in another order takes: keys, sort, gather and trace or trace through indices, and accumulate",
        },
    )
}

struct Words {
    name: &'static str,
    title: &'static str,
    axis: &'static str,
    reference: &'static str,
    what: &'static str,
}

fn speedups(material: &Material<'_>, speedup: Speedup, words: &Words) -> Result<Figure, Skipped> {
    let recordings = recordings(material);
    let configurations = distinct(recordings.iter().map(|recording| recording.configuration.as_str()));
    let mut panels = Vec::new();
    for configuration in &configurations {
        for rays in Rays::ALL {
            let same: Vec<&RecordingAnalysis> = recordings
                .iter()
                .copied()
                .filter(|recording| recording.configuration == *configuration)
                .collect();
            let title = if configurations.len() > 1 {
                format!("{}, {configuration}", rays_title(rays))
            } else {
                rays_title(rays)
            };
            panels.push(panel(material, &same, rays, speedup, words, title));
        }
    }
    let parts = Figure {
        name: words.name.to_owned(),
        title: format!("{} per scene and method", words.title),
        caption: format!(
            "{}. Geometric means over bounces; whiskers reach from the lowest to the highest bounce. Secondary rays are closest rays of bounces ≥ 1. None is given for two-point-real, which must trace the rays before it can sort them.",
            words.what
        ),
        settings: settings(material),
        panels,
    };
    figure(parts, reason(material, speedup, "no method was measured on secondary or shadow rays"))
}

fn panel(
    material: &Material<'_>,
    recordings: &[&RecordingAnalysis],
    rays: Rays,
    speedup: Speedup,
    words: &Words,
    title: String,
) -> Panel {
    let mut names: Vec<&str> = recordings.iter().map(|recording| recording.label.as_str()).collect();
    names.extend((recordings.len() > 1).then_some("all"));
    let point = |place: usize, method: &str, recordings: &[&RecordingAnalysis]| -> Option<Point> {
        let lines = recordings
            .iter()
            .flat_map(|recording| queues(recording, rays))
            .filter_map(|queue| speedup(order(queue, method)?).known());
        let mean = MeanSpeedup::of(lines)?;
        Some(Point {
            x: place as f64,
            y: mean.mean,
            spread: (mean.n > 1).then_some((mean.lowest, mean.highest)),
            n: mean.n,
            name: format!("{}, {}, {method}", names[place], rays.name()),
        })
    };
    let series = |method: &str| -> Series {
        let alone = recordings.iter().enumerate();
        let mut points: Vec<Point> =
            alone.filter_map(|(place, &recording)| point(place, method, &[recording])).collect();
        points.extend((recordings.len() > 1).then(|| point(recordings.len(), method, recordings)).flatten());
        of_method(material, method, points)
    };
    Panel {
        title,
        x: categories("scene", names.iter().copied()),
        y: linear(words.axis, true),
        content: Content::Bars(methods(material).into_iter().map(series).collect()),
        references: vec![Reference { label: words.reference.to_owned(), y: 1.0, span: None }],
    }
}
