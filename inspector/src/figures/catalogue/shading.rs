//! Frames whose hits are sorted before they are shaded.

use formats::bench_result::{RenderRow, Rows};
use formats::key::method::UNSORTED;
use formats::manifest::Stage;
use formats::metrics::speedup::median;

use super::building::{bench_settings, figure, machine, stage_style};
use super::{Findings, Made};
use crate::analysis::summary::distinct;
use crate::figures::model::{Axis, Content, Of, Panel, Point, Series};

/// What the names of orders of hits start with.
const HITS_BY: &str = "hits by ";
/// Of the dots, black.
const SPEEDUP_STYLE: usize = 0;

/// A part of a frame: what it is called, the stage whose colour it has, its samples.
type Part = (&'static str, Stage, fn(&RenderRow) -> Vec<u64>);
/// Tracing, shading (which is no stage of an order, and has the colour of one that frames have not), sorting.
const PARTS: [Part; 3] = [
    ("trace", Stage::Trace, |row| row.trace_ns.clone()),
    ("generate and shade", Stage::Scatter, |row| row.shade_ns().collect()),
    ("sort and move hits", Stage::Sort, |row| row.reorder_ns.clone()),
];

/// Frame times by what hits are sorted by: their parts, and what comes of it.
pub fn shading(findings: &Findings<'_>) -> Made {
    let benches = || findings.benches.iter().filter(|bench| matches!(bench.rows, Rows::Render(_)));
    let several = distinct(benches().map(machine)).len() > 1;
    let (mut panels, mut shown) = (Vec::new(), Vec::new());
    for bench in benches() {
        let Rows::Render(rows) = &bench.rows else { continue };
        for scene in distinct(rows.iter().map(|row| row.scene.as_str())) {
            let own: Vec<&RenderRow> =
                rows.iter().filter(|row| row.scene == scene && hits_by(row).is_some()).collect();
            let title = if several { format!("{scene}, {}", machine(bench)) } else { scene.to_owned() };
            panels.extend(beside(&title, &own).into_iter().flatten());
            shown.extend(own);
        }
    }
    let caption = format!(
        "Frames as a renderer makes them, whose hits are sorted before they are shaded. Left the median times of their parts, as multiples of the frame that sorts nothing; right the speedup of the whole frame with its 95 % interval: sorting pays where that is right of the line. Taking a key from a hit (its material or triangle) is not timed; the key of a place is. Distinct materials among 32 neighbours: {}.",
        materials(&shown)
    );
    let reason = "there is no result of `recorder bench render --json` with orders of hits";
    figure("Does sorting hits before shading pay?", caption, bench_settings(benches()), panels, reason)
}

/// What the hits of a frame are sorted by; `None` if its rays are sorted.
fn hits_by(row: &RenderRow) -> Option<&str> {
    if row.method == UNSORTED { Some("none") } else { row.method.strip_prefix(HITS_BY) }
}

/// Two panels of the frames of a scene; none if nothing of it was sorted.
fn beside(title: &str, rows: &[&RenderRow]) -> Option<[Panel; 2]> {
    let unsorted = rows.iter().find(|row| row.method == UNSORTED)?;
    let frame_ns = median(&unsorted.frame_ns)?;
    let point = |(at, row): (usize, &&RenderRow), y, spread| {
        let (scene, method) = (row.scene.clone(), row.method.clone());
        let of = Of { scene, method, ..Of::detail(format!("{}x{}", row.width, row.height)) };
        Point { x: at as f64, y, spread, n: row.frame_ns.len(), of }
    };
    let part = |(label, stage, samples): Part| {
        let of_row = |row: (usize, &&RenderRow)| Some(point(row, median(&samples(row.1))? / frame_ns, None));
        let points = rows.iter().enumerate().filter_map(of_row).collect();
        Series::new(label, stage_style(stage), points)
    };
    let speedup = |row: (usize, &&RenderRow)| {
        let found = row.1.speedup?;
        Some(point(row, found.ratio, found.interval))
    };
    let points: Vec<Point> = rows.iter().enumerate().filter_map(speedup).collect();
    let speedups = Series::new("whole frame", SPEEDUP_STYLE, points);
    let panel = |axis: Axis, content: Content| {
        let names = rows.iter().filter_map(|row| hits_by(row));
        Panel::new(title, Axis::categories("", names), axis, content).with_reference("unsorted", 1.0)
    };
    (!speedups.points.is_empty()).then(|| {
        let parts = Content::Stacks(PARTS.into_iter().map(part).collect());
        [
            panel(Axis::from_zero("time (unsorted = 1)"), parts),
            panel(Axis::ratios("frame speedup"), Content::Dots(vec![speedups])),
        ]
    })
}

/// How many materials neighbours have, from the scene with fewest to that with most, by order.
fn materials(rows: &[&RenderRow]) -> String {
    let of_order = |order: &str| {
        let own = rows.iter().filter(|row| hits_by(row) == Some(order));
        let counts: Vec<f64> = own.filter_map(|row| Some(row.coherence?.materials)).collect();
        let lowest = counts.iter().copied().reduce(f64::min)?;
        let highest = counts.iter().copied().reduce(f64::max)?;
        let (low, high) = (format!("{lowest:.1}"), format!("{highest:.1}"));
        Some(if low == high { format!("{order} {low}") } else { format!("{order} {low} to {high}") })
    };
    let orders = distinct(rows.iter().filter_map(|row| hits_by(row)));
    let found: Vec<String> = orders.into_iter().filter_map(of_order).collect();
    if found.is_empty() { "not counted".to_owned() } else { found.join(", ") }
}
