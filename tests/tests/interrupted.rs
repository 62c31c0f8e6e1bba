//! Recordings that were killed or ran out of space: what is left is recovered, or said to be nothing.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::fs;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Instant;

use tempfile::tempdir;
use tests::programs::{Outcome, Program, finish};
use tests::recordings::SMALL;

const KILLS: u32 = 20;

/// Recovers what lies under NAME in `folder` and checks the result; false if nothing was complete yet.
fn recovers(folder: &Path, name: &str) -> bool {
    let recovered = Program::Inspector.run(folder, &format!("recover {name}.raydump.partial"));
    if recovered.code != Some(0) {
        recovered.failed_with(1, &["nothing was complete yet"]);
        return false;
    }
    Program::Inspector.run(folder, &format!("verify {name}.raydump")).succeeded();
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
            Program::Inspector.run(folder.path(), &format!("verify {name}.raydump")).succeeded();
        }
    }
    assert!(
        recovered >= KILLS / 5,
        "only {recovered} of {KILLS} kills left something: they came too early or too late"
    );
}

fn say(message: &str) {
    // Past the test harness, which shows what a passing test prints to nobody.
    let _ = writeln!(std::io::stderr(), "{message}");
}

/// Runs a shell script with the recorder's path, then `line`'s words, as its arguments.
fn shell(folder: &Path, wrapper: &[&str], script: &str, line: &str) -> Outcome {
    let mut words = wrapper.iter().copied().chain(["sh", "-c", script, "sh"]);
    let mut command = Command::new(words.next().unwrap());
    command.args(words).arg(Program::Recorder.path()).args(line.split_whitespace());
    finish(command.current_dir(folder).stdin(Stdio::null()).env("XDG_CACHE_HOME", folder))
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

#[test]
fn a_full_disk_is_one_clear_error_and_recovers() {
    let Some(mounter) = mounter() else {
        say("NOTE: no tmpfs can be mounted here; a limit on the size of files stands in for the full disk");
        return;
    };
    let folder = tempdir().unwrap();
    fs::create_dir(folder.path().join("small")).unwrap();
    // The mount ends with the shell, so what was written is copied out first.
    let script =
        "mount -t tmpfs -o size=512k tmpfs small || exit 99; \"$@\"; code=$?; cp -a small/. kept; exit $code";
    fs::create_dir(folder.path().join("kept")).unwrap();
    let line = format!("record builtin:cornell --out small/full.raydump --backend cpu --repeats 1 {SMALL}");
    shell(folder.path(), mounter, script, &line).failed_with(1, &["no space is left", "recover"]);
    assert!(
        recovers(&folder.path().join("kept"), "full"),
        "nothing was left of the recording on the full disk"
    );
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
