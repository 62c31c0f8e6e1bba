//! The recorder where there is no room: in a shell, on a small file system.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use crate::drivers::skipped;
use crate::programs::{Outcome, Program, finish};

/// Runs a shell script with the recorder's path, then `line`'s words, as its arguments.
pub fn shell(folder: &Path, wrapper: &[&str], script: &str, line: &str) -> Outcome {
    let mut words = wrapper.iter().copied().chain(["sh", "-c", script, "sh"]);
    let mut command = Command::new(words.next().unwrap());
    command.args(words).arg(Program::Recorder.path()).args(line.split_whitespace());
    finish(command.current_dir(folder).stdin(Stdio::null()).env("XDG_CACHE_HOME", folder))
}

/// Runs the recorder in `folder`, in which `small` is a file system of `size`; what is in it at the end is copied to
/// `kept`. `None`, and a word about it, where no file system can be mounted.
///
/// # Panics
/// If the folders cannot be made.
pub fn on_small_disk(folder: &Path, size: &str, line: &str) -> Option<Outcome> {
    let Some(mounter) = mounter() else {
        skipped("full disks", "no tmpfs can be mounted here");
        return None;
    };
    for name in ["small", "kept"] {
        fs::create_dir(folder.join(name)).unwrap();
    }
    // The mount ends with the shell, so what was written is copied out first.
    let script = format!(
        "mount -t tmpfs -o size={size} tmpfs small || exit 99; \"$@\"; code=$?; cp -a small/. kept; exit $code"
    );
    Some(shell(folder, mounter, &script, line))
}

/// How a small file system can be mounted here: as root, or as root of a namespace of one's own.
fn mounter() -> Option<&'static [&'static str]> {
    let ways: [&[&str]; 2] = [&["unshare", "--mount"], &["unshare", "--mount", "--user", "--map-root-user"]];
    let works = |way: &&&[&str]| {
        let script = "mount -t tmpfs -o size=64k tmpfs \"$0\"";
        let tried = Command::new(way[0])
            .args(&way[1..])
            .args(["sh", "-c", script])
            .arg(std::env::temp_dir())
            .output();
        tried.is_ok_and(|output| output.status.success())
    };
    ways.iter().find(works).copied()
}
