//! Studies: planned, made, killed and made to the end, with scenes that are missing and disks that are full.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Child, Stdio};
use std::time::Instant;

use serde_json::Value;
use tempfile::tempdir;
use tests::full_disk::on_small_disk;
use tests::programs::{FAILED, Outcome, Program, USAGE, finish, until};
use tests::recordings::verify;
use tests::scene_files::{glb, triangle_bytes, triangle_json};
use tests::sources::root;
use tests::studies::{assert_same_jobs, plan, records};

fn study(folder: &Path, words: &str) -> Outcome {
    Program::Recorder.run(folder, &format!("study {words}"))
}

/// What `status` says about each job, by name.
fn status(folder: &Path) -> BTreeMap<String, Value> {
    let said = study(folder, "status study.toml --out made --json").succeeded().json();
    let jobs = said["jobs"].as_array().unwrap().iter();
    jobs.map(|job| (job["name"].as_str().unwrap().to_owned(), job.clone())).collect()
}

fn states(folder: &Path) -> Vec<(String, String)> {
    let state = |(name, job): (String, Value)| (name, job["state"].as_str().unwrap().to_owned());
    status(folder).into_iter().map(state).collect()
}

fn states_are(folder: &Path, expected: &[(&str, &str)]) {
    let expected: Vec<_> =
        expected.iter().map(|(name, state)| (name.to_string(), state.to_string())).collect();
    assert_eq!(states(folder), expected);
}

#[test]
fn a_plan_is_made_once_and_what_changes_is_made_again() {
    let folder = tempdir().unwrap();
    let path = folder.path();
    fs::write(path.join("triangle.glb"), glb(&triangle_json(), &triangle_bytes())).unwrap();
    plan(path, "scenes = ['builtin:cornell', { file = 'triangle.glb', cameras = 2 }]");
    let names = ["cornell-front-0", "triangle-auto-0", "triangle-auto-2-0"];
    let planned = study(path, "plan study.toml --json").succeeded().json();
    let found: Vec<&str> =
        planned["jobs"].as_array().unwrap().iter().map(|job| job["name"].as_str().unwrap()).collect();
    assert_eq!(found, names);
    assert!(!path.join("made").exists(), "a plan makes nothing");
    states_are(path, &names.map(|name| (name, "waiting")));

    let table = study(path, "plan study.toml").succeeded().stdout;
    for word in ["3 jobs: about ", "recording, bits", "at most"].iter().chain(&names) {
        assert!(table.contains(word), "{word}: {table}");
    }
    let said = study(path, "run study.toml --out made").succeeded();
    assert!(said.stdout.contains("3 finished of 3 jobs"), "{}", said.stdout);
    assert_eq!(said.stderr.matches("finished ").count(), 3, "a line for each job: {}", said.stderr);
    states_are(path, &names.map(|name| (name, "finished")));
    let job = path.join("made/jobs/triangle-auto-2-0");
    ["recording", "bits"].iter().for_each(|name| verify(&job, name));
    assert!(fs::read_to_string(job.join("log.txt")).unwrap().contains("$ recorder replay recording.raydump"));
    assert!(path.join("made/study.toml").exists());

    let first = records(path);
    let again = study(path, "run study.toml --out made").succeeded();
    assert_eq!((records(path), again.stderr.as_str()), (first.clone(), ""), "nothing is left to be made");

    // Another seed makes jobs of its own, another scene only those of that scene, another option all.
    plan(path, "seeds = [0, 1]\nscenes = ['builtin:cornell', { file = 'triangle.glb', cameras = 2 }]");
    study(path, "run study.toml --out made").succeeded();
    let second = records(path);
    assert_eq!(second.len(), 6);
    assert!(names.iter().all(|name| second[*name] == first[*name]));
    fs::write(
        path.join("triangle.rayscope.toml"),
        "[environment]\nzenith = [1.0, 1.0, 1.0]\nnadir = [0.5, 0.5, 0.5]",
    )
    .unwrap();
    study(path, "run study.toml --out made").succeeded();
    let third = records(path);
    for (name, record) in &third {
        assert_eq!(*record == second[name], name.starts_with("cornell"), "{name}");
    }
    let changed =
        fs::read_to_string(path.join("study.toml")).unwrap().replace("[replay.bits]", "[replay.few]");
    fs::write(path.join("study.toml"), changed).unwrap();
    assert!(states(path).iter().all(|(_, state)| state == "waiting"), "{:?}", states(path));
    // Replays of a recording that is made again go with it, whatever else lies there stays.
    let job = path.join("made/jobs/cornell-front-0");
    fs::write(job.join("notes.txt"), "mine").unwrap();
    study(path, "run study.toml --out made --job 1").succeeded();
    let is_there = |name: &str| job.join(name).exists();
    assert!(!is_there("bits.raydump") && is_there("few.raydump") && is_there("notes.txt"));
}

