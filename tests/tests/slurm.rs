//! Studies on a cluster: the jobs as an array of a real Slurm, with a scene that comes late and a node that vanishes.

#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::fs;
use std::path::Path;
use std::process::Stdio;

use serde_json::json;
use tempfile::tempdir;
use tests::programs::{FAILED, Outcome, Program, USAGE, finish, until};
use tests::scene_files::{glb, triangle_bytes, triangle_json};
use tests::slurm::Cluster;
use tests::studies::{assert_same_jobs, plan, records};

/// `recorder study` where jobs are submitted to the cluster.
fn study(cluster: &Cluster, folder: &Path, words: &str) -> Outcome {
    let mut command = Program::Recorder.command("study".split(' ').chain(words.split_whitespace()));
    finish(cluster.serve(&mut command).current_dir(folder))
}

/// The state of each job, in the order of the plan.
fn states(folder: &Path) -> Vec<String> {
    let said = Program::Recorder.run(folder, "study status study.toml --out made --json").succeeded().json();
    let jobs = said["jobs"].as_array().unwrap().iter();
    jobs.map(|job| job["state"].as_str().unwrap().to_owned()).collect()
}

/// Checks that the jobs in `made` are those that a run on this machine alone makes.
fn same_as_here(folder: &Path, recordings: &[&str]) {
    Program::Recorder.run(folder, "study run study.toml --out here").succeeded();
    assert_same_jobs(folder, ["here", "made"], recordings);
}

#[test]
fn an_array_makes_what_is_left_and_the_same_as_a_run_here() {
    let Some(cluster) = Cluster::start() else { return };
    let folder = tempdir().unwrap();
    let path = folder.path();
    let scenes = "[{ file = 'builtin:cornell', cameras = 3 }, { file = 'late.glb', cameras = ['view'] }]";
    plan(path, &format!("scenes = {scenes}"));
    let first = study(&cluster, path, "run study.toml --out made --slurm --wait");
    assert_eq!(first.code, Some(FAILED));
    assert!(first.stderr.ends_with("\nerror: 1 of 4 jobs failed\n"), "{}", first.stderr);
    assert!(first.stderr.contains("Slurm has 4 of 4 jobs as array 1; waiting"), "{}", first.stderr);
    assert!(first.stdout.contains("3 finished, 1 failed of 4 jobs"), "{}", first.stdout);
    let before = records(path);

    fs::write(path.join("late.glb"), glb(&triangle_json(), &triangle_bytes())).unwrap();
    let second = study(&cluster, path, "run study.toml --out made --slurm --json").succeeded().json();
    assert_eq!(second["jobs"], json!([4]));
    until("the late scene is recorded", || states(path) == ["finished"; 4]);
    let after = records(path);
    let again: Vec<&String> =
        after.iter().filter(|&(name, job)| before.get(name) != Some(job)).map(|(name, _)| name).collect();
    assert_eq!(again, ["late-view-0"]);
    let logs = fs::read_dir(path.join("made/slurm")).unwrap().count();
    assert_eq!(logs, 5, "what each task said");

    // What Slurm has made, this machine leaves alone, and makes the rest; then Slurm has nothing to do.
    fs::remove_dir_all(path.join("made/jobs/late-view-0")).unwrap();
    study(&cluster, path, "run study.toml --out made").succeeded();
    let here = records(path);
    assert!(after.iter().all(|(name, job)| (here[name] == *job) != (name == "late-view-0")));
    let last = study(&cluster, path, "run study.toml --out made --slurm").succeeded();
    assert!(last.stdout.starts_with("4 finished of 4 jobs"), "{}", last.stdout);
    assert_eq!(records(path), here);
    same_as_here(path, &["recording.raydump", "bits.raydump"]);
}

#[test]
fn the_task_of_a_node_that_vanishes_is_made_again() {
    let Some(cluster) = Cluster::start() else { return };
    let folder = tempdir().unwrap();
    let path = folder.path();
    let text = "scenes = ['builtin:cornell']\nseeds = [0, 1]\n
        [record]\nwidth = 64\nheight = 36\npasses = 60\nrepeats = 1\nbackend = \"cpu\"\nmethods = \"aila\"";
    fs::write(path.join("study.toml"), text).unwrap();
    let said = study(&cluster, path, "run study.toml --out made --slurm --constraint second").succeeded();
    assert!(said.stdout.contains("Slurm has 2 of 2 jobs as array 1"), "{}", said.stdout);
    let first = path.join("made/jobs/cornell-front-0");
    until("the first job is recorded", || first.join("recording.raydump.partial").exists());
    // A node to itself, and only one that has the feature.
    assert_eq!(cluster.run("squeue --noheader --states=running --array --format=%K,%N"), "1,node2\n");
    cluster.run("scontrol update nodename=node2 state=down reason=test");
    until("its processes are ended", || states(path)[0] != "running");
    assert_ne!(states(path)[0], "finished", "the node vanished too late");
    assert_eq!(cluster.run("squeue --noheader --states=running --array"), "");

    cluster.run("scontrol update nodename=node2 state=resume");
    // Slurm itself waits two minutes before it starts such a task again.
    cluster.run("scontrol update jobid=1_1 starttime=now");
    until("both jobs are recorded", || states(path) == ["finished"; 2]);
    assert!(cluster.run("scontrol show job 1_1").contains("Restarts=1 "));
    same_as_here(path, &["recording.raydump"]);
}

#[test]
fn what_slurm_does_not_take_is_a_sentence() {
    let Some(cluster) = Cluster::start() else { return };
    let folder = tempdir().unwrap();
    let path = folder.path();
    plan(path, "scenes = ['builtin:cornell']\nseeds = [0, 1, 2, 3, 4, 5, 6]");
    study(&cluster, path, "run study.toml --out made --slurm").failed_with(
        FAILED,
        &["Slurm does not take the jobs", "Invalid job array", "number 7, and MaxArraySize"],
    );
    plan(path, "scenes = ['builtin:cornell']");
    study(&cluster, path, "run study.toml --out made --slurm --wait --constraint nowhere")
        .failed_with(FAILED, &["Slurm does not take the jobs", "Invalid feature specification"]);
    let words = "study run study.toml --out made --slurm".split(' ');
    finish(Program::Recorder.command(words).env("PATH", path).current_dir(path))
        .failed_with(FAILED, &["there is no sbatch here", "without --slurm"]);
    study(&cluster, path, "run study.toml --out made --wait").failed_with(USAGE, &["--slurm"]);
    study(&cluster, path, "run study.toml --out made --slurm --job 1").failed_with(USAGE, &["--job"]);
    assert!(states(path) == ["waiting"]);

    // A task that ends without a word about its job, as when it is cancelled.
    let mut waiting = Program::Recorder.command("study run study.toml --out made --slurm --wait".split(' '));
    cluster.run("scontrol update partitionname=all state=down");
    let waiting = cluster.serve(&mut waiting).current_dir(path).stdout(Stdio::null()).stderr(Stdio::piped());
    let waiting = waiting.spawn().unwrap();
    until("it is submitted", || !cluster.run("squeue --noheader").is_empty());
    cluster.run("scancel --user=root");
    let said = waiting.wait_with_output().unwrap();
    assert_eq!(said.status.code(), Some(FAILED));
    let said = String::from_utf8(said.stderr).unwrap();
    assert!(said.ends_with("error: 1 of 1 job is not finished; see made/slurm\n"), "{said}");
}
