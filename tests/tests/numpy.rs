//! NumPy opens every array of a recording, mapped, with the documented type.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::process::Command;

use tempfile::tempdir;
use tests::programs::finish;
use tests::recordings::{arrays, record};

/// Opens every array below the folder named by the first argument and checks its type by file name,
/// as the list of FORMAT.md has it; prints how many there were.
const SCRIPT: &str = r#"
import pathlib, sys
import numpy as np

RAY = np.dtype([("origin", "<f4", (3,)), ("t_min", "<f4"), ("direction", "<f4", (3,)), ("t_max", "<f4")])
HIT = np.dtype([("t", "<f4"), ("triangle", "<u4"), ("u", "<f4"), ("v", "<f4")])
CELL = np.dtype([("cell", "<u4"), ("count", "<u4"), ("sum", "<u8")])
WORK = np.dtype([("nodes", "<u4"), ("triangles", "<u4")])
MASK = np.dtype([("texture", "<u4"), ("cutoff", "<f4")])
TYPES = {
    "positions": "<f4", "uvs": "<f4", "image": "<f4", "distances": "<f4", "throughput": "<f4", "colours": "|u1",
    "path_ids": "<u4", "lights": "<u4", "materials": "<u4", "permutation": "<u4",
    "node_boxes": "<f4", "node_children": "<u4", "leaf_triangles": "<u4",
    "rays": RAY, "hits": HIT, "work": WORK, "lengths": CELL, "final-lengths": CELL, "masks": MASK,
}
folder, key_type, width, height = pathlib.Path(sys.argv[1]), sys.argv[2], int(sys.argv[3]), int(sys.argv[4])
COLUMNS = {"positions": 3, "uvs": 2, "node_children": 8, "throughput": 3, "colours": 3}
paths = sorted(folder.rglob("*.npy"))
for path in paths:
    array = np.load(path, mmap_mode="r")
    name = path.stem
    if path.parent.name == "scene" and name == "triangles":
        expected, columns = "<u4", 3
    elif name.startswith("mask-"):
        expected, columns = "|u1", array.shape[1]
    else:
        expected, columns = key_type if name == "keys" else TYPES[name], COLUMNS.get(name)
    assert array.dtype == np.dtype(expected), (path, array.dtype, expected)
    assert array.offset % 64 == 0, (path, array.offset)
    if name == "image":
        assert array.shape == (height, width, 3), array.shape
    elif name == "node_boxes":
        boxes = array.reshape(-1, 8, 2, 3)
        assert array.shape[1:] == (8, 6) and ((boxes[:, :, 0] < boxes[:, :, 1]) | np.isinf(boxes[:, :, 0])).all(), path
    elif columns is not None:
        assert array.shape[1:] == (columns,), (path, array.shape)
    else:
        assert array.ndim == 1, (path, array.shape)
    if path.parent.name in ("closest", "shadow") and "lengths" not in name:
        rays = np.load(path.parent / "rays.npy", mmap_mode="r")
        assert len(array) == len(rays) > 0, (path, len(array), len(rays))
        if name == "path_ids":
            assert (np.diff(array.astype("i8")) > 0).all() and array.max() < width * height, path
        if name == "rays":
            assert np.allclose((array["direction"] ** 2).sum(axis=1), 1, atol=1e-5), path
    if name == "permutation" and path.parent.name == "auto":
        assert (np.sort(array) == np.arange(len(array))).all(), path
    elif name == "permutation":
        keys = np.load(path.parent / "keys.npy", mmap_mode="r")
        assert (array == np.argsort(keys, kind="stable")).all(), path
print(len(paths))
"#;

fn numpy_opens_all(scene: &str, key_bits: u32, key_type: &str) -> Vec<String> {
    let folder = tempdir().unwrap();
    record(folder.path(), "all", scene, &format!("--backend cpu --repeats 1 --key-bits {key_bits}"));
    let recording = folder.path().join("all.raydump");
    let python = std::env::var_os("PYTHON").unwrap_or_else(|| "python3".into());
    let mut command = Command::new(python);
    command.args(["-c", SCRIPT]).arg(&recording).args([key_type, "64", "36"]);
    let outcome = finish(&mut command).succeeded();
    let paths: Vec<String> = arrays(&recording).into_keys().collect();
    assert_eq!(outcome.stdout.trim(), paths.len().to_string(), "how many arrays NumPy opened");
    paths
}

#[test]
fn numpy_opens_every_array_with_32_bit_keys() {
    let paths = numpy_opens_all("builtin:cornell", 32, "<u4");
    for name in [
        "hits",
        "distances",
        "lights",
        "path_ids",
        "work",
        "throughput",
        "colours",
        "lengths",
        "final-lengths",
        "keys",
        "permutation",
    ] {
        assert!(
            paths.iter().any(|path| path.ends_with(&format!("/{name}.npy"))),
            "no {name}.npy among {paths:?}"
        );
    }
}

#[test]
fn numpy_opens_every_array_with_64_bit_keys() {
    numpy_opens_all("builtin:atrium?triangles=4000", 64, "<u8");
}
