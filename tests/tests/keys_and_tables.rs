//! Keys, permutations and length tables of recordings from both backends, against their definition in NumPy.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::fs;

use serde_json::json;
use tempfile::tempdir;
use tests::programs::{Program, finish, python};
use tests::recordings::{record, verify};
use tests::sources::root;

/// Rows that `all` does not stand for.
const OTHERS: &str =
    "paraboloid,hilbert-origin,hilbert-two-point,two-point-xor,grid-spherical,tiled-octahedron";
/// The pictures here are smaller than a tile of that row.
const SMALL_TILES: &str = "small-tiles=tile(7x10)(u(v))*4";

/// Records and compares every key, permutation and table of it.
fn check(scene: &str, options: &str, key_bits: u32) {
    let folder = tempdir().unwrap();
    let methods = format!("--methods all,{OTHERS} --method {SMALL_TILES}");
    record(folder.path(), "keys", scene, &format!("--repeats 1 --key-bits {key_bits} {methods} {options}"));
    verify(folder.path(), "keys");
    let info = Program::Inspector.run(folder.path(), "info keys.raydump --json").succeeded().json();
    fs::write(folder.path().join("keys.json"), info.to_string()).unwrap();
    let mut command = python();
    command.arg(root().join("tests/check_keys.py")).args(["keys.raydump", "keys.json"]);
    let compared = finish(command.current_dir(folder.path())).succeeded().json();
    assert_eq!(compared["left out"], json!([]), "{compared}");
    // Three bounces of both kinds, the first of which finds a table that nothing was added to.
    assert_eq!(compared["tables"], 6, "{compared}");
    let methods = info["options"]["methods"].as_array().unwrap().iter().map(|name| name.as_str().unwrap());
    let methods: Vec<&str> = methods.filter(|name| !["unsorted", "auto"].contains(name)).collect();
    assert_eq!(methods.len(), 17, "{methods:?}");
    for method in methods {
        let is_of_shadow_rays = ["light-octahedron", "origin-light"].contains(&method);
        let least = if is_of_shadow_rays { 1000 } else { 5000 };
        assert!(compared[method].as_u64().unwrap() > least, "{method}: {compared}");
    }
}

#[test]
fn of_16_bits_on_threads() {
    check("builtin:atrium?triangles=4000", "--backend cpu", 16);
}

#[test]
fn of_32_bits_on_threads() {
    check("builtin:atrium?triangles=4000", "--backend cpu", 32);
}

#[test]
fn of_64_bits_on_threads() {
    check("builtin:terrain?triangles=4000", "--backend cpu", 64);
}

#[test]
fn of_16_bits_on_the_gpu() {
    check("builtin:atrium?triangles=4000", "--backend gpu", 16);
}

#[test]
fn of_32_bits_on_the_gpu() {
    check("builtin:atrium?triangles=4000", "--backend gpu", 32);
}

#[test]
fn of_64_bits_on_the_gpu() {
    check("builtin:terrain?triangles=4000", "--backend gpu --trace bvh2", 64);
}
