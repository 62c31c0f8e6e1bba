//! Capsule area against trace time, and its distribution.

use formats::metrics::correlation::Correlation;
use formats::ray::Kind;

use super::building::{
    by_label, by_method, each, figure, method_style, panel_title, reason, recordings, settings,
};
use super::{Findings, Made};
use crate::analysis::correlations::{AreaAndTime, correlation, points};
use crate::analysis::summary::distinct;
use crate::analysis::{Metric, RecordingAnalysis};
use crate::figures::model::{Axis, Content, Panel, Point};

/// Mean capsule area of each order against the time that its trace takes.
pub fn against_time(findings: &Findings<'_>) -> Made {
    let recordings = &findings.analysis.recordings;
    let configurations = distinct(recordings.iter().map(|recording| recording.configuration.as_str()));
    let (mut panels, mut found) = (Vec::new(), Vec::new());
    for configuration in &configurations {
        let same = recordings.iter().filter(|recording| recording.configuration == *configuration);
        let points: Vec<AreaAndTime<'_>> = same.flat_map(points).collect();
        for kind in Kind::ALL {
            let mut title = format!("{kind} rays");
            if configurations.len() > 1 {
                title = format!("{title}, {configuration}");
            }
            title = format!("{title}: {}", coefficients(&correlation(&points, Some(kind))));
            found.push(title.clone());
            panels.push(scatter(findings, &points, kind, title));
        }
    }
    if recordings.len() > 1 {
        for line in &findings.analysis.correlations {
            let of_recording = recordings.iter().any(|recording| recording.label == line.of);
            let kind = line.kind.filter(|_| of_recording && line.correlation.known().is_some());
            found.extend(
                kind.map(|kind| format!("{}, {kind} rays: {}", line.of, coefficients(&line.correlation))),
            );
        }
    }
    let caption = format!(
        "Each marker is one order of one queue (scene, bounce, method): the mean area of the capsules around groups of {} rays, weighted by rays, in unit space, against the median trace time of a ray. Correlation: {}.",
        findings.analysis.group_width,
        found.join("; ")
    );
    let reason = reason(findings, |order| &order.coherence, "no trace was timed");
    figure("Mean capsule area against trace time", caption, settings(findings), panels, reason)
}

fn coefficients(correlation: &Metric<Correlation>) -> String {
    match correlation {
        Metric::Known(Correlation { pearson, spearman, n }) => {
            format!("Pearson {pearson:.2}, Spearman {spearman:.2}, n = {n}").replace('-', "−")
        }
        Metric::Missing { .. } => "too few orders for a coefficient".to_owned(),
    }
}

fn scatter(findings: &Findings<'_>, points: &[AreaAndTime<'_>], kind: Kind, title: String) -> Panel {
    let point = |at: &AreaAndTime<'_>| {
        let ((low, high), rays) = (at.trace.quartiles_ns, at.queue.rays as f64);
        let n = at.trace.samples_ns.len();
        (at.queue.kind == kind).then(|| Point {
            x: at.mean_capsule_area,
            y: at.ns_per_ray(),
            spread: (n > 1).then_some((low / rays, high / rays)),
            n,
            name: format!("{}, bounce {}, {kind}, {}", at.recording, at.queue.bounce, at.order.method),
        })
    };
    let all: Vec<&AreaAndTime<'_>> = points.iter().collect();
    // Variants go by the method that they are variants of.
    let series = by_label(&all, |at| &at.order.base, |base| method_style(findings, base), point);
    Panel::new(
        title,
        Axis::logarithmic("mean capsule area (unit space)", 10),
        Axis::from_zero("trace time per ray (ns)"),
        Content::Scatter(series),
    )
}

/// Which share of the rays is in capsules of at most some area: bounce 1, or the first that there is.
pub fn distribution(findings: &Findings<'_>) -> Made {
    let caption = format!(
        "Share of the rays whose group of {} has a capsule of at most this area, in unit space. The farther left a curve, the more coherent the order.",
        findings.analysis.group_width
    );
    figure(
        "Share of rays by the area of their group's capsule",
        caption,
        settings(findings),
        each(Kind::ALL, &recordings(findings), |recording, kind| shares(findings, recording, kind)),
        reason(findings, |order| &order.coherence, "no queue was measured"),
    )
}

fn shares(findings: &Findings<'_>, recording: &RecordingAnalysis, kind: Kind) -> Panel {
    let of_kind = || recording.measured().filter(|queue| queue.kind == kind);
    let queue = of_kind().find(|queue| queue.bounce == 1).or_else(|| of_kind().next());
    let points = |method: &str| -> Option<Vec<Point>> {
        let queue = queue?;
        let coherence = queue.order(method)?.coherence.known()?;
        let shares = coherence.area_quantiles.iter().enumerate().filter(|(_, area)| **area > 0.0);
        let point = |(percent, &area): (usize, &f64)| Point {
            x: area,
            y: percent as f64,
            spread: None,
            n: queue.rays as usize,
            name: format!("{}, bounce {}, {kind}, {method}", recording.label, queue.bounce),
        };
        Some(shares.map(point).collect())
    };
    let rays = queue.map_or(String::new(), |queue| format!("{kind}, bounce {}", queue.bounce));
    Panel::new(
        panel_title(findings, recording, &rays),
        Axis::logarithmic("capsule area (unit space)", 10),
        Axis::from_zero("share of rays (%)"),
        Content::Lines(by_method(findings, |method| points(method).unwrap_or_default())),
    )
}