#[test]
fn a_job_alone_and_jobs_of_an_earlier_plan() {
    let folder = tempdir().unwrap();
    let path = folder.path();
    plan(path, "scenes = ['builtin:cornell']\nseeds = [3, 4]");
    study(path, "run study.toml --out made --job 2").succeeded();
    states_are(path, &[("cornell-front-3", "waiting"), ("cornell-front-4", "finished")]);
    study(path, "run study.toml --out made --job 3").failed_with(FAILED, &["--job 3", "1 to 2"]);
    let left = status(path);
    assert!(left["cornell-front-3"]["estimated_seconds"].as_f64().unwrap() > 0.0);

    plan(path, "scenes = ['builtin:cornell']\nseeds = [3]");
    let said = study(path, "run study.toml --out made").succeeded().stderr;
    assert!(said.contains("1 of the jobs in made are none of the plan's, such as cornell-front-4"), "{said}");
    fs::create_dir(path.join("mine")).unwrap();
    fs::write(path.join("mine/study.toml"), "my own").unwrap();
    study(path, "run study.toml --out mine").failed_with(FAILED, &["study.toml", "--out"]);
    assert_eq!(fs::read_to_string(path.join("mine/study.toml")).unwrap(), "my own");
}

#[test]
fn scenes_of_a_folder_take_the_place_of_the_plans() {
    let folder = tempdir().unwrap();
    let path = folder.path();
    fs::create_dir(path.join("rooms")).unwrap();
    for name in ["b.glb", "a.glb"] {
        fs::write(path.join("rooms").join(name), glb(&triangle_json(), &triangle_bytes())).unwrap();
    }
    fs::write(path.join("rooms/a.rayscope.toml"), "").unwrap();
    plan(path, "scenes = ['builtin:cornell']\ncameras = 'all'");
    let planned = study(path, "plan study.toml --scenes rooms --json").succeeded().json();
    let name = |job: &Value| job["name"].as_str().unwrap().to_owned();
    let names: Vec<String> = planned["jobs"].as_array().unwrap().iter().map(name).collect();
    assert_eq!(names, ["a-view-0", "b-view-0"]);
    study(path, "plan study.toml --scenes .").failed_with(USAGE, &["no file that ends in .glb or .gltf"]);
    study(path, "plan study.toml --scenes nowhere").failed_with(USAGE, &["cannot read nowhere"]);
}

#[test]
fn the_plans_of_the_documentation_are_plans() {
    let folder = tempdir().unwrap();
    // One small scene in place of theirs, which take their time.
    fs::write(folder.path().join("a.glb"), glb(&triangle_json(), &triangle_bytes())).unwrap();
    let plans = fs::read_dir(root().join("docs/studies")).unwrap().map(|entry| entry.unwrap().path());
    let plans: Vec<_> = plans.collect();
    assert!(plans.len() >= 2, "{plans:?}");
    for plan in plans {
        let command = ["study", "plan", plan.to_str().unwrap(), "--scenes", ".", "--json"];
        let mut command = Program::Recorder.command(command);
        let planned = finish(command.current_dir(folder.path())).succeeded().json();
        assert_eq!(planned["jobs"].as_array().unwrap().len(), 1, "{}", plan.display());
    }
}

#[test]
fn nothing_is_made_in_a_recording() {
    let folder = tempdir().unwrap();
    let path = folder.path();
    plan(path, "scenes = ['builtin:cornell']");
    study(path, "run study.toml --out made").succeeded();
    let recording = "made/jobs/cornell-front-0/recording.raydump";
    let outcome = study(path, &format!("run study.toml --out {recording}"));
    outcome.failed_with(FAILED, &["it lies in the recording", "choose a place outside"]);
    assert!(!path.join(recording).join("jobs").exists());
}

