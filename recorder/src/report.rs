//! What a recording ends in: what each method gained over the whole frame and, on request, queue by queue.

use anyhow::Result;
use comfy_table::presets::UTF8_BORDERS_ONLY;
use comfy_table::{CellAlignment, Table};
use formats::key::Termination;
use formats::manifest::{DecisionRecord, Stage, Way};
use formats::metrics::frame::{COLUMNS, Frame};
use formats::metrics::noise::Noise;
use formats::metrics::speedup::{Instrument, Speedup, median};
use formats::reader::Dump;
use formats::text::{counted, wrapped};

use crate::measure::{Measurement, Subject, queue_name};
use crate::observer::{MeasuredQueue, chosen_way};
use crate::recording::Recorded;

const ABOUT_DETAILS: &str = "\nMedians in ms; speedups against unsorted in the same round, medians with 95 % bootstrap \
                             intervals over rounds; ≈ marks no significant difference. The net speedup counts gather, \
                             trace and scatter, or the trace through indices (*).";
/// Where the words of the first lines begin.
const INDENT: usize = 9;

/// What was recorded and what sorting was worth, in a screen; with `details` the stages of every queue, too.
///
/// # Errors
/// If the recording cannot be read back.
pub fn text(recorded: &Recorded, details: bool) -> Result<String> {
    let dump = Dump::open(&recorded.path)?;
    let notices = recorded.notices.iter().map(|notice| format!("note     {notice}"));
    let about = recorded.headline.iter().cloned().chain(notices);
    let mut lines: Vec<String> = about.map(|line| wrapped(&line, COLUMNS, INDENT)).collect();
    let frame = Frame::of(dump.manifest());
    if details {
        lines.push(ABOUT_DETAILS.to_owned());
        lines.push(table(recorded).to_string());
        lines.extend(decisions(recorded));
        lines.extend(mismatches(recorded));
        lines.extend(instrument(recorded).map(|line| wrapped(&line, COLUMNS, 0)));
        // What is said of many disturbed samples stands above the frame.
        let Noise { samples, disturbed, .. } = frame.noise;
        if disturbed > 0 && !frame.noise.is_disturbed() {
            lines.push(format!(
                "{disturbed} of {samples} samples were taken while the machine did other work."
            ));
        }
    }
    lines.push(format!("\n{}\n", frame.text()));
    lines.push(format!("recording: {}", recorded.path.display()));
    Ok(lines.join("\n"))
}

/// What a stage is called at the head of a column.
fn heading(stage: Stage) -> &'static str {
    match stage {
        Stage::TraceIndirect => "indirect",
        other => other.name(),
    }
}

fn table(recorded: &Recorded) -> Table {
    let mut table = Table::new();
    let names = ["bounce", "kind", "rays", "method"].into_iter().chain(Stage::OF_ORDERS.map(heading));
    table.load_style(UTF8_BORDERS_ONLY).set_header(names.chain(["trace speedup", "net speedup"]));
    for (_, column) in table.column_iter_mut().enumerate().filter(|(index, _)| !matches!(index, 1 | 3)) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    for queue in &recorded.queues {
        for (at, entry) in queue.measurements.iter().enumerate() {
            let of_queue = [queue.id.bounce.to_string(), queue.id.kind.to_string(), queue.rays.to_string()];
            let mut row: Vec<String> =
                of_queue.into_iter().map(|text| if at == 0 { text } else { String::new() }).collect();
            row.push(entry.subject.name(&recorded.methods).to_owned());
            let way = chosen_way(&recorded.queues, entry.subject);
            row.extend(Stage::OF_ORDERS.map(|stage| {
                let mark = if stage == Stage::TraceIndirect && way == Some(Way::Indices) { "*" } else { "" };
                format!("{mark}{}", milliseconds(entry.stages.of(stage)))
            }));
            row.extend(speedups(queue, entry, recorded));
            table.add_row(row);
        }
    }
    table
}

fn speedups(queue: &MeasuredQueue, entry: &Measurement, recorded: &Recorded) -> [String; 2] {
    let unsorted = queue.unsorted();
    let trace = || speedup(Speedup::of(unsorted, entry.stages.traced()));
    match entry.subject {
        Subject::Unsorted => [String::new(), String::new()],
        // The real length is only known once the ray was traced.
        Subject::Method(number) if recorded.methods[number].termination == Termination::Real => {
            ["(traced first)".to_owned(), String::new()]
        }
        Subject::Method(_) | Subject::Auto => {
            let way =
                chosen_way(&recorded.queues, entry.subject).unwrap_or_else(|| entry.stages.shorter_way());
            [trace(), speedup(Speedup::of(unsorted, &entry.stages.totals(way)))]
        }
        // What the key and the sort of another tracer take is not known here; a random order has none.
        Subject::Control | Subject::Shuffled | Subject::Foreign(_) => [trace(), String::new()],
    }
}

/// What `auto` chose, queue by queue.
fn decisions(recorded: &Recorded) -> Vec<String> {
    let line = |decision: &DecisionRecord| {
        let queue = queue_name(decision.queue.bounce, decision.queue.kind);
        format!("auto     {queue}: {}", decision.chosen())
    };
    recorded.decisions.iter().map(line).collect()
}

/// How far the control is from 1, which it must measure: the error of everything above.
fn instrument(recorded: &Recorded) -> Option<String> {
    let instrument = Instrument::of(recorded.queues.iter().filter_map(|queue| {
        let control = queue.measurements.iter().find(|entry| entry.subject == Subject::Control)?;
        Speedup::of(queue.unsorted(), control.stages.of(Stage::Trace))
    }))?;
    Some(instrument_line(&instrument))
}

/// What an instrument misses by, in a line.
pub fn instrument_line(instrument: &Instrument) -> String {
    let Instrument { experiments, hold_one, pooled_bias, median_half_width } = *instrument;
    let intervals = match median_half_width {
        None => ", without intervals: they need at least 6 repeats".to_owned(),
        Some(half_width) => format!(
            "; {hold_one} of {} 1, half of them are narrower than ±{:.1} %",
            counted(experiments as u64, "interval holds", "intervals hold"),
            100.0 * half_width
        ),
    };
    format!(
        "instrument: the control (canonical order, gathered) is off by {:+.1} % over {}{intervals}",
        100.0 * pooled_bias,
        counted(experiments as u64, "queue", "queues")
    )
}

fn milliseconds(samples_ns: &[u64]) -> String {
    median(samples_ns).map_or(String::new(), |median| format!("{:.2}", median / 1e6))
}

/// Its ratio and interval; nothing where there is none.
pub fn speedup(speedup: Option<Speedup>) -> String {
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
        for entry in queue.measurements.iter().filter(|entry| entry.mismatches > 0) {
            lines.push(format!(
                "bounce {} {}: {} of {} rays found something else in the order of {} (ties and any-hit order are the driver's)",
                queue.id.bounce, queue.id.kind, entry.mismatches, queue.rays, entry.subject.name(&recorded.methods)
            ));
        }
    }
    lines
}
