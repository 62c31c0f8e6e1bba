//! `inspector recover`: makes a recording of what is left of one.

use std::path::{Path, PathBuf};

use formats::recover::recover;
use serde::Serialize;

use crate::output::{counted, print, print_json, size};

/// What `recover --json` prints.
#[derive(Serialize)]
struct Report {
    dump: PathBuf,
    arrays: usize,
    bytes: u64,
    complete: bool,
    cut: Option<String>,
    left_out: Vec<String>,
    leftover: Option<PathBuf>,
    leftover_files: usize,
}

pub(crate) fn run(path: &Path, json: bool) -> anyhow::Result<()> {
    let recovery = recover(path)?;
    let (leftover, leftover_files) = recovery.leftover.unzip();
    let report = Report {
        dump: recovery.dump,
        arrays: recovery.arrays,
        bytes: recovery.bytes,
        complete: recovery.is_complete,
        cut: recovery.cut,
        left_out: recovery.left_out,
        leftover,
        leftover_files: leftover_files.unwrap_or(0),
    };
    if json { print_json(&report) } else { print(&in_words(&report)) }
}

fn in_words(report: &Report) -> String {
    let arrays = format!("{}, {}", counted(report.arrays as u64, "array", "arrays"), size(report.bytes));
    let name = report.dump.display();
    let mut text = match (report.complete, &report.cut) {
        (true, None) => format!("{name} is complete: {arrays}."),
        _ => format!("{name} now holds what was complete: {arrays}."),
    };
    if let Some(cut) = &report.cut {
        text.push_str(&format!("\nIt ends there because {cut}."));
    }
    if let Some(first) = report.left_out.first() {
        let records = counted(report.left_out.len() as u64, "record", "records");
        text.push_str(&format!("\nDamaged and left out: {records}. The first: {first}."));
    }
    if let Some(leftover) = &report.leftover {
        let files = counted(report.leftover_files as u64, "file", "files");
        text.push_str(&format!(
            "\nWhat does not belong to it ({files}) is in {}; delete it if you do not need it.",
            leftover.display()
        ));
    }
    text
}