#[test]
fn what_is_wrong_with_a_plan_is_said_at_once_and_before_anything_runs() {
    let folder = tempdir().unwrap();
    let path = folder.path();
    for (text, words) in [
        (
            "scene = ['builtin:cornell']",
            &["scene: there is no such key", "did you mean 'scenes'?", "scenes: expected a list"][..],
        ),
        ("scenes = []", &["scenes: expected a list of files and built-in scenes"]),
        ("scenes = [3]", &["scenes: found 3, expected a name"]),
        ("scenes = ['']", &["scenes: found \"\", expected a name"]),
        ("scenes = [{ file = 'a.glb', camera = 3 }]", &["scenes: camera: there is no such key", "'cameras'"]),
        ("scenes = ['builtin:cornell', 'builtin:cornell']", &["'builtin:cornell' is listed twice"]),
        ("scenes = ['builtin:cornell']\ncameras = 'al'", &["cameras: found", "\"all\"", "1 to 16"]),
        ("scenes = ['builtin:cornell']\ncameras = 0", &["cameras: found 0"]),
        ("scenes = ['builtin:cornell']\nseeds = [-1]", &["seeds: found [-1]", "whole numbers from 0"]),
        ("scenes = ['builtin:cornell']\nseeds = [1, 1]", &["seeds: 1 is listed twice"]),
        ("scenes = ['builtin:cornell'", &["line 1"]),
        (
            "scenes = ['builtin:cornell']\n[record]\nwidht = 3\nhight = 3",
            &["[record] widht", "did you mean 'width'?", "[record] hight", "'height'"],
        ),
        ("scenes = ['builtin:cornell']\n[record]\nseed = 3", &["[record] seed", "`seeds` at the top"]),
        (
            "scenes = ['builtin:cornell']\n[record]\nrussian-roulette = 3",
            &["russian-roulette: found 3, expected true or false"],
        ),
        ("scenes = ['builtin:cornell']\n[record]\nwidth = true", &["width: found true, expected a number"]),
        (
            "scenes = ['builtin:cornell']\n[record]\nbackend = 'cpv'",
            &["[record]: invalid value 'cpv'", "'cpu'"],
        ),
        (
            "scenes = ['builtin:cornell']\n[record]\nwidth = '--force'",
            &["[record]: invalid value '--force' for '--width <WIDTH>': invalid digit found in string\n"],
        ),
        ("scenes = ['builtin:cornell']\n[record]\nbounces = 0", &["[record]: --bounces is 0"]),
        ("scenes = ['builtin:cornell']\n[replay.bits]\nkey-bits = [4]", &["[replay.bits]: --key-bits"]),
        ("scenes = ['builtin:cornell']\n[replay.recording]", &["[replay.recording]: expected a name"]),
        ("scenes = ['builtin:cornell']\n[replay]\nbits = 3", &["[replay.bits]: found 3, expected a table"]),
        (
            "scenes = ['gone.glb', { file = 'builtin:cornell', cameras = ['back'] }, 'builtin:nowhere']",
            &["gone.glb", "no camera 'back'", "\"nowhere\""],
        ),
    ] {
        fs::write(path.join("study.toml"), text).unwrap();
        let outcome = study(path, "plan study.toml");
        assert_eq!(outcome.code, Some(USAGE), "{text}: {}", outcome.stderr);
        for word in words {
            assert!(outcome.stderr.contains(word), "{text}: no {word:?} in {}", outcome.stderr);
        }
        assert!(outcome.stderr.starts_with("error: study.toml: "), "{text}: {}", outcome.stderr);
    }
    study(path, "plan gone.toml").failed_with(USAGE, &["cannot read the plan gone.toml"]);
    fs::write(path.join("study.toml"), "scenes = ['builtin:cornell']\n[record]\nwidht = 3").unwrap();
    study(path, "run study.toml --out made").failed_with(USAGE, &["did you mean 'width'?"]);
    assert!(!path.join("made").exists());
}

