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
    let is_ours = |name: &str| !name.starts_with('.') && name != "target" && !name.contains(".raydump");
    let mut paths = files_below(&root().join(folder), is_ours);
    paths.retain(|path| Path::new(path).extension().is_some_and(|found| found == extension));
    paths.sort();
    assert!(!paths.is_empty(), "no .{extension} file found below {folder:?}, expected at least one");
    paths.into_iter().map(|path| read(root().join(folder).join(path))).collect()
}

/// Paths of all files in a folder and in those below it that are to be entered by their names, from there, with `/`
/// between names.
///
/// # Panics
/// If a folder cannot be listed.
pub fn files_below(top: &Path, is_entered: impl Fn(&str) -> bool) -> Vec<String> {
    let (mut files, mut folders) = (Vec::new(), vec![String::new()]);
    while let Some(folder) = folders.pop() {
        let path = top.join(&folder);
        let entries =
            fs::read_dir(&path).unwrap_or_else(|error| panic!("cannot list {}: {error}", path.display()));
        for entry in entries.map(|entry| entry.expect("the folder can be listed")) {
            let name = entry.file_name().to_string_lossy().into_owned();
            let below = format!("{folder}{name}");
            if !entry.path().is_dir() {
                files.push(below);
            } else if is_entered(&name) {
                folders.push(below + "/");
            }
        }
    }
    files
}

fn read(path: PathBuf) -> Source {
    let text =
        fs::read_to_string(&path).unwrap_or_else(|error| panic!("cannot read {}: {error}", path.display()));
    let relative = path.strip_prefix(root()).expect("the file was found below the root");
    let path = relative.iter().map(|part| part.to_string_lossy()).collect::<Vec<_>>().join("/");
    Source { path, text }
}
