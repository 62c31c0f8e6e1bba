//! `plot` and `report` given what they cannot use: one sentence that says what to do.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use formats::manifest::{End, MethodArray, Outcome, Place, QueueRecord, Record, Source};
use formats::reader::Dump;
use formats::writer::DumpWriter;

mod on_disk;

use on_disk::{sample, written};

/// Exit code, standard output and standard error of `inspector`.
fn run(command: &str, input: &Path, out: &Path, options: &[&str]) -> (i32, String, String) {
    let inspector = Command::new(env!("CARGO_BIN_EXE_inspector"))
        .args([command.as_ref(), input.as_os_str(), "--out".as_ref(), out.as_os_str()])
        .args(options)
        .output()
        .unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (inspector.status.code().unwrap(), text(inspector.stdout), text(inspector.stderr))
}

/// Both commands fail with one line that has all of these parts.
fn assert_refused(input: &Path, out: &Path, parts: &[&str]) {
    for command in ["plot", "report"] {
        let (code, _, error) = run(command, input, out, &[]);
        assert_eq!(code, 1, "{command}: {error}");
        assert!(error.starts_with("error: ") && error.lines().count() == 1, "{command}: {error}");
        for part in parts {
            assert!(error.contains(part), "{command}: no {part} in {error}");
        }
    }
}

/// Removes all files of this name below a folder.
fn remove_all(folder: &Path, name: &str) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            remove_all(&path, name);
        } else if path.ends_with(name) {
            fs::remove_file(path).unwrap();
        }
    }
}

/// Those that are asked for are drawn, and no others; one that was not measured is named with those that were.
#[test]
fn methods_that_are_asked_for_are_drawn_alone() {
    let folder = tempfile::tempdir().unwrap();
    let (dump, out) = (sample::write(folder.path()), folder.path().join("out"));
    let plot = |methods: &str| run("plot", &dump, &out, &["--figure", "net-speedup", "--methods", methods]);
    let (code, _, error) = plot("aila,ailla");
    assert_eq!((code, error.lines().count()), (1, 1), "{error}");
    assert!(error.contains("no method ailla") && error.contains("aila, "), "{error}");
    let drawn = |methods: &str| -> BTreeSet<String> {
        let (code, _, error) = plot(methods);
        assert_eq!(code, 0, "{error}");
        let mut csv = csv::Reader::from_path(out.join("net-speedup.csv")).unwrap();
        let column = csv.headers().unwrap().iter().position(|name| name == "method").unwrap();
        // The line of break-even is of no method.
        let names = csv.records().map(|record| record.unwrap()[column].to_owned());
        names.filter(|name| !name.is_empty()).collect()
    };
    assert_eq!(drawn("aila,two-point"), ["aila", "two-point"].map(str::to_owned).into());
    assert_eq!(drawn("auto"), BTreeSet::from(["auto".to_owned()]));
}

#[test]
fn an_unknown_figure_is_answered_with_those_there_are() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let (code, _, error) = run("plot", &folder.path().join("none"), &out, &["--figure", "overheads"]);
    assert_eq!((code, error.lines().count()), (1, 1));
    assert!(error.contains("no figure overheads; there are: study-speedup"), "{error}");
    assert!(!out.exists(), "nothing is made before the names are known");
}

#[test]
fn what_is_no_finished_recording_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    assert_refused(&folder.path().join("none.raydump"), &out, &["there is no recording", "none.raydump"]);
    let partial = folder.path().join("killed.raydump.partial");
    fs::rename(sample::write(folder.path()), &partial).unwrap();
    let manifest = partial.join("manifest.bin");
    let bytes = fs::read(&manifest).unwrap();
    fs::write(&manifest, &bytes[..bytes.len() - 1]).unwrap();
    assert_refused(&partial, &out, &["killed.raydump.partial is not finished", "inspector recover"]);
}

/// The rest is done, what was left out is said, and the exit code is that of a failure.
#[test]
fn one_bad_input_does_not_stop_the_others() {
    let (folder, recording) = written();
    let bad = folder.path().join("bad.raydump");
    fs::create_dir(&bad).unwrap();
    fs::write(bad.join("manifest.bin"), "").unwrap();
    let out = folder.path().join("out");
    for (command, options, made) in [
        ("plot", &["--figure", "overhead"][..], "overhead.svg"),
        ("report", &[], "report.html"),
        ("plot", &["--figure", "overhead", "--json"], "overhead.svg"),
    ] {
        let options = [&[recording.to_str().unwrap()], options].concat();
        let (code, said, error) = run(command, &bad, &out, &options);
        assert_eq!(code, 1, "{command}: {error}");
        let left_out = error.lines().find(|line| line.starts_with("left out: ")).unwrap_or_default();
        assert!(left_out.contains("bad.raydump"), "{command}: {error}");
        assert!(error.contains("error: 1 input could not be used"), "{command}: {error}");
        assert!(said.contains(made), "{command}: {said}");
        fs::remove_file(out.join(made)).unwrap();
    }
}

#[test]
fn json_that_is_no_benchmark_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("other.json");
    for text in ["{\"a\": 1}", "no JSON", ""] {
        fs::write(&file, text).unwrap();
        assert_refused(&file, folder.path(), &["other.json is not what `recorder bench --json` prints"]);
    }
}

