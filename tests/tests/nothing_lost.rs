//! What `--force`, a second recorder or a signal must not cost: recordings, and files that are none.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use formats::manifest::{Place, QueueArray, QueueId};
use formats::ray::Kind;
use formats::reader::Dump;
use formats::writer::DumpWriter;
use recorder::capture::Capture;
use tempfile::tempdir;
use tests::programs::{Program, until};
use tests::recordings::{arrays, assert_same, record, verify};

const CPU: &str = "--backend cpu --repeats 1 --methods aila";

/// Every file of a recording and its bytes.
fn files(recording: &Path) -> std::collections::BTreeMap<String, Vec<u8>> {
    let mut files = arrays(recording);
    files.insert("manifest.bin".to_owned(), fs::read(recording.join("manifest.bin")).unwrap());
    files
}

#[cfg(unix)]
#[test]
fn a_source_is_never_replaced() {
    let folder = tempdir().unwrap();
    let path = folder.path();
    record(path, "a", "builtin:cornell", CPU);
    Program::Recorder.run(path, &format!("replay a.raydump --out b {CPU}")).succeeded();
    std::os::unix::fs::symlink("a.raydump", path.join("link.raydump")).unwrap();
    fs::create_dir(path.join("other")).unwrap();
    std::os::unix::fs::symlink(path, path.join("other/here")).unwrap();
    let (a, b) = (files(&path.join("a.raydump")), files(&path.join("b.raydump")));
    let rays = "a.raydump/pass-001/bounce-01/closest/rays.npy";
    for line in [
        "replay a.raydump --out a",
        "replay a.raydump --out ./other/../a.raydump/",
        "replay link.raydump --out a",
        "replay a.raydump --out link",
        "replay a.raydump --out other/here/a",
        "replay a.raydump --out a.raydump/inside",
        "replay b.raydump --out a",
        "replay b.raydump --out b",
        "replay b.raydump --out a.raydump/.",
        "record builtin:cornell --out a.raydump/pass-001/inside",
        &format!("import --scene builtin:cornell --rays {rays} --out a"),
    ] {
        let outcome = Program::Recorder.run(path, &format!("{line} {CPU} --force"));
        outcome.failed_with(1, &["would replace or lie in", "another name"]);
        assert_same(&files(&path.join("a.raydump")), &a, line);
        assert_same(&files(&path.join("b.raydump")), &b, line);
    }
    // Nor does anything else write into a recording.
    std::os::unix::fs::symlink("a.raydump/manifest.bin", path.join("link.png")).unwrap();
    for line in [
        "shot b.raydump --size 64x64 --out a.raydump/manifest.bin",
        "shot b.raydump --size 64x64 --out link.png",
        "plot b.raydump --out a.raydump/scene --figure overhead",
        "report b.raydump --out b.raydump",
        "export a.raydump --format csv --out link.raydump",
    ] {
        let outcome = Program::Inspector.run(path, line);
        outcome.failed_with(1, &["lies in the recording"]);
        assert_same(&files(&path.join("a.raydump")), &a, line);
        assert_same(&files(&path.join("b.raydump")), &b, line);
    }
    let left: Vec<_> = fs::read_dir(path).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert_eq!(left.len(), 5, "{left:?}");
}

/// An error of a device ends a recording so.
#[test]
fn what_was_handed_over_before_an_error_is_written() {
    const IDS: usize = 8 << 20;
    let folder = tempdir().unwrap();
    record(folder.path(), "a", "builtin:cornell", CPU);
    let header = Dump::open(&folder.path().join("a.raydump")).unwrap().manifest().header.clone();
    let writer = DumpWriter::create(&folder.path().join("b.raydump"), header, false).unwrap();
    let id = QueueId { pass: 0, bounce: 0, kind: Kind::Closest };
    let place = Place::Queue(id, QueueArray::PathIds);
    let mut capture = Capture::start(writer).unwrap();
    capture.whole_array(place.clone(), &[IDS as u64], &vec![7_u32; IDS]).unwrap();
    drop(capture);
    let partial = Dump::open(&folder.path().join("b.raydump.partial")).unwrap();
    assert!(partial.array::<u32>(&place).unwrap().iter().all(|&id| id == 7));
}

