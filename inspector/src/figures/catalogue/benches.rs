//! Results of `recorder bench`: sort throughput, trace rate.

use formats::bench_result::{Rows, SortRow, TraceRow};
use formats::ray::Kind;

use super::building::{bench_settings, figure, machine, method_style, rate};
use super::{Findings, Made};
use crate::analysis::summary::distinct;
use crate::figures::model::{Axis, Content, Panel, Series};

/// Keys sorted a second, by their number and bits: a panel per machine.
pub fn sort(findings: &Findings<'_>) -> Made {
    let benches = || findings.benches.iter().filter(|bench| matches!(bench.rows, Rows::Sort(_)));
    let panels = findings.benches.iter().filter_map(|bench| match &bench.rows {
        Rows::Sort(rows) => Some(sort_panel(rows, machine(bench))),
        _ => None,
    });
    figure(
        "Sort throughput",
        "Million random keys with their indices sorted a second: medians, whiskers from the first to the third quartile.",
        bench_settings(benches()),
        panels,
        "there is no result of `recorder bench sort --json`",
    )
}

fn sort_panel(rows: &[SortRow], title: String) -> Panel {
    let mut widths = distinct(rows.iter().map(|row| row.key_bits));
    widths.sort_unstable();
    let series = widths.into_iter().enumerate().map(|(style, key_bits)| {
        let mut own: Vec<&SortRow> = rows.iter().filter(|row| row.key_bits == key_bits).collect();
        own.sort_by_key(|row| row.n);
        let point = |row: &SortRow| {
            rate(row.n as f64, row.n, &row.samples_ns, format!("{} keys of {key_bits} bits", row.n))
        };
        let points = own.into_iter().filter_map(point).collect();
        Series { label: format!("{key_bits} bits"), style, points, is_part: false }
    });
    let y = Axis::from_zero("throughput (Mkeys/s)");
    Panel::new(title, Axis::logarithmic("keys", 2), y, Content::Lines(series.collect()))
}

/// Numbers of styles between two kernels: orders keep their colours, and hatches differ.
const STYLES_OF_KERNELS: [usize; 3] = [0, 18, 45];

/// Rays traced a second: a panel per machine, scene and kind; at each bounce bars by kernel and order.
pub fn trace(findings: &Findings<'_>) -> Made {
    let mut panels = Vec::new();
    let benches = || findings.benches.iter().filter(|bench| matches!(bench.rows, Rows::Trace(_)));
    let several = benches().count() > 1;
    for bench in benches() {
        let Rows::Trace(rows) = &bench.rows else { continue };
        let of = |row: &TraceRow| -> (String, Kind) { (row.scene.clone(), row.kind) };
        let mut queues = distinct(rows.iter().map(of));
        queues.sort_unstable();
        for queue in queues {
            let own: Vec<&TraceRow> = rows.iter().filter(|row| of(row) == queue).collect();
            let mut title = format!("{}: {} rays", queue.0, queue.1);
            if several {
                title = format!("{title}, {}", machine(bench));
            }
            panels.push(trace_panel(findings, &own, title));
        }
    }
    figure(
        "Trace rate per kernel, rays and order",
        "Million rays traced a second, sorted rays gathered before and untimed: medians, whiskers from the first to the third quartile.",
        bench_settings(benches()),
        panels,
        "there is no result of `recorder bench trace --json`",
    )
}

fn trace_panel(findings: &Findings<'_>, rows: &[&TraceRow], title: String) -> Panel {
    let kernels = distinct(rows.iter().map(|row| row.kernel.as_str()));
    let orders = distinct(rows.iter().map(|row| row.order.as_str()));
    let mut bounces = distinct(rows.iter().map(|row| row.bounce));
    bounces.sort_unstable();
    let series = |kernel: &str, order: &str, style: usize| {
        let points = bounces.iter().enumerate().filter_map(|(place, &bounce)| {
            let is_it = |row: &&&TraceRow| (&*row.kernel, &*row.order, row.bounce) == (kernel, order, bounce);
            let row = rows.iter().find(is_it)?;
            let name = format!("{}, bounce {bounce}, {}", row.scene, row.kind);
            rate(place as f64, row.rays, &row.samples_ns, name)
        });
        let label = if kernels.len() > 1 { format!("{order}, {kernel}") } else { order.to_owned() };
        Series { label, style, points: points.collect(), is_part: false }
    };
    let of_kernel = |(at, kernel): (usize, &&str)| -> Vec<Series> {
        let first = STYLES_OF_KERNELS[at % STYLES_OF_KERNELS.len()];
        let orders = orders.iter();
        orders.map(|order| series(kernel, order, first + method_style(findings, order))).collect()
    };
    Panel::new(
        title,
        Axis::categories("bounce", bounces.iter().map(u32::to_string)),
        Axis::from_zero("trace rate (Mrays/s)"),
        Content::Bars(kernels.iter().enumerate().flat_map(of_kernel).collect()),
    )
}
