//! Results of `recorder bench`: sort throughput, trace rate.

use formats::bench_result::{BenchResult, Rows, SortRow, TraceRow};
use formats::metrics::speedup::{median, quantile};

use super::building::{
    bench_settings, categories, figure, kind_title, linear, logarithmic, machine, method_style,
};
use super::{Material, Skipped};
use crate::analysis::summary::distinct;
use crate::figures::model::{Content, Figure, Panel, Point, Series};

/// Keys sorted a second, by their number and bits: a panel per machine.
pub fn sort(material: &Material<'_>) -> Result<Figure, Skipped> {
    let rows = |bench: &BenchResult| match &bench.rows {
        Rows::Sort(rows) => rows.clone(),
        _ => Vec::new(),
    };
    let benches = || material.benches.iter().filter(|bench| matches!(bench.rows, Rows::Sort(_)));
    let parts = Figure {
        name: "sort-throughput".to_owned(),
        title: "Sort throughput".to_owned(),
        caption: "Million random keys with their indices sorted a second: medians, whiskers from the first to the third quartile.".to_owned(),
        settings: bench_settings(benches()),
        panels: benches().map(|bench| sort_panel(&rows(bench), machine(bench))).collect(),
    };
    figure(parts, "there is no result of `recorder bench sort --json`")
}

fn sort_panel(rows: &[SortRow], title: String) -> Panel {
    let mut widths: Vec<u32> = rows.iter().map(|row| row.key_bits).collect();
    widths.sort_unstable();
    widths.dedup();
    let series = widths.into_iter().enumerate().map(|(style, key_bits)| {
        let mut own: Vec<&SortRow> = rows.iter().filter(|row| row.key_bits == key_bits).collect();
        own.sort_by_key(|row| row.n);
        let point = |row: &SortRow| {
            rate(row.n as f64, row.n, &row.samples_ns, format!("{} keys of {key_bits} bits", row.n))
        };
        Series {
            label: format!("{key_bits} bits"),
            style,
            points: own.into_iter().filter_map(point).collect(),
        }
    });
    Panel {
        title,
        x: logarithmic("keys", 2),
        y: linear("throughput (Mkeys/s)", true),
        content: Content::Lines(series.collect()),
        references: Vec::new(),
    }
}

/// Numbers of styles between two kernels: orders keep their colours, and hatches differ.
const STYLES_OF_KERNELS: [usize; 3] = [0, 18, 45];

/// Rays traced a second: a panel per machine, scene and kind; at each bounce bars by kernel and order.
pub fn trace(material: &Material<'_>) -> Result<Figure, Skipped> {
    let mut panels = Vec::new();
    let benches = || material.benches.iter().filter(|bench| matches!(bench.rows, Rows::Trace(_)));
    let several = benches().count() > 1;
    for bench in benches() {
        let Rows::Trace(rows) = &bench.rows else { continue };
        let mut queues: Vec<(&str, _)> = rows.iter().map(|row| (row.scene.as_str(), row.kind)).collect();
        queues.sort_unstable();
        queues.dedup();
        for (scene, kind) in queues {
            let own = |row: &&TraceRow| (row.scene.as_str(), row.kind) == (scene, kind);
            let mut title = format!("{scene}: {}", kind_title(kind));
            if several {
                title = format!("{title}, {}", machine(bench));
            }
            panels.push(trace_panel(material, &rows.iter().filter(own).collect::<Vec<_>>(), title));
        }
    }
    let parts = Figure {
        name: "trace-rate".to_owned(),
        title: "Trace rate per kernel, rays and order".to_owned(),
        caption: "Million rays traced a second, sorted rays gathered before and untimed: medians, whiskers from the first to the third quartile.".to_owned(),
        settings: bench_settings(benches()),
        panels,
    };
    figure(parts, "there is no result of `recorder bench trace --json`")
}

fn trace_panel(material: &Material<'_>, rows: &[&TraceRow], title: String) -> Panel {
    let kernels = distinct(rows.iter().map(|row| row.kernel.as_str()));
    let orders = distinct(rows.iter().map(|row| row.order.as_str()));
    let mut bounces: Vec<u32> = rows.iter().map(|row| row.bounce).collect();
    bounces.sort_unstable();
    bounces.dedup();
    let series = |kernel: &str, order: &str, style: usize| {
        let points = bounces.iter().enumerate().filter_map(|(place, &bounce)| {
            let is_it = |row: &&&TraceRow| (&*row.kernel, &*row.order, row.bounce) == (kernel, order, bounce);
            let row = rows.iter().find(is_it)?;
            rate(
                place as f64,
                row.rays,
                &row.samples_ns,
                format!("{}, bounce {bounce}, {}", row.scene, row.kind),
            )
        });
        let label = if kernels.len() > 1 { format!("{order}, {kernel}") } else { order.to_owned() };
        Series { label, style, points: points.collect() }
    };
    let of_kernel = |(at, kernel): (usize, &&str)| -> Vec<Series> {
        let first = STYLES_OF_KERNELS[at % STYLES_OF_KERNELS.len()];
        let orders = orders.iter();
        orders.map(|order| series(kernel, order, first + method_style(material, order))).collect()
    };
    Panel {
        title,
        x: categories("bounce", bounces.iter().map(u32::to_string)),
        y: linear("trace rate (Mrays/s)", true),
        content: Content::Bars(kernels.iter().enumerate().flat_map(of_kernel).collect()),
        references: Vec::new(),
    }
}

/// Millions of items a second, at `x`.
fn rate(x: f64, items: u64, samples_ns: &[u64], name: String) -> Option<Point> {
    let rate = |ns: f64| items as f64 / ns.max(f64::MIN_POSITIVE) * 1e3;
    let quartiles = (rate(quantile(samples_ns, 0.75)?), rate(quantile(samples_ns, 0.25)?));
    let n = samples_ns.len();
    Some(Point { x, y: rate(median(samples_ns)?), spread: (n > 1).then_some(quartiles), n, name })
}
