//! The project's own files, for the tests that hold its rules by reading them.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::fs;
use std::path::{Path, PathBuf};

/// The folder that holds the workspace's `Cargo.toml`.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the package lies one folder below the workspace")
}

/// A file of the project.
pub struct Source {
    /// Path from the workspace's root, with `/` between folders.
    pub path: String,
    /// Its whole text.
    pub text: String,
}

/// All files below `folder` (a path from the root) whose name ends in `.extension`, by path. Build
/// outputs, recordings and hidden folders are left out.
///
/// # Panics
/// If there is none, or one that is not readable as UTF-8: a test over no files could not fail.
pub fn files(folder: &str, extension: &str) -> Vec<Source> {
    let mut paths = Vec::new();
    collect(&root().join(folder), extension, &mut paths);
    paths.sort();
    assert!(!paths.is_empty(), "no .{extension} file found below {folder:?}, expected at least one");
    paths.into_iter().map(read).collect()
}

fn read(path: PathBuf) -> Source {
    let text =
        fs::read_to_string(&path).unwrap_or_else(|error| panic!("cannot read {}: {error}", path.display()));
    let relative = path.strip_prefix(root()).expect("the file was found below the root");
    let path = relative.iter().map(|part| part.to_string_lossy()).collect::<Vec<_>>().join("/");
    Source { path, text }
}

fn collect(folder: &Path, extension: &str, paths: &mut Vec<PathBuf>) {
    let entries =
        fs::read_dir(folder).unwrap_or_else(|error| panic!("cannot list {}: {error}", folder.display()));
    for entry in entries {
        let entry = entry.unwrap_or_else(|error| panic!("cannot list {}: {error}", folder.display()));
        let path = entry.path();
        let name = entry.file_name();
        let name = name.to_string_lossy();
        if path.is_dir() {
            let is_ours = !name.starts_with('.') && name != "target" && !name.contains(".raydump");
            if is_ours {
                collect(&path, extension, paths);
            }
        } else if path.extension().is_some_and(|found| found == extension) {
            paths.push(path);
        }
    }
}
