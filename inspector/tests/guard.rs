//! What the program prints and leaves behind when something is wrong: full disks, odd names, lost sources.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use formats::manifest::{Header, Record, Source};
use formats::reader::Dump;

mod on_disk;

use on_disk::{sample, written};

/// Erases a screen, turns text around, steers a terminal by one byte.
const STEERING: &str = "box\x1b[2J\u{202e}\u{9b}31m\u{2066}";

fn inspector(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_inspector"));
    command.args(arguments);
    command
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// Writes a header in place of a recording's own.
fn with_header(dump: &Path, change: impl FnOnce(&mut Header)) {
    sample::edit_manifest(dump, |records| {
        let Some(Record::Header(header)) = records.first_mut() else { panic!("no header") };
        change(header);
    });
}

/// The sample, and beside it a copy of its manifest that says it is a replay of it.
fn replayed(folder: &Path) -> [PathBuf; 2] {
    let source = sample::write(folder);
    let replay = folder.join("replay.raydump");
    fs::create_dir(&replay).unwrap();
    fs::copy(source.join("manifest.bin"), replay.join("manifest.bin")).unwrap();
    let manifest_sha256 = Dump::open(&source).unwrap().manifest_sha256().unwrap();
    with_header(&replay, |header| {
        header.source = Source::Replayed { name: "sample.raydump".to_owned(), manifest_sha256 };
    });
    [source, replay]
}

fn info(dump: &Path) -> (String, serde_json::Value) {
    let dump = dump.to_str().unwrap();
    let [words, json] = [&["info", dump][..], &["info", dump, "--json"]].map(|arguments| {
        let output = inspector(arguments).output().unwrap();
        assert!(output.status.success(), "{}", text(&output.stderr));
        text(&output.stdout)
    });
    // Without the breaks of lines that are longer than a terminal is wide.
    let words = words.replace("\n            ", " ");
    (words, serde_json::from_str(&json).unwrap())
}

#[test]
fn info_says_whose_rays_they_are() {
    let folder = tempfile::tempdir().unwrap();
    let [source, replay] = replayed(folder.path());
    let (words, json) = info(&source);
    assert!(!words.contains("\nsource"), "{words}");
    assert!(json.get("source_is").is_none());
    let expect = |found: &str, part: &str| {
        let (words, json) = info(&replay);
        assert!(words.contains("a replay: its rays are those of sample.raydump, "), "{words}");
        assert!(words.contains(part), "{words}");
        assert_eq!((&json["source"]["how"], &json["source_is"]), (&"replayed".into(), &found.into()));
    };
    expect("here", "which lies beside it, as it was");
    with_header(&source, |header| header.options.seed += 1);
    expect("changed", "is another recording by now");
    fs::remove_dir_all(&source).unwrap();
    expect("missing", "which is not beside it");
    with_header(&replay, |header| {
        header.source = Source::Imported { name: "rays.npy".to_owned(), sha256: [0xab; 32] };
    });
    let (words, json) = info(&replay);
    assert!(words.contains("an import: its rays are those of rays.npy (sha256 abababababab…)"), "{words}");
    assert_eq!(json["source"]["how"], "imported");
}

#[test]
fn every_error_is_said_once() {
    let (folder, dump) = written();
    let (dump, out) = (dump.to_str().unwrap(), folder.path().join("out"));
    let out = out.to_str().unwrap();
    let full = if cfg!(target_os = "linux") { "/dev/full" } else { "no/such/folder" };
    for (arguments, part) in [
        (&["export", dump, "--format", "csv", "--method", "nope", "--out", out][..], "nope"),
        (&["export", dump, "--format", "csv", "--filter", "bounse == 1", "--out", out], "which no ray has"),
        (&["shot", dump, "--method", "nope", "--out", out], "was not ordered by nope"),
        (&["shot", dump, "--what-if", "(ox oq)*4", "--out", out], "unknown coordinate 'oq'"),
        (&["shot", dump, "--filter", "bounse == 1", "--out", out], "which no ray has"),
        (&["shot", dump, "--view", "timings", "--size", "64x64", "--out", full], "cannot write"),
        (&["shot", dump, "--session", full, "--out", out], "cannot be read"),
        (&["info", "nowhere.raydump"], "there is no recording"),
        (&["plot", full, "--out", out], "not a recording"),
    ] {
        let output = inspector(arguments).output().unwrap();
        let said = text(&output.stderr);
        assert_eq!((output.status.code(), said.matches(part).count()), (Some(1), 1), "{arguments:?}: {said}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn full_outputs_are_errors_and_never_panics() {
    let (folder, dump) = written();
    let (dump, out) = (dump.to_str().unwrap(), folder.path().join("out"));
    let out = out.to_str().unwrap();
    let full = || Stdio::from(fs::OpenOptions::new().write(true).open("/dev/full").unwrap());
    let plot = ["plot", dump, "--figure", "table-fill", "--out", out];
    for arguments in [&plot[..], &["info", dump], &["info", dump, "--json"], &["verify", dump], &["--help"]] {
        let output = inspector(arguments).stdout(full()).output().unwrap();
        assert_eq!(output.status.code(), Some(1), "{arguments:?}");
        assert!(text(&output.stderr).contains("cannot write to standard output"), "{arguments:?}");
    }
    let code = |command: &mut Command| command.status().unwrap().code();
    assert_eq!(code(inspector(&plot).stderr(full()).stdout(Stdio::null())), Some(0));
    for (arguments, expected) in [(&["info", "nowhere.raydump"][..], 1), (&["info", "--nothing"], 2)] {
        assert_eq!(code(inspector(arguments).stderr(full())), Some(expected), "{arguments:?}");
    }
}

/// A figure that cannot be completed leaves the one before. Pictures are written in the same way: a GPU's driver
/// does not live with so small files.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_leaves_what_was_there() {
    let (folder, dump) = written();
    let out = folder.path().join("out");
    fs::create_dir(&out).unwrap();
    let figure = out.join("table-fill.svg");
    fs::write(&figure, "before").unwrap();
    // No file of this process may be longer than a block: what a disk with so little room says, too.
    let limited = |words: &str| {
        let script = format!("trap '' XFSZ; ulimit -f 1; exec \"$0\" {words}");
        let mut command = Command::new("bash");
        command.args(["-c", &script, env!("CARGO_BIN_EXE_inspector")]);
        command.current_dir(folder.path()).output().unwrap()
    };
    let dump = dump.file_name().unwrap().to_str().unwrap();
    for words in [
        format!("plot {dump} --figure table-fill --out out"),
        format!("export {dump} --format csv --out out"),
    ] {
        let output = limited(&words);
        assert_eq!(output.status.code(), Some(1), "{words}: {}", text(&output.stderr));
        assert!(text(&output.stderr).contains("File too large"), "{words}: {}", text(&output.stderr));
    }
    assert_eq!(fs::read_to_string(figure).unwrap(), "before");
    let left = fs::read_dir(&out).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    assert!(left.into_iter().all(|name| !name.contains("partial") && !name.contains("csv")));
}

#[test]
fn names_of_files_do_not_reach_a_terminal() {
    let (folder, dump) = written();
    with_header(&dump, |header| {
        for text in [&mut header.scene.name, &mut header.adapter.name, &mut header.options.camera] {
            STEERING.clone_into(text);
        }
        header.notices.push(STEERING.to_owned());
    });
    let odd = folder.path().join(format!("{STEERING}.raydump"));
    fs::rename(&dump, &odd).unwrap();
    let (odd, out) = (odd.to_str().unwrap(), folder.path().join("out"));
    let out = out.to_str().unwrap();
    let missing = format!("{odd}-missing");
    for arguments in [
        &["info", odd][..],
        &["info", odd, "--json"],
        &["verify", odd],
        &["plot", odd, "--figure", "trace-speedup", "--out", out],
        &["report", odd, "--out", out],
        &["export", odd, "--format", "csv", "--out", out],
        &["info", &missing],
        &[&format!("--{STEERING}")],
    ] {
        let output = inspector(arguments).output().unwrap();
        for shown in [text(&output.stdout), text(&output.stderr)] {
            let found = shown.chars().find(|c| "\x1b\u{202e}\u{9b}\u{2066}".contains(*c));
            assert_eq!(found, None, "{arguments:?}: {shown:?}");
        }
    }
    let json = inspector(&["info", odd, "--json"]).output().unwrap().stdout;
    let json: serde_json::Value = serde_json::from_slice(&json).unwrap();
    assert_eq!(json["scene"]["name"], STEERING);
    for name in ["trace-speedup.svg", "trace-speedup.csv", "trace-speedup.tex", "report.html"] {
        let file = fs::read_to_string(folder.path().join("out").join(name)).unwrap();
        assert!(!file.contains(['\x1b', '\u{202e}', '\u{9b}']), "{name}");
    }
}

/// A scene with a name of 5 MB takes no more memory than any other.
#[cfg(target_os = "linux")]
#[test]
fn long_names_are_shortened_before_they_are_drawn() {
    let (folder, dump) = written();
    let long = "name ".repeat(1 << 20);
    with_header(&dump, |header| {
        for text in [&mut header.scene.name, &mut header.adapter.name, &mut header.options.camera] {
            text.clone_from(&long);
        }
    });
    for words in
        ["plot s.raydump --out o --figure trace-speedup", "report s.raydump --out o", "info s.raydump"]
    {
        // 700 MiB of addresses: far less than a figure with such a name would take.
        let script = format!("ulimit -v 700000; exec \"$0\" {words}");
        let mut command = Command::new("bash");
        command.args(["-c", &script.replace("s.raydump", "sample.raydump"), env!("CARGO_BIN_EXE_inspector")]);
        let output = command.current_dir(folder.path()).output().unwrap();
        assert!(output.status.success(), "{words}: {}", text(&output.stderr));
        assert!(output.stdout.len() < 100_000, "{words}: {} bytes", output.stdout.len());
    }
    for file in fs::read_dir(folder.path().join("o")).unwrap() {
        let file = file.unwrap();
        assert!(file.metadata().unwrap().len() < 1 << 20, "{:?}", file.file_name());
    }
}

#[cfg(unix)]
#[test]
fn pipes_and_devices_are_no_files() {
    let (folder, dump) = written();
    let pipe = folder.path().join("x.raydump");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let (dump, pipe) = (dump.to_str().unwrap(), pipe.to_str().unwrap());
    let out = folder.path().join("out");
    let out = out.to_str().unwrap();
    for arguments in [
        &["shot", dump, "--session", pipe, "--out", out][..],
        &["shot", dump, "--session", "/dev/zero", "--out", out],
        &["plot", pipe, "--out", out],
        &["info", pipe],
    ] {
        let output = inspector(arguments).output().unwrap();
        assert_eq!(output.status.code(), Some(1), "{arguments:?}");
        assert!(text(&output.stderr).contains("expected"), "{}", text(&output.stderr));
    }
    // A picture may go down a pipe, and nothing else goes with it.
    let shot = ["shot", dump, "--view", "timings", "--size", "64x64", "--out", "/dev/stdout"];
    let output = inspector(&shot).stdout(Stdio::piped()).output().unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(output.stdout.ends_with(b"IEND\xae\x42\x60\x82"), "something follows the picture");
}

#[test]
fn a_picture_that_lacks_what_is_damaged_is_a_failure() {
    let (folder, dump) = written();
    let out = folder.path().join("p.png");
    let shot = |view: &str| {
        let arguments = ["shot", dump.to_str().unwrap(), "--view", view, "--size", "960x640", "--out"];
        inspector(&arguments).arg(&out).output().unwrap()
    };
    assert!(shot("pixels").status.success());
    let cut = |name: &str| {
        let file = dump.join(name);
        let bytes = fs::read(&file).unwrap();
        fs::write(file, &bytes[..bytes.len() - 1]).unwrap();
    };
    cut("scene/positions.npy");
    for (view, expected) in [("pixels", Some(0)), ("rays", Some(1)), ("window", Some(1))] {
        fs::remove_file(&out).unwrap();
        let output = shot(view);
        assert_eq!(output.status.code(), expected, "{view}: {}", text(&output.stderr));
        assert!(out.exists(), "{view}");
        assert_eq!(text(&output.stderr).contains("positions.npy"), expected == Some(1), "{view}");
    }
    cut("pass-001/bounce-01/closest/rays.npy");
    for view in ["pixels", "rays", "length-table", "coherence", "rays-table"] {
        let output = shot(view);
        assert_eq!(output.status.code(), Some(1), "{view}");
        assert!(text(&output.stderr).contains("rays.npy"), "{view}: {}", text(&output.stderr));
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_window_without_a_screen_or_a_recording_is_a_sentence() {
    let (folder, dump) = written();
    let opened = |dump: &Path, display: Option<&str>| {
        let mut command = inspector(&[dump.to_str().unwrap()]);
        command.env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET").env_remove("DISPLAY");
        command.envs(display.map(|display| ("DISPLAY", display))).env("HOME", folder.path());
        let output = command.output().unwrap();
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{said}");
        assert!(said.lines().count() == 1 && !said.contains(".rs") && !said.contains("panicked"), "{said}");
        said
    };
    for display in [None, Some(":59999")] {
        let said = opened(&dump, display);
        assert!(said.starts_with("error: cannot open the window: "), "{said}");
    }
    // What can be done is said of the recording, whatever else is missing.
    let said = opened(&folder.path().join("none.raydump"), None);
    assert!(said.contains("none.raydump cannot be opened: ") && !said.contains("screen"), "{said}");
}

/// All files are written beside their place and renamed, whoever writes them.
#[test]
fn nothing_is_written_in_place() {
    let (mut folders, mut files) = (vec![PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("src")], 0);
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            // All of the gallery is a test; tables for others lie in a folder that takes its name when it is complete.
            if path.is_dir() {
                folders.extend(
                    (!path.ends_with("gallery") && !path.ends_with("export/parquet")).then_some(path),
                );
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                let source = fs::read_to_string(&path).unwrap();
                let source = source.split("#[cfg(test)]\nmod tests").next().unwrap();
                for call in ["File::create", "fs::write(", "fs::rename(", "Writer::from_path(", "OpenOptions"]
                {
                    assert!(
                        !source.contains(call),
                        "{}: {call}: use formats::files::replace",
                        path.display()
                    );
                }
                files += 1;
            }
        }
    }
    assert!(files > 100, "{files} files");
}
