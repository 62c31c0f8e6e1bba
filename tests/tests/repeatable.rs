//! The same command gives the same bytes, and what is measured changes nothing else.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::collections::BTreeMap;

use tempfile::tempdir;
use tests::recordings::{arrays, assert_same, differing, record, without_methods};

const SCENE: &str = "builtin:atrium?triangles=4000";

/// Records once for every one of `variants` (options) and gives the image hash and arrays of each.
fn recordings(variants: &[&str]) -> Vec<(String, BTreeMap<String, Vec<u8>>)> {
    let folder = tempdir().unwrap();
    let one = |(number, options): (usize, &&str)| {
        let name = format!("variant-{number}");
        let json = record(folder.path(), &name, SCENE, options);
        let hash = json["image"]["sha256"].as_str().expect("--json has the image's hash").to_owned();
        (hash, arrays(&folder.path().join(name + ".raydump")))
    };
    variants.iter().enumerate().map(one).collect()
}

fn the_same_command_twice(backend: &str) {
    let mut found = recordings(&[backend, backend]);
    // Its choice follows from a calibration, which is a measurement: a replay that takes it over repeats it.
    found.iter_mut().for_each(|(_, arrays)| arrays.retain(|path, _| !path.contains("/auto/")));
    assert!(found[0].1.len() > 40, "the recording has only {:?}", found[0].1.keys());
    assert_same(&found[0].1, &found[1].1, backend);
}

#[test]
fn the_same_command_on_threads_gives_the_same_bytes() {
    the_same_command_twice("--backend cpu --repeats 1");
}

#[test]
fn the_same_command_on_the_gpu_gives_the_same_bytes() {
    the_same_command_twice("--backend gpu --repeats 1");
}

/// Whatever `variants` measure, picture and method-independent arrays are those of the first.
fn nothing_else_changes(variants: &[&str]) {
    let mut found = recordings(variants).into_iter();
    let (hash, first) = found.next().unwrap();
    let first = without_methods(first);
    for ((other_hash, other), options) in found.zip(&variants[1..]) {
        assert_eq!(hash, other_hash, "image hash with {options}");
        assert_same(&first, &without_methods(other), options);
    }
}

#[test]
fn methods_repeats_and_threads_change_nothing_else() {
    nothing_else_changes(&[
        "--backend cpu --repeats 1 --threads 2",
        "--backend cpu --repeats 1 --threads 1 --methods unsorted",
        "--backend cpu --repeats 3 --threads 3 --methods two-point-adaptive,costa --key-bits 64",
    ]);
}

#[test]
fn methods_and_repeats_change_nothing_else_on_the_gpu() {
    nothing_else_changes(&[
        "--backend gpu --repeats 1",
        "--backend gpu --repeats 1 --methods unsorted",
        "--backend gpu --repeats 2 --methods two-point-adaptive,costa --key-bits 64",
    ]);
}

#[test]
fn hierarchies_on_threads_find_the_same_hits() {
    let cwbvh = "--backend cpu --repeats 1 --methods unsorted --trace cwbvh";
    let bvh2 = "--backend cpu --repeats 1 --methods unsorted --trace bvh2";
    let mut found = recordings(&[cwbvh, bvh2]);
    // What a hierarchy costs, and which occluder a shadow ray meets first, is its own.
    for (_, arrays) in &mut found {
        arrays.retain(|path, _| !path.ends_with("/work.npy") && !path.contains("/shadow/"));
    }
    assert_eq!(found[0].0, found[1].0, "image hash");
    assert_same(&found[0].1, &found[1].1, "cwbvh and bvh2");
}

#[test]
fn another_seed_gives_another_picture() {
    let found = recordings(&["--backend cpu --repeats 1 --seed 0", "--backend cpu --repeats 1 --seed 1"]);
    assert_ne!(found[0].0, found[1].0, "image hash of two seeds");
    let different = differing(&found[0].1, &found[1].1);
    assert!(different.contains(&"pass-001/bounce-00/closest/rays.npy"), "only {different:?} differ");
    assert!(!different.contains(&"scene/positions.npy"), "the seed changed the scene");
}