#[test]
fn a_folder_that_cannot_be_made_is_refused() {
    let (folder, recording) = written();
    let file = folder.path().join("file");
    fs::write(&file, "no folder").unwrap();
    assert_refused(&recording, &file.join("out"), &["cannot write", "name another folder with --out"]);
}

/// Left out of all figures with its reason; an error if it alone was asked for.
fn assert_left_out(recording: &Path, out: &Path, figure: &str, parts: &[&str]) {
    let (code, said, error) = run("plot", recording, out, &[]);
    assert_eq!(code, 0, "{error}");
    let line =
        said.lines().find(|line| line.starts_with(&format!("left out: {figure}: "))).unwrap_or_default();
    for part in parts {
        assert!(line.contains(part), "no {part} in {line:?} of {said}");
    }
    assert!(said.contains("recorder record --keep") && said.contains("lies beside the replay"), "{said}");
    let (code, _, error) = run("plot", recording, out, &["--figure", figure]);
    // Besides what other figures are without.
    let errors = error.lines().filter(|line| !line.starts_with("missing: "));
    assert_eq!((code, errors.count()), (1, 1), "{error}");
    assert!(error.contains(&format!("no figure {figure} of these")), "{error}");
}

#[test]
fn recordings_without_arrays_give_the_other_figures() {
    let (folder, recording) = written();
    let out = folder.path().join("out");
    remove_all(&recording, "keys.npy");
    let (code, said, error) = run("plot", &recording, &out, &["--figure", "capsule-area"]);
    assert_eq!(code, 0, "no figure needs keys: {said}{error}");
    remove_all(&recording, "work.npy");
    assert_left_out(&recording, &out, "lane-utilisation", &["work.npy"]);
    remove_all(&recording, "hits.npy");
    remove_all(&recording, "lengths.npy");
    assert_left_out(&recording, &out, "estimator-error", &[".npy"]);
}

/// Figures of a damaged recording say what they are without, and so does the terminal.
#[test]
fn what_is_damaged_is_named_in_captions() {
    let (folder, recording) = written();
    let out = folder.path().join("out");
    let caption = |figure: &str| {
        let (code, said, error) = run("plot", &recording, &out, &["--figure", figure]);
        assert_eq!(code, 0, "{said}{error}");
        (fs::read_to_string(out.join(format!("{figure}.txt"))).unwrap(), error)
    };
    let (whole, said) = caption("capsule-area");
    assert!(!whole.contains("Missing: ") && !said.contains("missing: "), "{whole}{said}");
    let queue = "pass-001/bounce-01/closest";
    let rays = recording.join(queue).join("rays.npy");
    fs::OpenOptions::new().write(true).open(&rays).unwrap().set_len(2000).unwrap();
    for figure in ["capsule-area", "capsule-area-distribution", "estimator-error"] {
        let (caption, said) = caption(figure);
        for text in [&caption, &said] {
            assert!(text.contains("issing: "), "{figure}: {text}");
            assert!(text.contains(queue) && text.contains("is 2000 bytes long"), "{figure}: {text}");
        }
    }
    let (caption, _) = caption("lane-utilisation");
    assert!(!caption.contains("Missing: "), "it is of the rays' work: {caption}");
}

/// A recording of one queue that refers to the sample, whose arrays it lacks.
fn replay(folder: &Path, source: &Path) -> PathBuf {
    let source = Dump::open(source).unwrap();
    let record = &source.manifest().queues[0];
    let mut header = sample::header();
    let manifest_sha256 = source.manifest_sha256().unwrap();
    header.source = Source::Replayed { name: "sample.raydump".into(), manifest_sha256 };
    let mut writer = DumpWriter::create(&folder.join("replay"), header, false).unwrap();
    writer.record(&Record::Method(source.manifest().methods[0].clone())).unwrap();
    let place = Place::Method(record.id, "aila".into(), MethodArray::Permutation);
    let permutation = source.array::<u32>(&place);
    if let Ok(permutation) = permutation {
        writer.whole_array(&place, &[record.rays], &permutation[..]).unwrap();
    }
    let methods = vec!["unsorted".to_owned(), "aila".to_owned()];
    writer
        .record(&Record::Queue(QueueRecord {
            id: record.id,
            rays: record.rays,
            methods,
            mismatches: Vec::new(),
        }))
        .unwrap();
    writer.finish(End { outcome: Outcome::Complete, image: None, wall_ns: 1 }).unwrap()
}

#[test]
fn a_replay_without_its_source_says_where_it_is_looked_for() {
    let (folder, source) = written();
    let replay = replay(folder.path(), &source);
    fs::rename(&source, folder.path().join("elsewhere.raydump")).unwrap();
    let (code, said, error) = run("plot", &replay, &folder.path().join("out"), &[]);
    let all = format!("{said}{error}");
    assert_eq!(code, 1, "it has no times either: {all}");
    assert!(all.contains("it is a replay of sample.raydump, which is not in the same folder"), "{all}");
    assert!(all.contains("lies beside the replay"), "{all}");
}
