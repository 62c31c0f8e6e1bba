//! Results on standard output: text, tables, JSON; errors and progress on standard error. Nothing else
//! writes to either, and nothing that a file says reaches a terminal but as text.

use std::io::{self, Write};

use anyhow::Context;
use comfy_table::presets::UTF8_BORDERS_ONLY;
use comfy_table::{CellAlignment, Table};
pub(crate) use formats::text::{count, counted};
use formats::text::{printable, printable_json};
use serde::Serialize;

use crate::shown;

/// Writes a result to standard output.
///
/// A reader that has seen enough, such as `head`, is no failure; a full disk is one.
pub(crate) fn print(text: &str) -> anyhow::Result<()> {
    let mut output = io::stdout().lock();
    match writeln!(output, "{}", printable(text.trim_end())).and_then(|()| output.flush()) {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        written => written.context("cannot write to standard output"),
    }
}

/// Writes a result as one JSON object.
pub(crate) fn print_json(value: &impl Serialize) -> anyhow::Result<()> {
    let json = serde_json::to_string_pretty(value).context("the result cannot be written as JSON")?;
    print(&printable_json(&json))
}

/// Writes an error, a warning or how far something is to standard error.
pub(crate) fn say(text: &str) {
    // Where even this cannot be written, no one reads it.
    let _ = writeln!(io::stderr().lock(), "{}", printable(text));
}

/// An error with what led to it, in one sentence that says nothing twice: some errors say what they come
/// from, and name it as their source too.
pub(crate) fn sentence(error: &anyhow::Error) -> String {
    let mut sentence = String::new();
    for part in error.chain().map(ToString::to_string) {
        if sentence.is_empty() {
            sentence = part;
        } else if !sentence.contains(&part) {
            sentence.push_str(": ");
            sentence.push_str(&part);
        }
    }
    shown::sentence(sentence)
}

/// A table with this header, whose columns from `first_number` on are numbers.
pub(crate) fn table(header: &[&str], first_number: usize) -> Table {
    let mut table = Table::new();
    table.load_style(UTF8_BORDERS_ONLY).set_header(header.iter().copied());
    for column in table.column_iter_mut().skip(first_number) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}

/// A number of bytes for people: `1.4 GiB`.
pub(crate) fn size(bytes: u64) -> String {
    const UNITS: [&str; 4] = ["KiB", "MiB", "GiB", "TiB"];
    if bytes < 1024 {
        return format!("{bytes} B");
    }
    let mut value = bytes as f64 / 1024.0;
    let mut unit = 0;
    while value >= 1023.95 && unit + 1 < UNITS.len() {
        value /= 1024.0;
        unit += 1;
    }
    format!("{value:.1} {}", UNITS[unit])
}

/// Which of many: `1st`, `12th`, `66th`.
pub(crate) fn ordinal(number: usize) -> String {
    let ending = match (number % 100, number % 10) {
        (11..=13, _) => "th",
        (_, 1) => "st",
        (_, 2) => "nd",
        (_, 3) => "rd",
        _ => "th",
    };
    format!("{}{ending}", count(number as u64))
}

/// A sum of what files say, which may be anything.
pub(crate) fn sum(numbers: impl Iterator<Item = u64>) -> u64 {
    numbers.fold(0, u64::saturating_add)
}

/// A ratio for people: `1.39×`.
pub(crate) fn times(ratio: f64) -> String {
    let decimals = if ratio < 0.0995 { 3 } else { 2 - usize::from(ratio >= 9.995) };
    format!("{ratio:.decimals$}×")
}

/// A time for people, with three digits: `1.23 ms`.
pub(crate) fn time(nanoseconds: f64) -> String {
    let (value, unit) = match nanoseconds {
        ns if ns < 1e3 => (ns, "ns"),
        ns if ns < 1e6 => (ns / 1e3, "µs"),
        ns if ns < 1e9 => (ns / 1e6, "ms"),
        ns => (ns / 1e9, "s"),
    };
    let decimals = if value < 10.0 { 2 } else { usize::from(value < 100.0) };
    format!("{value:.decimals$} {unit}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_says_everything_once() {
        let full = || io::Error::other("the disk is full");
        let twice = anyhow::Error::from(full()).context("cannot write a.png: the disk is full");
        assert_eq!(sentence(&twice), "cannot write a.png: the disk is full");
        let once = anyhow::Error::from(full()).context("cannot write a.png");
        assert_eq!(sentence(&once), "cannot write a.png: the disk is full");
    }

    #[test]
    fn numbers_are_written_for_people() {
        assert_eq!([size(0), size(1023), size(1024)], ["0 B", "1023 B", "1.0 KiB"]);
        assert_eq!([size(1 << 20), size((1 << 30) - 1)], ["1.0 MiB", "1.0 GiB"]);
        assert_eq!([time(12.0), time(1234.0), time(99_900_000.0)], ["12.0 ns", "1.23 µs", "99.9 ms"]);
        assert_eq!(time(123e9), "123 s");
        assert_eq!([times(0.01234), times(1.386), times(9.996)], ["0.012×", "1.39×", "10.0×"]);
    }
}
