//! The numbers of `inspector info --metrics` against NumPy, which computes them from the arrays alone.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::fs;
use std::path::Path;

use serde_json::Value;
use tempfile::tempdir;
use tests::programs::{Outcome, Program, finish, python};
use tests::recordings::record;
use tests::sources::root;

fn check(folder: &Path, metrics: &str) -> Outcome {
    let file = folder.join("metrics.json");
    fs::write(&file, metrics).unwrap();
    let mut command = python();
    command.arg(root().join("tests/check_metrics.py")).arg(folder.join("cornell.raydump")).arg(file);
    finish(&mut command)
}

#[test]
fn numpy_computes_the_same_metrics() {
    let folder = tempdir().unwrap();
    let options = "--backend cpu --repeats 3 --methods unsorted,two-point,two-point-adaptive,aila";
    record(folder.path(), "cornell", "builtin:cornell", options);
    let info = Program::Inspector.run(folder.path(), "info cornell.raydump --json --metrics").succeeded();
    let outcome = check(folder.path(), &info.stdout).succeeded();
    let compared: Value = serde_json::from_str(&outcome.stdout).unwrap();
    // Three bounces, two kinds, four orders.
    assert_eq!(compared["capsule area"], 24, "{compared}");
    assert_eq!(compared["lane utilisation"], 72, "{compared}");
    assert_eq!(compared["trace speedup"], 18, "{compared}");

    // The script must be able to fail: one area, a thousandth off.
    let mut wrong = info.json();
    let queues = wrong["metrics"]["recordings"][0]["queues"].as_array_mut().unwrap();
    let measured = queues.iter_mut().find(|queue| queue["orders"] != serde_json::json!([])).unwrap();
    let order = &mut measured["orders"][1];
    let area = order["coherence"]["mean_capsule_area"].as_f64().unwrap();
    order["coherence"]["mean_capsule_area"] = Value::from(area * 1.001);
    let outcome = check(folder.path(), &wrong.to_string());
    outcome.failed_with(1, &["capsule area of"]);
}

/// Its queues are too short to be worth a key, so that their times say nothing of an order.
#[test]
fn what_auto_leaves_alone_has_no_speedup() {
    let folder = tempdir().unwrap();
    let json =
        record(folder.path(), "short", "builtin:cornell", "--backend cpu --repeats 1 --methods aila,auto");
    let row = |method: &str| {
        let rows = json["frame"]["rows"].as_array().unwrap();
        rows.iter().find(|row| row["method"] == method).unwrap_or_else(|| panic!("no {method}: {rows:?}"))
    };
    assert_eq!(row("auto")["verdict"], "left alone");
    for number in ["secondary", "shadow", "net"] {
        assert!(row("auto")[number].is_null() && row("aila")[number]["ratio"].is_f64(), "{number}");
    }
}
