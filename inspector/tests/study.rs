//! Means over a study: what is kept of recordings is what they say, and is made anew where it is not.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use formats::reader::Dump;
use formats::study::{JOB_VERSION, JobRecord, PLAN_NAME, SUMMARIES_NAME, Study};
use inspector::analysis::study::summary::{RecordingSummary, summary};
use inspector::analysis::{AnalysisOptions, Depth, StudyAnalysis, analyse, analyse_studies};
use serde_json::Value;

#[path = "../../formats/tests/sample/mod.rs"]
mod sample;

/// A study of jobs that each have the sample; the last one has failed.
fn study(folder: &Path) -> PathBuf {
    let root = folder.join("study");
    fs::create_dir_all(&root).unwrap();
    fs::write(root.join(PLAN_NAME), "scenes = [\"box\"]").unwrap();
    for (name, failure) in [("box-a-0", None), ("box-b-0", None), ("box-c-0", Some("it was killed"))] {
        let job = root.join("jobs").join(name);
        fs::create_dir_all(&job).unwrap();
        fs::rename(sample::write(&job), job.join("recording.raydump")).unwrap();
        let record = JobRecord {
            rayscope_job: JOB_VERSION,
            content_hash: String::new(),
            scene: "box".into(),
            camera: name.into(),
            seed: 0,
            commands: vec![],
            recordings: vec!["recording.raydump".into()],
            host: "here".into(),
            seconds: 1.0,
            bytes: 1,
            failure: failure.map(str::to_owned),
        };
        record.write(&job).unwrap();
    }
    root
}

fn kept(root: &Path) -> Vec<PathBuf> {
    fs::read_dir(root.join(SUMMARIES_NAME)).unwrap().map(|entry| entry.unwrap().path()).collect()
}

#[test]
fn what_is_kept_is_what_the_recording_says() {
    let folder = tempfile::tempdir().unwrap();
    let root = study(folder.path());
    let study = Study::open(&root).unwrap();
    let recording = study.recordings().next().unwrap();
    let (made, notice) = summary(&study, &recording).unwrap();
    assert_eq!((&made, notice), (&RecordingSummary::of(&recording).unwrap(), None));
    assert!(!made.times.is_empty() && !made.areas.is_empty(), "{made:?}");
    let [file] = &kept(&root)[..] else { panic!("one file") };
    assert_eq!(summary(&study, &recording).unwrap().0, made);
    // It is what was kept that is read.
    let other = fs::read_to_string(file).unwrap().replace("\"seed\":", "\"seed\":1");
    fs::write(file, &other).unwrap();
    assert_ne!(summary(&study, &recording).unwrap().0, made);
    // What is no summary is made anew.
    fs::write(file, &other[..other.len() / 2]).unwrap();
    assert_eq!(summary(&study, &recording).unwrap().0, made);
    assert_eq!(summary(&study, &recording).unwrap().0, made);
    // Another recording, here by its manifest's last byte, has another summary, or none if it is damaged.
    let manifest = recording.join("manifest.bin");
    let mut bytes = fs::read(&manifest).unwrap();
    *bytes.last_mut().unwrap() ^= 1;
    fs::write(&manifest, bytes).unwrap();
    assert!(summary(&study, &recording).is_err());
}

#[test]
fn the_queues_of_a_recording_are_kept_and_read() {
    let folder = tempfile::tempdir().unwrap();
    let root = study(folder.path());
    let studies = [Study::open(&root).unwrap()];
    let dumps = [Dump::open(&studies[0].recordings().next().unwrap()).unwrap()];
    let queues = || {
        let analysis = analyse_studies(&studies, &dumps).unwrap();
        assert_eq!(analysis.study.unwrap().notices, [""; 0]);
        serde_json::to_value(&analysis.recordings[0].queues).unwrap()
    };
    let options = AnalysisOptions { depth: Depth::Arrays, ..AnalysisOptions::default() };
    let known = serde_json::to_value(&analyse(&dumps, &options).unwrap().recordings[0].queues).unwrap();
    let has_area = |queue: &Value| queue["orders"][0]["coherence"]["mean_capsule_area"].is_f64();
    assert!(known.as_array().unwrap().iter().any(has_area), "{known}");
    assert_eq!((queues(), queues()), (known.clone(), known.clone()));
    // It is what was kept that is read.
    let is_of_queues = |path: &&PathBuf| path.to_string_lossy().ends_with("-queues.json");
    let files = kept(&root);
    let [file] = files.iter().filter(is_of_queues).collect::<Vec<_>>()[..] else {
        panic!("one file: {files:?}")
    };
    let other = fs::read_to_string(file).unwrap().replace("\"groups\":", "\"groups\":1");
    fs::write(file, other).unwrap();
    assert_ne!(queues(), known);
}

#[test]
fn a_damaged_recording_is_left_out_and_the_rest_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let root = study(folder.path());
    let study = Study::open(&root).unwrap();
    let whole = StudyAnalysis::of(std::slice::from_ref(&study));
    assert!(whole.notices.is_empty() && whole.groups[0].views == 2, "{whole:?}");
    fs::remove_file(study.recordings().next().unwrap().join("manifest.bin")).unwrap();
    let rest = StudyAnalysis::of(std::slice::from_ref(&study));
    assert_eq!((rest.notices.len(), rest.groups[0].views), (1, 1));
    assert!(rest.notices[0].starts_with("left out: "), "{:?}", rest.notices);
}

fn inspector(folder: &Path, line: &str) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_inspector"));
    command.current_dir(folder).args(line.split(' ')).output().unwrap()
}

#[test]
fn info_plot_and_report_take_the_folder() {
    let folder = tempfile::tempdir().unwrap();
    study(folder.path());
    let info = inspector(folder.path(), "info study");
    let text = String::from_utf8(info.stdout).unwrap();
    assert!(info.status.success() && text.contains("2 jobs finished, 1 failed"), "{text}");
    assert!(text.contains("box-c-0: it was killed") && text.contains("2 views of 1 scene"), "{text}");
    assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
    for line in ["plot study --out out --figure study-speedup", "report study --out out"] {
        let done = inspector(folder.path(), line);
        assert!(done.status.success(), "{line}: {}", String::from_utf8_lossy(&done.stderr));
    }
    let tables = fs::read_to_string(folder.path().join("out/tables.md")).unwrap();
    assert!(tables.contains("Study: trace / net speedup, shadow rays"), "{tables}");
    assert!(tables.contains("(2 views of 1 scene)"), "{tables}");
    assert!(folder.path().join("out/study-speedup.svg").exists());
    // Means over the study come first.
    let page = fs::read_to_string(folder.path().join("out/report.html")).unwrap();
    let numbers = page.find("<h2>Numbers</h2>").unwrap();
    for first in ["mean over 2 views of 1 scene: ", "Speedups over the scenes and views of a study"] {
        assert!(page.find(first).is_some_and(|at| at < numbers), "{first}");
    }
}
