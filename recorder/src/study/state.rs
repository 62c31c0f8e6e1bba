//! How far the jobs of a study's folder are.

use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};

use formats::study::{JOBS_NAME, JobRecord, StudyError};

use super::estimate::{Estimate, TIME_FACTOR};
use super::jobs::Job;

/// Held by whoever makes the job, in its folder; the system lets it go when that process and its child are dead.
pub(super) const LOCK_NAME: &str = "lock";

/// How far a job is.
#[derive(Clone, Debug)]
pub enum State {
    /// Its recordings are there.
    Finished(JobRecord),
    /// It ended without them; `recorder study run` makes it again.
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

/// By how much jobs took longer, and wrote more, than was estimated: least, median and most of those that are
/// finished.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Experience {
    /// Of time.
    pub seconds: [f64; 3],
    /// Of bytes; the median.
    pub bytes: f64,
}

impl Experience {
    /// What the finished ones among these jobs teach; without any, that nothing is known.
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
        match (seconds.first(), seconds.last()) {
            (Some(&least), Some(&most)) => {
                Self { seconds: [least, seconds[seconds.len() / 2], most], bytes: bytes[bytes.len() / 2] }
            }
            _ => Self { seconds: [1.0 / TIME_FACTOR, 1.0, TIME_FACTOR], bytes: 1.0 },
        }
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
