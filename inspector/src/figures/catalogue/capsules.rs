//! Capsule area against trace time, and its distribution.

use formats::metrics::correlation::Correlation;
use formats::ray::Kind;

use super::building::{
    figure, kind_title, linear, logarithmic, methods, of_method, order, panel_title, reason, recordings,
    settings,
};
use super::{Material, Skipped};
use crate::analysis::correlations::{AreaAndTime, correlation, points};
use crate::analysis::summary::distinct;
use crate::analysis::{Metric, QueueAnalysis, RecordingAnalysis};
use crate::figures::model::{Content, Figure, Panel, Point, Series};

/// Mean capsule area of each order against the time that its trace takes.
pub fn against_time(material: &Material<'_>) -> Result<Figure, Skipped> {
    let recordings = &material.analysis.recordings;
    let configurations = distinct(recordings.iter().map(|recording| recording.configuration.as_str()));
    let (mut panels, mut found) = (Vec::new(), Vec::new());
    for configuration in &configurations {
        let same = recordings.iter().filter(|recording| recording.configuration == *configuration);
        let points: Vec<AreaAndTime<'_>> = same.flat_map(points).collect();
        for kind in Kind::ALL {
            let rays = if configurations.len() > 1 {
                format!("{}, {configuration}", kind_title(kind))
            } else {
                kind_title(kind)
            };
            let correlation = correlation(&points, Some(kind));
            found.push(format!("{rays}: {}", coefficients(&correlation)));
            panels.push(scatter(material, &points, kind, format!("{rays}: {}", coefficients(&correlation))));
        }
    }
    if recordings.len() > 1 {
        for line in &material.analysis.correlations {
            let of_recording = recordings.iter().any(|recording| recording.label == line.of);
            let kind = line.kind.filter(|_| of_recording && line.correlation.known().is_some());
            found.extend(kind.map(|kind| {
                format!("{}, {}: {}", line.of, kind_title(kind), coefficients(&line.correlation))
            }));
        }
    }
    let parts = Figure {
        name: "capsule-area".to_owned(),
        title: "Mean capsule area against trace time".to_owned(),
        caption: format!(
            "Each marker is one order of one queue (scene, bounce, method): the mean area of the capsules around groups of {} rays, weighted by rays, in unit space, against the median trace time of a ray. Correlation: {}.",
            material.analysis.group_width,
            found.join("; ")
        ),
        settings: settings(material),
        panels,
    };
    figure(parts, reason(material, |order| &order.coherence, "no trace was timed"))
}

fn coefficients(correlation: &Metric<Correlation>) -> String {
    match correlation {
        Metric::Known(Correlation { pearson, spearman, n }) => {
            format!("Pearson {pearson:.2}, Spearman {spearman:.2}, n = {n}").replace('-', "−")
        }
        Metric::Missing { .. } => "too few orders for a coefficient".to_owned(),
    }
}

fn scatter(material: &Material<'_>, points: &[AreaAndTime<'_>], kind: Kind, title: String) -> Panel {
    // Variants go by the method that they are variants of.
    let bases = distinct(points.iter().map(|point| point.base));
    let series = |base: &str| -> Series {
        let own = points.iter().filter(|point| point.kind == kind && point.base == base);
        let points = own.map(|point| Point {
            x: point.mean_capsule_area,
            y: point.ns_per_ray,
            spread: (point.n > 1).then_some(point.quartiles_ns_per_ray),
            n: point.n,
            name: format!("{}, bounce {}, {kind}, {}", point.recording, point.bounce, point.method),
        });
        of_method(material, base, points.collect())
    };
    Panel {
        title,
        x: logarithmic("mean capsule area (unit space)", 10),
        y: linear("trace time per ray (ns)", true),
        content: Content::Scatter(bases.into_iter().map(series).collect()),
        references: Vec::new(),
    }
}

/// Which share of the rays is in capsules of at most some area: bounce 1, or the first that there is.
pub fn distribution(material: &Material<'_>) -> Result<Figure, Skipped> {
    let mut panels = Vec::new();
    for kind in Kind::ALL {
        for recording in recordings(material) {
            let of_kind = || recording.measured().filter(|queue| queue.kind == kind);
            let queue = of_kind().find(|queue| queue.bounce == 1).or_else(|| of_kind().next());
            panels.extend(queue.map(|queue| shares(material, recording, queue)));
        }
    }
    let parts = Figure {
        name: "capsule-area-distribution".to_owned(),
        title: "Share of rays by the area of their group's capsule".to_owned(),
        caption: format!(
            "Share of the rays whose group of {} has a capsule of at most this area, in unit space. The farther left a curve, the more coherent the order.",
            material.analysis.group_width
        ),
        settings: settings(material),
        panels,
    };
    figure(parts, reason(material, |order| &order.coherence, "no queue was measured"))
}

fn shares(material: &Material<'_>, recording: &RecordingAnalysis, queue: &QueueAnalysis) -> Panel {
    let points = |method: &str| -> Option<Vec<Point>> {
        let coherence = order(queue, method)?.coherence.known()?;
        let shares = coherence.area_quantiles.iter().enumerate().filter(|(_, area)| **area > 0.0);
        let point = |(percent, &area): (usize, &f64)| Point {
            x: area,
            y: percent as f64,
            spread: None,
            n: queue.rays as usize,
            name: format!("{}, bounce {}, {}, {method}", recording.label, queue.bounce, queue.kind),
        };
        Some(shares.map(point).collect())
    };
    let series = |method: &str| of_method(material, method, points(method).unwrap_or_default());
    let rays = format!("{}, bounce {}", queue.kind, queue.bounce);
    Panel {
        title: panel_title(material, recording, &rays),
        x: logarithmic("capsule area (unit space)", 10),
        y: linear("share of rays (%)", true),
        content: Content::Lines(methods(material).into_iter().map(series).collect()),
        references: Vec::new(),
    }
}
