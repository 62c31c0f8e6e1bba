//! Results of `recorder bench`: sort throughput, trace rate.

use formats::bench_result::{Rows, SortRow, TraceRow};
use formats::metrics::speedup::median;
use formats::ray::Kind;

use super::building::{bench_settings, figure, machine, method_style, rate};
use super::{Findings, Made};
use crate::analysis::summary::distinct;
use crate::figures::model::{Axis, Content, Of, Panel, Point, Series};
use crate::output::sum;

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
            let of = Of::detail(format!("{} keys", row.n));
            rate(row.n as f64, row.n, &row.samples_ns, of)
        };
        let points = own.into_iter().filter_map(point).collect();
        Series::new(format!("{key_bits} bits"), style, points)
    });
    let y = Axis::from_zero("throughput (Mkeys/s)");
    Panel::new(title, Axis::logarithmic("keys", 2), y, Content::Lines(series.collect()))
}

/// Rays traced a second: a panel per machine, scene and kind, a row per kernel and order.
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
        "Million rays traced a second, sorted rays gathered before and untimed: all bounces by their median times, small dots are the bounces.",
        bench_settings(benches()),
        panels,
        "there is no result of `recorder bench trace --json`",
    )
}

fn trace_panel(findings: &Findings<'_>, rows: &[&TraceRow], title: String) -> Panel {
    let several = distinct(rows.iter().map(|row| row.kernel.as_str())).len() > 1;
    let label = |row: &TraceRow| {
        if several { format!("{}, {}", row.kernel, row.order) } else { row.order.clone() }
    };
    let labels = distinct(rows.iter().map(|row| label(row)));
    let of = |row: &TraceRow, bounce| Of {
        scene: row.scene.clone(),
        machine: row.kernel.clone(),
        kind: row.kind.to_string(),
        bounce,
        method: row.order.clone(),
        detail: String::new(),
    };
    let series = |(place, named): (usize, &String)| -> [Series; 2] {
        let own: Vec<&&TraceRow> = rows.iter().filter(|row| label(row) == *named).collect();
        let bounce = |row: &&&TraceRow| {
            let of = of(row, Some(row.bounce));
            rate(place as f64, row.rays, &row.samples_ns, of).map(|point| Point { spread: None, ..point })
        };
        let rays = sum(own.iter().map(|row| row.rays));
        let ns: f64 = own.iter().filter_map(|row| median(&row.samples_ns)).sum();
        let n = own.iter().map(|row| row.samples_ns.len()).min().unwrap_or(0);
        let first = own.first().filter(|_| ns > 0.0);
        let all = first.map(|row| Point::new(place as f64, rays as f64 / ns * 1e3, n, of(row, None)));
        let style = own.first().map_or(0, |row| method_style(findings, &row.order));
        let made = |points, is_part| Series { label: named.clone(), style, points, is_part };
        [made(own.iter().filter_map(bounce).collect(), true), made(all.into_iter().collect(), false)]
    };
    Panel::new(
        title,
        Axis::categories("", labels.iter().cloned()),
        Axis::from_zero("trace rate (Mrays/s)"),
        Content::Dots(labels.iter().enumerate().flat_map(series).collect()),
    )
}
