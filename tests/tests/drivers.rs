//! Other drivers and subgroups give the same recordings, and the validation layer has nothing to say.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

use tempfile::{TempDir, tempdir};
use tests::drivers::{is_validation_expected, on_driver, second_driver, skipped, validate};
use tests::programs::{Program, finish};
use tests::recordings::{arrays, assert_same, verify};

/// Small: a driver takes seconds for its kernels alone. The methods bind all that keys are made of.
const OPTIONS: &str = "--width 48 --height 32 --bounces 3 --passes 2 --repeats 1 --key-bits 64 \
    --methods two-point-adaptive,light-octahedron";

/// A scene whose paths are the same on all drivers: no surface of it is glossy. Where some are, drivers
/// may take terms together, and paths differ by an ulp.
const SCENE: &str = "builtin:cornell";

fn recorder(folder: &Path, line: &str) -> Command {
    let mut command = Program::Recorder.command(line.split_whitespace());
    command.current_dir(folder);
    command
}

/// Records [`SCENE`] with what `change` makes of the command, verifies it, and gives its arrays.
fn record(
    folder: &Path,
    name: &str,
    options: &str,
    change: impl FnOnce(&mut Command),
) -> BTreeMap<String, Vec<u8>> {
    let mut command = recorder(folder, &format!("record {SCENE} --out {name}.raydump {OPTIONS} {options}"));
    change(&mut command);
    finish(&mut command).succeeded();
    verify(folder, name);
    arrays(&folder.join(format!("{name}.raydump")))
}

/// What `recorder adapters` says of the first adapter.
fn adapter(change: impl FnOnce(&mut Command)) -> serde_json::Value {
    let mut command = Program::Recorder.command(["adapters", "--json"]);
    change(&mut command);
    finish(&mut command).succeeded().json()[0]["adapter"].clone()
}

#[test]
fn a_second_driver_records_the_same_bits() {
    let Some(manifest) = second_driver() else {
        return skipped("a second driver", "RAYSCOPE_SECOND_DRIVER names none; tests/run sets it");
    };
    let folder = tempdir().unwrap();
    let found = adapter(|command| on_driver(command, &manifest));
    let first = adapter(|_| ());
    assert_ne!(found["driver"], first["driver"], "the second driver is the first");
    let threads = record(folder.path(), "threads", "--backend cpu --trace cwbvh", |_| ());
    let second = record(folder.path(), "second", "--backend gpu", |command| on_driver(command, &manifest));
    // What a hierarchy costs is counted alike on both backends; nothing else may differ either.
    assert_same(&threads, &second, &format!("threads and {}", found["name"]));
}

/// lavapipe's subgroups are as wide as the vectors it is told to use.
#[test]
fn subgroups_of_every_width_record_the_same_bits() {
    let name = adapter(|_| ())["name"].to_string();
    if !name.contains("llvmpipe") {
        return skipped("subgroups of 4, 8 and 16", &format!("{name} has a width of its own"));
    }
    let folder = tempdir().unwrap();
    let expected = record(folder.path(), "threads", "--backend cpu --trace cwbvh", |_| ());
    for lanes in [4, 8, 16] {
        let bits = (32 * lanes).to_string();
        let widen = |command: &mut Command| {
            command.env("LP_NATIVE_VECTOR_WIDTH", &bits);
        };
        let width = adapter(widen)["subgroup_min_size"].clone();
        if width != lanes {
            skipped(&format!("subgroups of {lanes}"), &format!("this processor makes them {width} wide"));
            continue;
        }
        let found = record(folder.path(), &format!("of-{lanes}"), "--backend gpu --adapter llvmpipe", widen);
        assert_same(&expected, &found, &format!("subgroups of {lanes}"));
    }
}

/// Runs a program under the validation layer; `false` if the layer is not there.
fn is_valid(folder: &TempDir, command: &mut Command) -> bool {
    let log = folder.path().join("validation.log");
    validate(command, &log);
    let command_line = format!("{command:?}");
    finish(command).succeeded();
    let said = std::fs::read_to_string(&log).unwrap_or_default();
    // Proof that it listens, and to synchronisation, too.
    if !said.contains("Validation Layer Active") {
        assert!(!is_validation_expected(), "the validation layer was not loaded by {command_line}: {said}");
        return false;
    }
    assert!(said.contains("SYNCHRONIZATION_VALIDATION"), "synchronisation is not checked: {said}");
    let complaint =
        said.lines().find(|line| line.contains("Validation") && !line.contains("Validation Information"));
    assert_eq!(complaint, None, "the validation layer about {command_line}");
    true
}

#[test]
fn the_validation_layer_has_nothing_to_say() {
    let folder = tempdir().unwrap();
    let mut runs =
        vec![recorder(folder.path(), &format!("record {SCENE} --out own.raydump {OPTIONS} --backend gpu"))];
    if adapter(|_| ())["ray_query"] == true {
        let line = format!("record {SCENE} --out query.raydump {OPTIONS} --backend gpu --trace ray-query");
        runs.push(recorder(folder.path(), &line));
    } else {
        skipped("ray queries under the validation layer", "the adapter has none");
    }
    let mut window =
        Program::Inspector.command(["shot", "own.raydump", "--view", "window", "--out", "window.png"]);
    window.current_dir(folder.path());
    runs.push(window);
    if let Some(manifest) = second_driver() {
        let mut second =
            recorder(folder.path(), &format!("record {SCENE} --out second.raydump {OPTIONS} --backend gpu"));
        on_driver(&mut second, &manifest);
        runs.push(second);
    }
    if !runs.iter_mut().all(|run| is_valid(&folder, run)) {
        skipped("the validation layer", "it is not installed");
    }
}