#[test]
fn a_job_that_fails_is_a_sentence_and_the_rest_goes_on() {
    let folder = tempdir().unwrap();
    let path = folder.path();
    fs::write(path.join("torn.glb"), &glb(&triangle_json(), &triangle_bytes())[..100]).unwrap();
    let torn = "scenes = ['gone.glb', 'torn.glb', { file = 'builtin:cornell', cameras = ['back', 'front'] }]";
    plan(path, torn);
    let said = study(path, "run study.toml --out made");
    assert_eq!(said.code, Some(FAILED));
    assert!(said.stderr.ends_with("\nerror: 3 of 4 jobs failed\n"), "{}", said.stderr);
    assert!(said.stdout.contains("1 finished, 3 failed of 4 jobs"), "{}", said.stdout);
    let jobs = status(path);
    for (name, words) in [
        ("gone-unknown-0", "cannot read"),
        ("torn-unknown-0", "torn.glb"),
        ("cornell-back-0", "has no camera 'back'; it has front"),
    ] {
        let failure = jobs[name]["failure"].as_str().unwrap();
        assert!(failure.contains(words), "{name}: {failure}");
        assert!(!path.join("made/jobs").join(name).exists(), "a folder of nothing: {name}");
        assert!(said.stdout.contains(failure) && said.stderr.contains(failure), "{failure}");
    }
    assert_eq!(jobs["cornell-front-0"]["state"], "finished");
    // What is finished stays so while its scene is missing, and is no stray of another plan.
    plan(path, "scenes = ['triangle.glb']");
    fs::write(path.join("triangle.glb"), glb(&triangle_json(), &triangle_bytes())).unwrap();
    study(path, "run study.toml --out other").succeeded();
    fs::rename(path.join("triangle.glb"), path.join("aside.glb")).unwrap();
    for command in ["status", "run"] {
        let said = study(path, &format!("{command} study.toml --out other"));
        let said = said.stdout + &said.stderr;
        assert!(said.contains("triangle.glb") && !said.contains("none of the plan's"), "{said}");
    }
    fs::rename(path.join("aside.glb"), path.join("triangle.glb")).unwrap();
    let again = study(path, "run study.toml --out other").succeeded();
    assert_eq!(again.stderr, "", "nothing is left to be made");
    // What failed is made again, without another word.
    plan(path, torn);
    fs::write(path.join("torn.glb"), glb(&triangle_json(), &triangle_bytes())).unwrap();
    let again = study(path, "run study.toml --out made");
    assert!(again.stderr.contains("2 of 4 jobs failed"), "{}", again.stderr);
    assert_eq!(status(path)["torn-view-0"]["state"], "finished");
    fs::write(path.join("made/jobs/cornell-front-0/job.json"), "{").unwrap();
    study(path, "run study.toml --out made --job 4")
        .failed_with(FAILED, &["is no record of a job", "delete it"]);
}

#[test]
fn a_full_disk_is_a_sentence_and_what_fits_is_made() {
    let folder = tempdir().unwrap();
    plan(folder.path(), "scenes = ['builtin:atrium?triangles=100000', 'builtin:cornell']");
    let line = "study run study.toml --out small/made";
    let Some(outcome) = on_small_disk(folder.path(), "2m", line) else { return };
    outcome.failed_with(FAILED, &["1 of 2 jobs failed", "no space is left"]);
    let kept = folder.path().join("kept/made/jobs");
    verify(&kept.join("cornell-front-0"), "recording");
    let left: Vec<_> = fs::read_dir(kept.join("atrium_triangles_100000-court-0")).unwrap().collect();
    assert_eq!(left.len(), 3, "job.json, lock and log.txt, nothing unfinished: {left:?}");
}

fn start(folder: &Path, out: &str) -> Child {
    let mut command = Program::Recorder.command(["study", "run", "study.toml", "--out", out]);
    command.current_dir(folder).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap()
}

