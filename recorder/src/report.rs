//! The closing table of a recording: what each method cost and gained, queue by queue.

use comfy_table::presets::UTF8_BORDERS_ONLY;
use comfy_table::{CellAlignment, Table};
use formats::key::method::UNSORTED;
use formats::metrics::speedup::{Speedup, median};

use crate::measure::{MethodMeasurement, has_speedup};
use crate::observer::MeasuredQueue;
use crate::recording::Recorded;
use crate::stages::setup::MethodPlan;

const COLUMNS: [&str; 12] = [
    "bounce",
    "kind",
    "rays",
    "method",
    "key",
    "sort",
    "gather",
    "trace",
    "indirect",
    "accumulate",
    "trace speedup",
    "net speedup",
];

/// Scene, device, settings, notices and the table, a line or more each.
pub fn text(recorded: &Recorded) -> String {
    let notices = recorded.notices.iter().map(|notice| format!("note     {notice}"));
    let about = "\nMedians in ms; speedups against unsorted with 95 % bootstrap intervals; ≈ marks no significant \
                 difference.";
    let lines = recorded.headline.iter().cloned().chain(notices);
    let lines = lines.chain([about.to_owned(), table(recorded).to_string()]).chain(mismatches(recorded));
    lines.chain([format!("recording: {}", recorded.path.display())]).collect::<Vec<_>>().join("\n")
}

fn table(recorded: &Recorded) -> Table {
    let mut table = Table::new();
    table.load_style(UTF8_BORDERS_ONLY).set_header(COLUMNS);
    for column in table
        .column_iter_mut()
        .enumerate()
        .filter(|(index, _)| !matches!(index, 1 | 3))
        .map(|(_, column)| column)
    {
        column.set_cell_alignment(CellAlignment::Right);
    }
    for queue in &recorded.queues {
        let unsorted = &queue.measurement.unsorted_ns;
        let mut row = vec![
            queue.bounce.to_string(),
            queue.kind.to_string(),
            queue.rays.to_string(),
            UNSORTED.to_owned(),
        ];
        row.extend(["", "", ""].map(str::to_owned));
        row.push(milliseconds(unsorted));
        table.add_row(row);
        for entry in &queue.measurement.methods {
            table.add_row(method_row(queue, entry, &recorded.methods[entry.method]));
        }
    }
    table
}

fn method_row(queue: &MeasuredQueue, entry: &MethodMeasurement, method: &MethodPlan) -> Vec<String> {
    let stages = &entry.stages;
    let unsorted = &queue.measurement.unsorted_ns;
    let mut row = vec![String::new(), String::new(), String::new(), method.name.clone()];
    for samples in
        [&stages.key, &stages.sort, &stages.gather, &stages.trace, &stages.trace_indirect, &stages.accumulate]
    {
        row.push(milliseconds(samples));
    }
    if has_speedup(method) {
        row.push(speedup(Speedup::of(unsorted, &stages.trace)));
        row.push(speedup(Speedup::of(unsorted, &stages.totals())));
    } else {
        row.extend(["(traced first)".to_owned(), String::new()]);
    }
    row
}

fn milliseconds(samples_ns: &[u64]) -> String {
    median(samples_ns).map_or(String::new(), |median| format!("{:.2}", median / 1e6))
}

fn speedup(speedup: Option<Speedup>) -> String {
    match speedup {
        None => String::new(),
        Some(Speedup { ratio, interval: None }) => format!("{ratio:.2}"),
        Some(speedup @ Speedup { ratio, interval: Some((low, high)) }) => {
            let mark = if speedup.is_significant() { "" } else { "≈ " };
            format!("{mark}{ratio:.2} [{low:.2}, {high:.2}]")
        }
    }
}

/// Queues whose results depended on the order, which only the driver's own traversal may do.
fn mismatches(recorded: &Recorded) -> Vec<String> {
    let mut lines = Vec::new();
    for queue in &recorded.queues {
        for entry in queue.measurement.methods.iter().filter(|entry| entry.mismatches > 0) {
            lines.push(format!(
                "bounce {} {}: {} of {} rays found something else in the order of {} (ties and any-hit order are the driver's)",
                queue.bounce, queue.kind, entry.mismatches, queue.rays, recorded.methods[entry.method].name
            ));
        }
    }
    lines
}