#[test]
fn force_replaces_what_the_manifest_lists_and_nothing_else() {
    let folder = tempdir().unwrap();
    let path = folder.path();
    record(path, "a", "builtin:cornell", CPU);
    let before = files(&path.join("a.raydump"));
    let again =
        format!("record builtin:cornell --out a --force {CPU} --width 32 --height 18 --bounces 1 --passes 1");
    // The second looks like an array, but no record names it.
    for stray in ["pass-001/thoughts.txt", "pass-001/bounce-77/closest/rays.npy", "scene/view.json"] {
        let stray = path.join("a.raydump").join(stray);
        fs::create_dir_all(stray.parent().unwrap()).unwrap();
        fs::write(&stray, "mine").unwrap();
        let outcome = Program::Recorder.run(path, &again);
        outcome.failed_with(1, &["a.raydump holds", "not replaced, even by --force"]);
        assert_eq!(fs::read(&stray).unwrap(), b"mine");
        fs::remove_file(stray).unwrap();
    }
    assert_same(&files(&path.join("a.raydump")), &before, "after three refusals");
    Program::Recorder.run(path, &again).succeeded();
    assert!(files(&path.join("a.raydump")).len() < before.len());
    let left: Vec<_> = fs::read_dir(path).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert_eq!(left, ["a.raydump"], "nothing is left beside it");
}

/// A recording that takes longer than any test.
const LONG: &str = "record builtin:cornell --out long --backend cpu --width 400 --height 400 --passes 999";

/// Starts a long recording and waits until some of it is there.
#[cfg(unix)]
fn begun(mut command: Command, folder: &Path) -> std::process::Child {
    let child = command.current_dir(folder).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let array = folder.join("long.raydump.partial/scene/materials.npy");
    until("something is recorded", || array.exists());
    child
}

/// The recorder, started by another program.
#[cfg(unix)]
fn recorder_through(program: &str, arguments: &[&str]) -> Command {
    let recorder = Program::Recorder.command(LONG.split_whitespace());
    let mut command = Command::new(program);
    command.args(arguments).arg(recorder.get_program()).args(recorder.get_args());
    command.envs(recorder.get_envs().filter_map(|(name, value)| Some((name, value?))));
    command
}

#[cfg(unix)]
fn send(signal: &str, child: &std::process::Child) {
    Command::new("kill").args(["-s", signal, &child.id().to_string()]).status().unwrap();
}

/// A script has what it runs in the background ignore the interrupts of its terminal.
#[cfg(target_os = "linux")]
#[test]
fn an_interrupt_that_was_to_be_ignored_is() {
    use std::os::unix::process::ExitStatusExt;
    let folder = tempdir().unwrap();
    let command = recorder_through("sh", &["-c", "trap '' INT; exec \"$0\" \"$@\""]);
    let mut child = begun(command, folder.path());
    send("INT", &child);
    std::thread::sleep(Duration::from_millis(500));
    assert!(child.try_wait().unwrap().is_none(), "it still records");
    send("TERM", &child);
    assert_eq!(child.wait().unwrap().signal(), Some(15));
}

#[cfg(unix)]
#[test]
fn signals_end_a_recording_with_a_sentence_and_a_second_recorder_waits_its_turn() {
    use std::os::unix::process::ExitStatusExt;
    let folder = tempdir().unwrap();
    for (name, number) in [("INT", 2), ("TERM", 15)] {
        // These tests may run in the background of a script themselves.
        let command = if cfg!(target_os = "linux") {
            recorder_through("env", &["--default-signal=INT"])
        } else {
            Program::Recorder.command(LONG.split_whitespace())
        };
        let child = begun(command, folder.path());
        if name == "INT" {
            for force in ["", " --force"] {
                let second = Program::Recorder.run(folder.path(), &format!("{LONG}{force}"));
                second.failed_with(1, &["long.raydump.partial", "being written by another process"]);
            }
        }
        send(name, &child);
        let output = child.wait_with_output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.signal(), Some(number), "{said}");
        // A slow machine says once a minute how far it is.
        let words: Vec<&str> = said.lines().filter(|line| !line.contains("% done, ")).collect();
        assert_eq!(words.len(), 1, "{said}");
        assert!(
            words[0].contains("inspector recover") && words[0].contains("long.raydump.partial"),
            "{said}"
        );
        Program::Inspector.run(folder.path(), "recover long.raydump.partial").succeeded();
        verify(folder.path(), "long");
        fs::remove_dir_all(folder.path().join("long.raydump")).unwrap();
    }
}

#[cfg(unix)]
#[test]
fn pipes_and_devices_are_no_rays() {
    let folder = tempdir().unwrap();
    assert!(Command::new("mkfifo").arg(folder.path().join("pipe.npy")).status().unwrap().success());
    for rays in ["pipe.npy", "/dev/zero", "."] {
        let line = format!("import --scene builtin:cornell --rays {rays} --out x {CPU}");
        Program::Recorder.run(folder.path(), &line).failed_with(1, &["cannot read", "expected a plain file"]);
    }
}
