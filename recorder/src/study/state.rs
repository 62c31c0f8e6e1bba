//! How far the jobs of a study's folder are.

use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};

use formats::study::{JOB_VERSION, JOBS_NAME, JobRecord, StudyError};
use sysinfo::System;

use super::estimate::{Estimate, TIME_FACTOR};
use super::jobs::{Command, Job};

/// Held by whoever makes the job, in its folder; the system lets it go when that process and its child are dead.
pub(super) const LOCK_NAME: &str = "lock";

/// How far a job is.
#[derive(Clone, Debug)]
pub enum State {
    /// Its recordings are there.
    Finished(JobRecord),
    /// It ended without them, or its scene or camera is not there; `recorder study run` makes it again.
    Failed(JobRecord),
    /// A process is making it.
    Running,
    /// Nobody has made it, or it was made from something else.
    Waiting,
}

impl State {
    /// In a word.
    pub fn word(&self) -> &'static str {
        match self {
            Self::Finished(_) => "finished",
            Self::Failed(_) => "failed",
            Self::Running => "running",
            Self::Waiting => "waiting",
        }
    }

    /// How the job ended, if it has.
    pub fn record(&self) -> Option<&JobRecord> {
        match self {
            Self::Finished(record) | Self::Failed(record) => Some(record),
            Self::Running | Self::Waiting => None,
        }
    }
}

/// The folder of a job.
pub fn folder(out: &Path, job: &Job) -> PathBuf {
    out.join(JOBS_NAME).join(&job.name)
}

/// How far a job is in the study's folder `out`, which need not be there.
///
/// # Errors
/// If what its folder says cannot be read.
pub fn state(out: &Path, job: &Job) -> Result<State, StudyError> {
    if let Some(problem) = &job.problem {
        return Ok(State::Failed(record(job, Vec::new(), 0, 0.0, Some(problem.clone()))));
    }
    let folder = folder(out, job);
    if let Some(state) = ended(&folder, job)? {
        return Ok(state);
    }
    // A job whose lock cannot be opened has none.
    let lock = File::open(folder.join(LOCK_NAME));
    let is_held = lock.is_ok_and(|lock| matches!(lock.try_lock_shared(), Err(TryLockError::WouldBlock)));
    Ok(if is_held { State::Running } else { State::Waiting })
}

/// How a job ended, if it did, made from what it would be made from now.
pub(super) fn ended(folder: &Path, job: &Job) -> Result<Option<State>, StudyError> {
    let record = JobRecord::read(folder)?.filter(|record| record.content_hash == job.content_hash);
    Ok(record.map(|record| match record.failure {
        Some(_) => State::Failed(record),
        None => State::Finished(record),
    }))
}

/// How a job ended on this machine.
pub(super) fn record(
    job: &Job,
    recordings: Vec<String>,
    bytes: u64,
    seconds: f64,
    failure: Option<String>,
) -> JobRecord {
    JobRecord {
        rayscope_job: JOB_VERSION,
        content_hash: job.content_hash.clone(),
        scene: job.scene.clone(),
        camera: job.camera.clone(),
        seed: job.seed,
        commands: job.commands.iter().map(Command::typed).collect(),
        recordings,
        host: System::host_name().unwrap_or_default(),
        seconds,
        bytes,
        failure,
    }
}

/// Jobs of the folder that the plan does not have: of an earlier one.
///
/// # Errors
/// If the folder cannot be listed; none is no error.
pub fn strays(out: &Path, jobs: &[Job]) -> std::io::Result<Vec<String>> {
    let entries = match std::fs::read_dir(out.join(JOBS_NAME)) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
        entries => entries?,
    };
    let names = entries.map(|entry| entry.map(|entry| entry.file_name().to_string_lossy().into_owned()));
    let mut names = names.collect::<std::io::Result<Vec<String>>>()?;
    names.retain(|name| !jobs.iter().any(|job| job.name == *name));
    names.sort();
    Ok(names)
}

/// By how much jobs take longer, and write more, than was estimated, as far as finished ones tell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Experience {
    /// Of time: least, about and most. The bounds are those of the finished jobs, wider by [`TIME_FACTOR`] for none and
    /// by its n-th root for n − 1.
    pub seconds: [f64; 3],
    /// Of bytes.
    pub bytes: f64,
}

impl Experience {
    /// What the finished ones among these jobs teach.
    pub fn of<'a>(jobs: impl Iterator<Item = (&'a Job, &'a State)>) -> Self {
        let (mut seconds, mut bytes): (Vec<f64>, Vec<f64>) = jobs
            .filter_map(|(job, state)| match state {
                State::Finished(record) => Some((
                    record.seconds / job.estimate.seconds,
                    record.bytes as f64 / job.estimate.bytes.max(1.0),
                )),
                _ => None,
            })
            .unzip();
        seconds.sort_by(f64::total_cmp);
        bytes.sort_by(f64::total_cmp);
        let of = |values: &[f64], at: usize| values.get(at).copied().unwrap_or(1.0);
        let count = seconds.len();
        let widening = TIME_FACTOR.powf(1.0 / (1 + count) as f64);
        let (least, most) = (of(&seconds, 0) / widening, of(&seconds, count.saturating_sub(1)) * widening);
        Self { seconds: [least, of(&seconds, count / 2), most], bytes: of(&bytes, count / 2) }
    }

    /// About so many seconds.
    pub fn seconds(&self, estimate: Estimate) -> f64 {
        self.seconds[1] * estimate.seconds
    }

    /// About so many bytes.
    pub fn bytes(&self, estimate: Estimate) -> f64 {
        (self.bytes * estimate.bytes).min(estimate.bytes_max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn finished(seconds: f64) -> (Job, State) {
        let job = Job {
            number: 1,
            name: String::new(),
            scene: String::new(),
            camera: String::new(),
            seed: 0,
            commands: Vec::new(),
            content_hash: String::new(),
            estimate: Estimate { seconds: 10.0, bytes: 100.0, bytes_max: 200.0 },
            problem: None,
        };
        let record = record(&job, Vec::new(), 150, seconds, None);
        (job, State::Finished(record))
    }

    #[test]
    fn finished_jobs_say_what_the_others_take() {
        let waiting = (finished(1.0).0, State::Waiting);
        let of = |jobs: &[(Job, State)]| Experience::of(jobs.iter().map(|(job, state)| (job, state)));
        assert_eq!(of(std::slice::from_ref(&waiting)).seconds, [1.0 / TIME_FACTOR, 1.0, TIME_FACTOR]);
        let three = [finished(5.0), waiting, finished(40.0), finished(20.0)];
        let Experience { seconds: [least, about, most], bytes } = of(&three);
        let widening = TIME_FACTOR.sqrt().sqrt();
        assert_eq!((about, bytes), (2.0, 1.5));
        assert!(
            (least - 0.5 / widening).abs() < 1e-12 && (most - 4.0 * widening).abs() < 1e-12,
            "{least} {most}"
        );
        let more = Estimate { seconds: 3.0, bytes: 1000.0, bytes_max: 1200.0 };
        assert_eq!(
            (of(&three).seconds(more), of(&three).bytes(more)),
            (6.0, 1200.0),
            "never more than there can be"
        );
    }
}
