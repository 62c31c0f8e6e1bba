//! Models of divergence and of caches, per method.

use super::building::{
    each, figure, methods, methods_in_rows, of, of_method, panel_title, reason, recordings, settings,
    with_number, without,
};
use super::{Findings, Made};
use crate::analysis::coherence::WARP;
use crate::analysis::summary::RayClass;
use crate::analysis::{OrderAnalysis, QueueAnalysis, RecordingAnalysis, lacking};
use crate::figures::model::{Axis, Of, Panel, Point, Series};

/// A share of an order, 0 to 1, and what weighs it in a mean over bounces.
type Share = fn(&QueueAnalysis, &OrderAnalysis) -> Option<(f64, f64)>;

/// Share of lanes that work.
pub fn lanes(findings: &Findings<'_>) -> Made {
    let share: Share = |queue, order| Some((order.warp_utilisation()?, queue.rays as f64));
    figure(
        "Lane utilisation per method, a model",
        format!(
            "A model of control-flow divergence: work of all rays (nodes visited and triangles tested) over what it would be if each ray took as long as the slowest of its {WARP}. Means over bounces, weighted by rays; small dots are the bounces, or of more than {MOST_DETAILED} recordings these, with means of methods that all of them have.{}",
            without(recordings(findings), |recording| lacking::of_orders(recording, |order| &order.lanes))
        ),
        settings(with_number(findings, |order| &order.lanes)),
        panels_of(findings, share, "", "lane utilisation (%)"),
        reason(findings, |order| &order.lanes, "no queue was measured"),
    )
}

/// Share of cache lines that were not found.
pub fn caches(findings: &Findings<'_>) -> Made {
    let first: Share =
        |queue, order| order.caches.known().map(|hits| (1.0 - hits.l1, hits.lines(queue.rays)));
    let either: Share =
        |queue, order| order.caches.known().map(|hits| (1.0 - hits.either, hits.lines(queue.rays)));
    let panels = [(first, ", not in L1"), (either, ", in neither L1 nor L2")];
    figure(
        "Cache misses per method, a model",
        format!(
            "A model: node and triangle addresses of sampled groups, replayed through two set-associative caches. Means over bounces, weighted by the lines that all of their rays ask for; small dots are the bounces, or of more than {MOST_DETAILED} recordings these, with means of methods that all of them have."
        ),
        settings(with_number(findings, |order| &order.caches)),
        panels.into_iter().flat_map(|(share, level)| panels_of(findings, share, level, "misses (%)")),
        reason(findings, |order| &order.caches, "no queue was measured"),
    )
}

/// Recordings that have panels of their own; of more the means alone are readable, with a dot for each.
const MOST_DETAILED: usize = 2;

fn panels_of(findings: &Findings<'_>, share: Share, what: &str, axis: &str) -> Vec<Panel> {
    let recordings = recordings(findings);
    let rows = |title: String, of: &dyn Fn(&str) -> Option<[Series; 2]>| {
        let series: Vec<Series> =
            methods(findings).iter().filter_map(|method| of(method)).flatten().collect();
        methods_in_rows(findings, title, Axis::from_zero(axis), series)
    };
    if recordings.len() > MOST_DETAILED {
        let panel = |rays: RayClass| {
            let of = |method: &str| mean_and_recordings(findings, &recordings, rays, method, share);
            rows(format!("All recordings: {} rays{what}", rays.name()), &of)
        };
        return RayClass::ALL.map(panel).into();
    }
    each(RayClass::ALL, &recordings, |recording, rays| {
        let title = panel_title(findings, recording, &format!("{} rays{what}", rays.name()));
        rows(title, &|method| mean_and_bounces(findings, recording, rays, method, share))
    })
}

/// The mean of a method over recordings, if all that were measured have it, after those, percent.
fn mean_and_recordings(
    findings: &Findings<'_>,
    recordings: &[&RecordingAnalysis],
    rays: RayClass,
    method: &str,
    share: Share,
) -> Option<[Series; 2]> {
    let mean = |recording: &RecordingAnalysis, method: &str| -> Option<Point> {
        let [_, mean] = mean_and_bounces(findings, recording, rays, method, share)?;
        mean.points.into_iter().next()
    };
    let has_any = |recording: &&&RecordingAnalysis| {
        methods(findings).iter().any(|method| mean(recording, method).is_some())
    };
    let all = recordings.iter().filter(has_any).count();
    let parts: Vec<Point> = recordings.iter().filter_map(|recording| mean(recording, method)).collect();
    let y = parts.iter().map(|point| point.y).sum::<f64>() / parts.len() as f64;
    let of = Of { kind: rays.name().to_owned(), method: method.to_owned(), ..Of::detail("all recordings") };
    let mean = (!parts.is_empty()).then_some(Point::new(0.0, y, parts.len(), of))?;
    let means = if parts.len() < all { Vec::new() } else { vec![mean] };
    let parts = Series { is_part: true, ..of_method(findings, method, parts) };
    Some([parts, of_method(findings, method, means)])
}

/// The mean of a method over bounces, after the bounces, percent.
fn mean_and_bounces(
    findings: &Findings<'_>,
    recording: &RecordingAnalysis,
    rays: RayClass,
    method: &str,
    share: Share,
) -> Option<[Series; 2]> {
    let share = |queue: &QueueAnalysis| Some((queue.bounce, share(queue, queue.order(method)?)?));
    let bounces: Vec<_> = recording.measured_of(rays).filter_map(share).collect();
    let point = |y: f64, n: usize, bounce: Option<u32>| {
        Point::new(0.0, y * 100.0, n, of(recording, rays.name(), bounce, method))
    };
    let parts = bounces.iter().map(|(bounce, (share, _))| point(*share, 1, Some(*bounce)));
    let parts = Series { is_part: true, ..of_method(findings, method, parts.collect()) };
    let weight: f64 = bounces.iter().map(|(_, (_, weight))| weight).sum();
    let sum: f64 = bounces.iter().map(|(_, (share, weight))| share * weight).sum();
    let mean = (weight > 0.0).then(|| point(sum / weight, bounces.len(), None))?;
    Some([parts, of_method(findings, method, vec![mean])])
}
