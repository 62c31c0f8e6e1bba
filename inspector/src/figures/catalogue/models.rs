//! Models of divergence and of caches, per method.

use formats::metrics::lanes::WIDTHS;

use super::building::{by_method, each, figure, panel_title, queues, range, reason, recordings, settings};
use super::{Findings, Made};
use crate::analysis::order::CacheHits;
use crate::analysis::summary::RayClass;
use crate::analysis::{OrderAnalysis, QueueAnalysis, RecordingAnalysis};
use crate::figures::model::{Axis, Content, Panel, Point};

/// A share of an order (0 to 1) at each category, and what weighs it in a mean over bounces.
type Shares = fn(&QueueAnalysis, &OrderAnalysis) -> Vec<(f64, f64)>;

/// Share of lanes that work.
pub fn lanes(findings: &Findings<'_>) -> Made {
    let shares: Shares = |queue, order| {
        let lanes = order.lanes.known().map_or(&[][..], |lanes| lanes);
        lanes.iter().map(|lane| (lane.utilisation, queue.rays as f64)).collect()
    };
    let x = Axis::categories("lanes that wait for each other", WIDTHS.map(|width| width.to_string()));
    figure(
        "Lane utilisation per method, a model",
        "A model of control-flow divergence: work of all rays (nodes visited and triangles tested) over what it would be if each ray took as long as the slowest of its group. Means over bounces, weighted by rays; whiskers reach from the lowest to the highest bounce.",
        settings(findings),
        panels(findings, shares, &x, "lane utilisation (%)"),
        reason(findings, |order| &order.lanes, "no queue was measured"),
    )
}

/// Share of cache lines that were found.
pub fn caches(findings: &Findings<'_>) -> Made {
    let shares: Shares = |_, order| {
        let of = |hits: &CacheHits| {
            let accesses = hits.accesses as f64;
            vec![(hits.l1, accesses), (hits.l2, accesses * (1.0 - hits.l1)), (hits.either, accesses)]
        };
        order.caches.known().map(of).unwrap_or_default()
    };
    let x = Axis::categories("cache", ["L1", "L2, of the others", "either"]);
    figure(
        "Cache hit ratio per method, a model",
        "A model: node and triangle addresses of sampled groups, replayed through two set-associative caches. Means over bounces, weighted by accesses; whiskers reach from the lowest to the highest bounce.",
        settings(findings),
        panels(findings, shares, &x, "hit ratio (%)"),
        reason(findings, |order| &order.caches, "no queue was measured"),
    )
}

fn panels(findings: &Findings<'_>, shares: Shares, x: &Axis, y: &str) -> Vec<Panel> {
    each(RayClass::ALL, &recordings(findings), |recording, rays| {
        Panel::new(
            panel_title(findings, recording, &format!("{} rays", rays.name())),
            x.clone(),
            Axis::from_zero(y),
            Content::Bars(by_method(findings, |method| points(recording, rays, method, shares))),
        )
    })
}

fn points(recording: &RecordingAnalysis, rays: RayClass, method: &str, shares: Shares) -> Vec<Point> {
    let of_queues: Vec<Vec<(f64, f64)>> =
        queues(recording, rays).filter_map(|queue| Some(shares(queue, queue.order(method)?))).collect();
    let places = of_queues.iter().map(Vec::len).max().unwrap_or(0);
    let point = |place: usize| {
        let here: Vec<(f64, f64)> =
            of_queues.iter().filter_map(|shares| shares.get(place).copied()).collect();
        let weight: f64 = here.iter().map(|(_, weight)| weight).sum();
        let percents: Vec<f64> = here.iter().map(|(share, _)| share * 100.0).collect();
        let name = format!("{}, {}, {method}", recording.label, rays.name());
        let y = here.iter().map(|(share, weight)| share * weight).sum::<f64>() / weight * 100.0;
        (weight > 0.0).then(|| Point { x: place as f64, y, spread: range(&percents), n: here.len(), name })
    };
    (0..places).filter_map(point).collect()
}
