//! Capsule area against trace time, and its distribution.

use formats::metrics::correlation::Correlation;
use formats::ray::Kind;

use super::building::{
    by_label, by_method, each, figure, method_style, of, panel_title, reason, recordings, settings, without,
    without_repeated,
};
use super::{Findings, Made};
use crate::analysis::correlations::{AreaAndTime, correlation, points};
use crate::analysis::{Metric, QueueAnalysis, RecordingAnalysis, lacking};
use crate::figures::model::{Axis, Content, Panel, Point};

/// Mean capsule area of each order against the time that its trace takes, both over those of unsorted rays.
pub fn against_time(findings: &Findings<'_>) -> Made {
    let (mut panels, mut found, mut shown) = (Vec::new(), Vec::new(), Vec::new());
    let recordings = recordings(findings);
    for recording in &recordings {
        let points = points(recording);
        if !points.is_empty() {
            shown.push(*recording);
        }
        for kind in Kind::ALL {
            let points: Vec<_> = points.iter().filter(|point| point.queue.kind == kind).collect();
            if points.is_empty() {
                continue;
            }
            let title = format!("{kind} rays: {}", coefficients(&correlation(points.iter().copied())));
            let of_recording = format!("{}, {title}", recording.label);
            let title = if recordings.len() > 1 { of_recording.clone() } else { title };
            found.push(of_recording);
            panels.push(scatter(findings, recording, &points, title));
        }
    }
    let caption = format!(
        "Each marker is one order of one queue (bounce, kind, method): the mean area of the capsules around groups of {} rays, weighted by rays, against its trace time, both over those of the same queue unsorted. Camera rays are among the closest ones where they were recorded. Left of 1: more coherent; below 1: faster. Correlation, of the ratios themselves: {}.{}",
        findings.analysis.group_width,
        found.join("; "),
        without(recordings, areas)
    );
    let reason = reason(findings, |order| &order.coherence, "no trace was timed");
    figure("Mean capsule area against trace time", caption, settings(shown), panels, reason)
}

fn areas(recording: &RecordingAnalysis) -> Vec<String> {
    lacking::of_orders(recording, |order| &order.coherence)
}

fn coefficients(correlation: &Metric<Correlation>) -> String {
    match correlation {
        Metric::Known(Correlation { pearson, spearman, n }) => {
            format!("Pearson {pearson:.2}, Spearman {spearman:.2}, n = {n}").replace('-', "−")
        }
        Metric::Missing { .. } => "too few orders for a coefficient".to_owned(),
    }
}

fn scatter(
    findings: &Findings<'_>,
    recording: &RecordingAnalysis,
    points: &[&AreaAndTime<'_>],
    title: String,
) -> Panel {
    let point = |at: &AreaAndTime<'_>| {
        let QueueAnalysis { bounce, kind, .. } = at.queue;
        let of = of(recording, kind, Some(*bounce), &at.order.method);
        Some(Point::new(at.area, at.time, at.trace.samples_ns.len(), of))
    };
    let series = by_label(points, |at| &at.order.base, |base| method_style(findings, base), point);
    Panel::new(
        title,
        Axis::logarithmic("capsule area (unsorted = 1)", 10),
        Axis::ratios("trace time (unsorted = 1)"),
        Content::Scatter(series),
    )
    .with_reference("unsorted", 1.0)
}

/// Which share of the rays is in capsules of at most some area: bounce 1, or the first that there is.
pub fn distribution(findings: &Findings<'_>) -> Made {
    let caption = format!(
        "Share of the rays whose group of {} has a capsule of at most this area, in unit space. The farther left a curve, the more coherent the order.{}",
        findings.analysis.group_width,
        without(with_own_orders(findings), areas)
    );
    figure(
        "Share of rays by the area of their group's capsule",
        caption,
        settings(with_own_orders(findings)),
        each(Kind::ALL, &with_own_orders(findings), |recording, kind| shares(findings, recording, kind)),
        reason(findings, |order| &order.coherence, "no queue was measured"),
    )
}

/// The recordings without those whose orders are all another's, as those of replays by another kernel are.
fn with_own_orders<'a>(findings: &Findings<'a>) -> Vec<&'a RecordingAnalysis> {
    without_repeated(recordings(findings), |recording| {
        let orders = recording.queues.iter().flat_map(|queue| {
            queue.orders.iter().map(move |order| {
                let coherence = order.coherence.known()?;
                Some((queue.pass, queue.bounce, queue.kind, &order.method, coherence))
            })
        });
        orders.flatten().collect()
    })
}

fn shares(findings: &Findings<'_>, recording: &RecordingAnalysis, kind: Kind) -> Panel {
    let of_kind = || recording.measured().filter(|queue| queue.kind == kind);
    let queue = of_kind().find(|queue| queue.bounce == 1).or_else(|| of_kind().next());
    let points = |method: &str| -> Option<Vec<Point>> {
        let queue = queue?;
        let coherence = queue.order(method)?.coherence.known()?;
        let shares = coherence.area_quantiles.iter().enumerate().filter(|(_, area)| **area > 0.0);
        let point = |(percent, &area): (usize, &f64)| {
            let of = of(recording, kind, Some(queue.bounce), method);
            Point::new(area, percent as f64, queue.rays as usize, of)
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