#[test]
fn killed_three_times_it_comes_to_the_same() {
    let folder = tempdir().unwrap();
    let path = folder.path();
    plan(path, "scenes = ['builtin:cornell', 'builtin:atrium?triangles=4000']\nseeds = [0, 1]");
    study(path, "run study.toml --out whole").succeeded();
    let begun = Instant::now();
    study(path, "run study.toml --out made").succeeded();
    let whole = begun.elapsed();
    fs::remove_dir_all(path.join("made")).unwrap();
    // A fixed sequence of fractions, so that a failure can be run again.
    let mut random = fastrand::Rng::with_seed(4);
    let is_finished = |(_, state): &(String, String)| state == "finished";
    // Of four jobs, whatever else the machine does: each time one more is finished, and the next one under way.
    for finished in 0..3 {
        let mut child = start(path, "made");
        while finished > 0 && states(path).iter().filter(|state| is_finished(state)).count() < finished {
            assert!(child.try_wait().unwrap().is_none(), "it ended by itself");
        }
        std::thread::sleep(whole.mul_f64(0.1 * random.f64()));
        child.kill().unwrap();
        child.wait().unwrap();
        let states = states(path);
        println!("{states:?}");
        assert!(states.iter().any(|(_, state)| state != "finished"), "the kill came too late: {states:?}");
        assert!(states.iter().all(|(_, state)| state != "failed"), "{states:?}");
    }
    study(path, "run study.toml --out made").succeeded();
    assert_same_jobs(path, ["whole", "made"], &["recording.raydump", "bits.raydump"]);
    for (name, state) in states(path) {
        assert_eq!(state, "finished");
        let left = fs::read_dir(path.join("made/jobs").join(&name)).unwrap().count();
        assert_eq!(left, 5, "two recordings, job.json, lock and log.txt, nothing unfinished");
    }
}

#[test]
fn two_runs_on_one_folder_make_each_job_once() {
    let folder = tempdir().unwrap();
    let path = folder.path();
    plan(path, "scenes = ['builtin:cornell']\nseeds = [0, 1, 2, 3]");
    let said: String = [start(path, "made"), start(path, "made")]
        .map(|child| {
            let output = child.wait_with_output().unwrap();
            assert!(output.status.success());
            String::from_utf8(output.stderr).unwrap()
        })
        .concat();
    assert_eq!(said.matches("finished ").count(), 4, "{said}");
    assert!(states(path).iter().all(|(_, state)| state == "finished"));
}

/// The recordings of a plan that take longer than any test.
#[cfg(target_os = "linux")]
fn long_plan(folder: &Path) {
    let text = "scenes = ['builtin:cornell']\n[record]\nwidth = 400\nheight = 400\npasses = 999\nbackend = \"cpu\"\n";
    fs::write(folder.join("study.toml"), text).unwrap();
}

/// The process that a study has started, once it records.
#[cfg(target_os = "linux")]
fn recorder_of(study: &Child, partial: &Path) -> String {
    until("something is recorded", || partial.exists());
    let parent = format!("PPid:\t{}\n", study.id());
    let processes =
        fs::read_dir("/proc").unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let is_child = |id: &String| {
        fs::read_to_string(format!("/proc/{id}/status")).is_ok_and(|text| text.contains(&parent))
    };
    let children: Vec<String> = processes.filter(is_child).collect();
    assert_eq!(children.len(), 1, "{children:?}");
    children[0].clone()
}

#[cfg(target_os = "linux")]
#[test]
fn a_recorder_that_is_killed_fails_its_job_and_a_study_that_is_ended_takes_its_recorder_along() {
    use std::os::unix::process::ExitStatusExt;
    use std::process::Command;
    let folder = tempdir().unwrap();
    let path = folder.path();
    long_plan(path);
    let job = path.join("made/jobs/cornell-front-0");
    let send = |signal: &str, id: &str| {
        assert!(Command::new("kill").args(["-s", signal, id]).status().unwrap().success())
    };

    let child = start(path, "made");
    send("KILL", &recorder_of(&child, &job.join("recording.raydump.partial/scene")));
    let said = child.wait_with_output().unwrap();
    assert_eq!(said.status.code(), Some(FAILED));
    let failure = status(path)["cornell-front-0"]["failure"].as_str().unwrap().to_owned();
    assert!(failure.starts_with("recording.raydump: it was ended by signal 9"), "{failure}");
    assert!(!job.join("recording.raydump.partial").exists());

    let mut child = start(path, "made");
    let recorder = recorder_of(&child, &job.join("recording.raydump.partial/scene"));
    states_are(path, &[("cornell-front-0", "running")]);
    send("TERM", &child.id().to_string());
    assert_eq!(child.wait().unwrap().signal(), Some(15));
    let said = std::io::read_to_string(child.stderr.take().unwrap()).unwrap();
    assert!(said.contains("interrupted; finished jobs stay in") && said.lines().count() == 1, "{said}");
    until("the recorder has ended", || !Path::new("/proc").join(&recorder).exists());
    states_are(path, &[("cornell-front-0", "waiting")]);
}
