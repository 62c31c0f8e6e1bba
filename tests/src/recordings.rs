//! Recordings as the tests see them: made by the program, compared byte by byte.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::programs::Program;
use crate::sources::files_below;

/// A picture and a path length that take a second or two, with every array that can be kept.
pub const SMALL: &str = "--width 64 --height 36 --bounces 3 --passes 2 \
    --keep rays,hits,keys,permutations,lengths,scene,image,caches,work,hierarchy,throughput";

/// Records `scene` as `NAME.raydump` in `folder` with [`SMALL`] and further `options`; gives what `--json` printed.
///
/// # Panics
/// If the recorder fails.
pub fn record(folder: &Path, name: &str, scene: &str, options: &str) -> Value {
    let line = format!("record {scene} --out {name}.raydump --json {SMALL} {options}");
    Program::Recorder.run(folder, &line).succeeded().json()
}

/// Checks that `inspector verify` finds nothing wrong with `NAME.raydump` in `folder`.
///
/// # Panics
/// If it does.
pub fn verify(folder: &Path, name: &str) {
    Program::Inspector.run(folder, &format!("verify {name}.raydump")).succeeded();
}

/// What `inspector info --json` says of a recording without what another run of it has otherwise: times and what follows
/// from them, paths, what the machine said of itself.
///
/// # Panics
/// If the inspector fails.
pub fn without_times(folder: &Path, recording: &str) -> Value {
    let mut said = Program::Inspector.run(folder, &format!("info {recording} --json")).succeeded().json();
    for key in ["dump", "wall_ns", "timings", "frame", "self_check"] {
        said[key] = Value::Null;
    }
    // A replay names its source by a checksum of all that it says, times included.
    said["source"]["sha256"] = Value::Null;
    said
}

/// Contents of every array of a recording, by its path from the recording's folder.
///
/// # Panics
/// If it has none, or one that cannot be read.
pub fn arrays(recording: &Path) -> BTreeMap<String, Vec<u8>> {
    let paths = files_below(recording, |_| true).into_iter().filter(|path| path.ends_with(".npy"));
    let read = |path: String| (path.clone(), fs::read(recording.join(path)).expect("the array can be read"));
    let found: BTreeMap<_, _> = paths.map(read).collect();
    assert!(!found.is_empty(), "{} has no arrays", recording.display());
    found
}

/// The arrays that may not depend on which methods were measured.
pub fn without_methods(mut arrays: BTreeMap<String, Vec<u8>>) -> BTreeMap<String, Vec<u8>> {
    arrays.retain(|path, _| !path.ends_with("/keys.npy") && !path.ends_with("/permutation.npy"));
    arrays
}

/// Checks that two recordings have the same arrays with the same bytes.
///
/// # Panics
/// If not, with the paths that differ.
pub fn assert_same(left: &BTreeMap<String, Vec<u8>>, right: &BTreeMap<String, Vec<u8>>, what: &str) {
    let paths = |arrays: &BTreeMap<String, Vec<u8>>| arrays.keys().cloned().collect::<Vec<_>>();
    assert_eq!(paths(left), paths(right), "which arrays there are: {what}");
    let different = differing(left, right);
    assert!(different.is_empty(), "{what}: these arrays differ: {different:?}");
}

/// Paths of the arrays that both have, but with different bytes.
pub fn differing<'a>(left: &'a BTreeMap<String, Vec<u8>>, right: &BTreeMap<String, Vec<u8>>) -> Vec<&'a str> {
    left.iter()
        .filter(|(path, bytes)| right.get(*path).is_some_and(|other| other != *bytes))
        .map(|(path, _)| path.as_str())
        .collect()
}
