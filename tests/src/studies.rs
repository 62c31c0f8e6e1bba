//! Studies of a moment: their plan, and what was made of it.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use crate::recordings::{arrays, assert_same, without_times};

/// Options with which a recording takes a moment, and a replay.
const TINY: &str = "
    [record]\nwidth = 16\nheight = 9\nbounces = 2\npasses = 1\nrepeats = 1\nbackend = \"cpu\"
    methods = [\"aila\", \"two-point\"]
    [replay.bits]\nkey-bits = [16, 32]\nmethods = \"aila\"\nrepeats = 1\nbackend = \"cpu\"\n";

/// Writes a plan that begins with `top` and takes a moment.
///
/// # Panics
/// If it cannot be written.
pub fn plan(folder: &Path, top: &str) {
    fs::write(folder.join("study.toml"), format!("{top}\n{TINY}")).unwrap();
}

/// The record of each job of the study `made`, as bytes: a job that is made again has another one, by its time.
///
/// # Panics
/// If a job has none.
pub fn records(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let jobs = folder.join("made/jobs");
    let record = |name: String| (name.clone(), fs::read(jobs.join(name).join("job.json")).unwrap());
    job_names(&jobs).map(record).collect()
}

/// Checks that the jobs of two studies have the same recordings, but for their times.
///
/// # Panics
/// If not, with the job that differs.
pub fn assert_same_jobs(folder: &Path, studies: [&str; 2], recordings: &[&str]) {
    let [left, right] = studies.map(|study| folder.join(study).join("jobs"));
    for name in job_names(&left) {
        let (left, right) = (left.join(&name), right.join(&name));
        for recording in recordings {
            assert_same(&arrays(&left.join(recording)), &arrays(&right.join(recording)), &name);
            assert_eq!(without_times(&left, recording), without_times(&right, recording), "{name}");
        }
    }
}

fn job_names(jobs: &Path) -> impl Iterator<Item = String> {
    fs::read_dir(jobs).unwrap().map(|job| job.unwrap().file_name().into_string().unwrap())
}
