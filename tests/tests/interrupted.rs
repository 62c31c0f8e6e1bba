//! Recordings that were killed or ran out of space: what is left is recovered, or said to be nothing.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::path::Path;
use std::process::Stdio;
use std::time::Instant;

use tempfile::tempdir;
use tests::full_disk::{on_small_disk, shell};
use tests::programs::Program;
use tests::recordings::{SMALL, verify};

const KILLS: u32 = 20;

/// Recovers what lies under NAME in `folder` and checks the result; false if nothing was complete yet.
fn recovers(folder: &Path, name: &str) -> bool {
    let recovered = Program::Inspector.run(folder, &format!("recover {name}.raydump.partial"));
    if recovered.code != Some(0) {
        recovered.failed_with(1, &["nothing was complete yet"]);
        return false;
    }
    verify(folder, name);
    let info = Program::Inspector.run(folder, &format!("info {name}.raydump --json")).succeeded().json();
    assert_eq!(info["complete"], false, "a recovered recording is not complete");
    true
}

#[test]
fn killed_at_any_moment_it_recovers() {
    let folder = tempdir().unwrap();
    let line = |name: &str| {
        format!(
            "record builtin:atrium?triangles=4000 --out {name}.raydump --backend cpu --repeats 1 --keep-passes all {SMALL}"
        )
    };
    // The first run also fills the cache of hierarchies, so the second shows how long one takes.
    Program::Recorder.run(folder.path(), &line("first")).succeeded();
    let start = Instant::now();
    Program::Recorder.run(folder.path(), &line("whole")).succeeded();
    let whole = start.elapsed();
    // A fixed sequence of fractions, so that a failure can be run again.
    let mut random = fastrand::Rng::with_seed(12_345);
    let mut recovered = 0;
    for kill in 0..KILLS {
        let delay = whole.mul_f64(random.f64());
        let name = format!("kill-{kill}");
        let line = line(&name);
        let mut command = Program::Recorder.command(line.split_whitespace());
        let mut child =
            command.current_dir(folder.path()).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        std::thread::sleep(delay);
        child.kill().unwrap();
        child.wait().unwrap();
        println!("kill {kill} after {} ms of {} ms", delay.as_millis(), whole.as_millis());
        if folder.path().join(format!("{name}.raydump.partial")).exists() {
            recovered += u32::from(recovers(folder.path(), &name));
        } else if folder.path().join(format!("{name}.raydump")).exists() {
            verify(folder.path(), &name);
        }
    }
    assert!(
        recovered >= KILLS / 5,
        "only {recovered} of {KILLS} kills left something: they came too early or too late"
    );
}

#[test]
fn a_full_disk_is_one_clear_error_and_recovers() {
    let folder = tempdir().unwrap();
    let line = format!("record builtin:cornell --out small/full.raydump --backend cpu --repeats 1 {SMALL}");
    let Some(outcome) = on_small_disk(folder.path(), "512k", &line) else { return };
    outcome.failed_with(1, &["no space is left", "recover"]);
    assert!(
        recovers(&folder.path().join("kept"), "full"),
        "nothing was left of the recording on the full disk"
    );
}

/// Neither what has no room to begin nor what is removed at the end promises to be recovered.
#[test]
fn a_full_disk_keeps_nothing_of_what_cannot_begin_or_is_a_benchmark() {
    let small = "--backend cpu --width 64 --height 36 --bounces 2 --repeats 1";
    for (size, line) in [
        ("16k", format!("record builtin:cornell --out small/full.raydump {small}")),
        ("256k", format!("bench capture builtin:cornell --folder small {small}")),
    ] {
        let folder = tempdir().unwrap();
        let Some(outcome) = on_small_disk(folder.path(), size, &line) else { return };
        outcome.failed_with(1, &["no space is left", "nothing was recorded"]);
        assert!(!outcome.stderr.contains("recover`"), "{}", outcome.stderr);
        let left: Vec<_> = std::fs::read_dir(folder.path().join("kept")).unwrap().collect();
        assert!(left.is_empty(), "{left:?}");
    }
}

#[test]
fn a_file_that_may_not_grow_is_one_clear_error_and_recovers() {
    let folder = tempdir().unwrap();
    // In units of 512 bytes; the rays of a queue need 72 KiB.
    let script = "trap '' XFSZ; ulimit -f 64; exec \"$@\"";
    let line = format!("record builtin:cornell --out limited.raydump --backend cpu --repeats 1 {SMALL}");
    shell(folder.path(), &[], script, &line).failed_with(1, &["limited.raydump", "rays.npy"]);
    recovers(folder.path(), "limited");
}
