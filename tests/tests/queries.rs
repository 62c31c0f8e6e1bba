//! The questions of docs/queries.md, asked again by DuckDB of an export that its own commands make.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::fs;
use std::path::Path;

use serde_json::Value;
use tempfile::tempdir;
use tests::programs::{Outcome, Program, finish, python};
use tests::sources::root;

/// Runs the queries of a document on the export in a folder, beside what `info --metrics` says.
fn ask(document: &Path, folder: &Path, metrics: &str) -> Outcome {
    let file = folder.join("metrics.json");
    fs::write(&file, metrics).unwrap();
    let mut command = python();
    command.arg(root().join("tests/check_queries.py")).args([document, &folder.join("tables"), &file]);
    finish(&mut command)
}

#[test]
fn duckdb_finds_the_answers_of_the_document_and_those_of_info() {
    let folder = tempdir().unwrap();
    let folder = folder.path();
    let document = root().join("docs/queries.md");
    let text = fs::read_to_string(&document).unwrap();
    let (_, commands) = text.split_once("```text\nrecorder record ").unwrap();
    let (commands, _) = commands.split_once("```").unwrap();
    let (record, export) = commands.split_once("\ninspector ").unwrap();
    Program::Recorder.run(folder, &format!("record {}", record.replace("\\\n", ""))).succeeded();
    Program::Inspector.run(folder, export).succeeded();
    let metrics = Program::Inspector.run(folder, "info cornell.raydump --json --metrics").succeeded();
    let said = ask(&document, folder, &metrics.stdout).succeeded().json();
    assert_eq!(said, serde_json::json!({"queries": 15, "answers": 9, "numbers": 96}));

    // The script must be able to fail: by an answer, and by a number of `info`.
    let changed = folder.join("changed.md");
    assert!(text.contains("closest | 1 | 0.298 | 0.294\n"));
    fs::write(&changed, text.replace("closest | 1 | 0.298 | 0.294\n", "closest | 1 | 0.298 | 0.295\n"))
        .unwrap();
    ask(&changed, folder, &metrics.stdout).failed_with(1, &["estimates, compared: the document has"]);
    let mut wrong: Value = metrics.json();
    let queues = wrong["metrics"]["recordings"][0]["queues"].as_array_mut().unwrap();
    let order = &mut queues.iter_mut().find(|queue| queue["bounce"] == 1).unwrap()["orders"][1];
    let area = order["coherence"]["mean_capsule_area"].as_f64().unwrap();
    order["coherence"]["mean_capsule_area"] = Value::from(area * 1.001);
    ask(&document, folder, &wrong.to_string()).failed_with(1, &["coherence of ", "`info` has"]);
}
