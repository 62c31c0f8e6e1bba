//! `inspector verify`: whether every array of a recording is what the format says it is.

use std::path::Path;

use formats::reader::{Dump, DumpState};
use formats::verify::{Check, Report, verify};
use serde::Serialize;

use crate::output::{count, print, print_json, table};

/// What `verify --json` prints.
#[derive(Serialize)]
struct Outcome<'a> {
    dump: &'a Path,
    ok: bool,
    complete: bool,
    problems: u64,
    checks: &'a [Check],
}

pub(crate) fn run(path: &Path, json: bool) -> anyhow::Result<()> {
    let dump = Dump::open(path)?;
    let report = verify(&dump);
    let complete = dump.state() == DumpState::Complete;
    if json {
        let (ok, problems) = (report.is_ok(), report.problems());
        print_json(&Outcome { dump: path, ok, complete, problems, checks: &report.checks })?;
    } else {
        print(&in_words(&report))?;
    }
    match report.problems() {
        0 => Ok(()),
        1 => anyhow::bail!("{}: 1 thing is wrong", path.display()),
        problems => anyhow::bail!("{}: {} things are wrong", path.display(), count(problems)),
    }
}

fn in_words(report: &Report) -> String {
    let mut table = table(&["checked", "items", "wrong", "differing"], 1);
    for check in &report.checks {
        table.add_row([
            check.name.to_owned(),
            count(check.checked),
            count(check.problems.count),
            count(check.differences.count),
        ]);
    }
    let mut text = table.to_string();
    for check in &report.checks {
        text.push_str(&findings("wrong", check.name, check.problems.count, &check.problems.first));
        text.push_str(&findings("differing", check.name, check.differences.count, &check.differences.first));
    }
    for check in &report.checks {
        // Hundreds of queues of which the same was not kept are one line.
        if let Some(first) = check.not_checked.first() {
            let more = match check.not_checked.len() - 1 {
                0 => String::new(),
                more => format!(" (and {more} more)"),
            };
            text.push_str(&format!("\nnot checked, {}: {first}{more}", check.name));
        }
    }
    let is_different = report.checks.iter().any(|check| check.differences.count > 0);
    if is_different {
        text.push_str("\nDiffering numbers are not wrong here: the adapter's arithmetic is not IEEE.");
    }
    if report.is_ok() {
        text.push_str("\nEverything that could be checked is right.");
    }
    text
}

fn findings(what: &str, name: &str, total: u64, first: &[String]) -> String {
    let mut text: String = first.iter().map(|finding| format!("\n{what}, {name}: {finding}")).collect();
    let hidden = total - first.len() as u64;
    if hidden > 0 {
        text.push_str(&format!("\n{what}, {name}: … and {} more", count(hidden)));
    }
    text
}
