//! Models of divergence and of caches, per method.

use super::building::{
    categories, figure, linear, methods, of_method, order, panel_title, queues, range, rays_title, reason,
    recordings, settings,
};
use super::{Material, Skipped};
use crate::analysis::summary::Rays;
use crate::analysis::{OrderAnalysis, QueueAnalysis, RecordingAnalysis};
use crate::figures::model::{Axis, Content, Figure, Panel, Point, Series};

/// A share of an order (0 to 1) at each category, and what weighs it in a mean over bounces.
type Shares = fn(&QueueAnalysis, &OrderAnalysis) -> Vec<(f64, f64)>;

/// Share of lanes that work.
pub fn lanes(material: &Material<'_>) -> Result<Figure, Skipped> {
    let shares: Shares = |queue, order| {
        let lanes = order.lanes.known().map_or(&[][..], |lanes| lanes);
        lanes.iter().map(|lane| (lane.utilisation, queue.rays as f64)).collect()
    };
    let widths = formats::metrics::lanes::WIDTHS.map(|width| width.to_string());
    let axis = || categories("lanes that wait for each other", widths.clone());
    let parts = Figure {
        name: "lane-utilisation".to_owned(),
        title: "Lane utilisation per method, a model".to_owned(),
        caption: "A model of control-flow divergence: work of all rays (nodes visited and triangles tested) over what it would be if each ray took as long as the slowest of its group. Means over bounces, weighted by rays; whiskers reach from the lowest to the highest bounce.".to_owned(),
        settings: settings(material),
        panels: panels(material, shares, &axis, "lane utilisation (%)"),
    };
    figure(parts, reason(material, |order| &order.lanes, "no queue was measured"))
}

/// Share of cache lines that were found.
pub fn caches(material: &Material<'_>) -> Result<Figure, Skipped> {
    let shares: Shares = |_, order| {
        let of = |hits: &crate::analysis::order::CacheHits| {
            let accesses = hits.accesses as f64;
            vec![(hits.l1, accesses), (hits.l2, accesses * (1.0 - hits.l1)), (hits.either, accesses)]
        };
        order.caches.known().map(of).unwrap_or_default()
    };
    let axis = || categories("cache", ["L1", "L2, of the others", "either"]);
    let parts = Figure {
        name: "cache-hit-ratio".to_owned(),
        title: "Cache hit ratio per method, a model".to_owned(),
        caption: "A model: node and triangle addresses of sampled groups, replayed through two set-associative caches. Means over bounces, weighted by accesses; whiskers reach from the lowest to the highest bounce.".to_owned(),
        settings: settings(material),
        panels: panels(material, shares, &axis, "hit ratio (%)"),
    };
    figure(parts, reason(material, |order| &order.caches, "no queue was measured"))
}

fn panels(material: &Material<'_>, shares: Shares, x: &dyn Fn() -> Axis, y: &str) -> Vec<Panel> {
    let mut panels = Vec::new();
    for rays in Rays::ALL {
        for recording in recordings(material) {
            let series = |method: &str| of_method(material, method, points(recording, rays, method, shares));
            let series: Vec<Series> = methods(material).into_iter().map(series).collect();
            panels.push(Panel {
                title: panel_title(material, recording, &rays_title(rays)),
                x: x(),
                y: linear(y, true),
                content: Content::Bars(series),
                references: Vec::new(),
            });
        }
    }
    panels
}

fn points(recording: &RecordingAnalysis, rays: Rays, method: &str, shares: Shares) -> Vec<Point> {
    let of_queues: Vec<Vec<(f64, f64)>> =
        queues(recording, rays).filter_map(|queue| Some(shares(queue, order(queue, method)?))).collect();
    let places = of_queues.iter().map(Vec::len).max().unwrap_or(0);
    let point = |place: usize| {
        let here: Vec<(f64, f64)> =
            of_queues.iter().filter_map(|shares| shares.get(place).copied()).collect();
        let weight: f64 = here.iter().map(|(_, weight)| weight).sum();
        let percents: Vec<f64> = here.iter().map(|(share, _)| share * 100.0).collect();
        let name = format!("{}, {}, {method}", recording.label, rays.name());
        let mean = here.iter().map(|(share, weight)| share * weight).sum::<f64>() / weight * 100.0;
        (weight > 0.0).then(|| Point {
            x: place as f64,
            y: mean,
            spread: range(&percents),
            n: here.len(),
            name,
        })
    };
    (0..places).filter_map(point).collect()
}
