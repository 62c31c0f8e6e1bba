//! What a recording ends in: what each method gained over the whole frame and, on request, queue by queue.

use anyhow::Result;
use formats::key::method::{CONTROL, UNSORTED};
use formats::manifest::{Manifest, QueueRecord, Stage};
use formats::metrics::frame::{COLUMNS, Frame};
use formats::metrics::noise::Noise;
use formats::metrics::queue_times;
use formats::metrics::samples::Samples;
use formats::metrics::speedup::{Instrument, Speedup};
use formats::reader::Dump;
use formats::text::{counted, wrapped};

use crate::recording::Recorded;

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
        lines.push(format!("\n{}\n", queue_times::text(dump.manifest())));
        lines.extend(instrument(dump.manifest()).map(|line| wrapped(&line, COLUMNS, 0)));
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

/// How far the control is from 1, which it must measure: the error of everything above.
fn instrument(manifest: &Manifest) -> Option<String> {
    let samples = Samples::of(manifest);
    let control = |queue: &QueueRecord| {
        let of = |method| samples.get(queue.id, method);
        Speedup::of(of(UNSORTED)?.traced(), of(CONTROL)?.of(Stage::Trace))
    };
    Some(instrument_line(&Instrument::of(manifest.queues.iter().filter_map(control))?))
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

/// Its ratio and interval; nothing where there is none.
pub fn speedup(speedup: Option<Speedup>) -> String {
    speedup.map_or(String::new(), |speedup| speedup.to_string())
}
