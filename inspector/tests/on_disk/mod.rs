//! The sample in a folder of its own.

#![allow(dead_code, reason = "each test program uses a part")]
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::path::PathBuf;

use tempfile::TempDir;

#[path = "../../../formats/tests/sample/mod.rs"]
pub(crate) mod sample;

/// The sample, and the folder that it is in until that is dropped.
pub(crate) fn written() -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let dump = sample::write(folder.path());
    (folder, dump)
}
