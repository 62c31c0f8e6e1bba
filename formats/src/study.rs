//! The folder of a study: recordings made from one plan, each job of it on one machine.
//!
//! ```text
//! STUDY/study.toml                  the plan that it was made from
//! STUDY/jobs/JOB/job.json           how the job ended; written last
//! STUDY/jobs/JOB/recording.raydump  what was recorded, and beside it its replays
//! STUDY/jobs/JOB/log.txt            what its commands said
//! STUDY/summaries/                  what readers computed of recordings, by content hash; may be deleted
//! STUDY/slurm/                      what tasks of Slurm said, ARRAY_JOB.log; may be deleted
//! ```

use std::io;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::files::{read_plain, replace};
use crate::text::one_line;

/// The plan, in the study's folder.
pub const PLAN_NAME: &str = "study.toml";
/// Folder of the jobs.
pub const JOBS_NAME: &str = "jobs";
/// How a job ended, in the job's folder.
pub const JOB_NAME: &str = "job.json";
/// Folder of what readers computed.
pub const SUMMARIES_NAME: &str = "summaries";
/// Folder of what tasks of Slurm said.
pub const SLURM_NAME: &str = "slurm";
/// Version of [`JobRecord`].
pub const JOB_VERSION: u32 = 1;

/// Bytes of the longest `job.json` that is read.
const BYTES_MAX: u64 = 1 << 20;
/// Characters of the longest text in one.
const TEXT_MAX: usize = 4000;

/// How a job ended: what `job.json` says.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct JobRecord {
    /// [`JOB_VERSION`].
    pub rayscope_job: u32,
    /// SHA-256 of what the job is made from: program, commands, content of the scene; hexadecimal.
    pub content_hash: String,
    /// Scene as the plan names it.
    pub scene: String,
    /// Camera by name.
    pub camera: String,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Its commands, as they would be typed in the job's folder.
    pub commands: Vec<String>,
    /// Names of its recordings, folders in the job's; the first is what the others are replays of. Of a job that
    /// failed, those that were finished.
    pub recordings: Vec<String>,
    /// The machine's name in its network.
    pub host: String,
    /// Wall time, seconds.
    pub seconds: f64,
    /// Bytes of its recordings.
    pub bytes: u64,
    /// Why it failed, in a sentence; none if it is finished.
    pub failure: Option<String>,
}

/// Why a study cannot be read.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "each message says what it and its fields mean")]
pub enum StudyError {
    #[error("cannot read {}: {cause}", path.display())]
    Io { path: PathBuf, cause: io::Error },
    #[error("{} is no record of a job: {reason}; delete it, and `recorder study run` makes the job again", path.display())]
    Job { path: PathBuf, reason: String },
}

/// Whether nothing has this name, also since what should hold it is a plain file: some systems leave theirs anywhere.
fn is_absent(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory)
}

impl JobRecord {
    /// Reads the record in a job's folder; `None` if the job has not ended.
    ///
    /// # Errors
    /// If it cannot be read, is something else, of another version, or names recordings outside its folder.
    pub fn read(job: &Path) -> Result<Option<Self>, StudyError> {
        let path = job.join(JOB_NAME);
        let bytes = match read_plain(&path, BYTES_MAX) {
            Ok(bytes) => bytes,
            Err(cause) if is_absent(&cause) => return Ok(None),
            Err(cause) => return Err(StudyError::Io { path, cause }),
        };
        let problem = |reason: String| StudyError::Job { path: path.clone(), reason };
        let mut record: Self = serde_json::from_slice(&bytes).map_err(|error| problem(error.to_string()))?;
        if record.rayscope_job != JOB_VERSION {
            return Err(problem(format!(
                "version {}, this program reads {JOB_VERSION}",
                record.rayscope_job
            )));
        }
        let is_name = |name: &String| Path::new(name).file_name() == Some(name.as_ref());
        if let Some(name) = record.recordings.iter().find(|name| !is_name(name)) {
            return Err(problem(format!("'{}' is no name of a folder", one_line(name, 100))));
        }
        let texts = [&mut record.content_hash, &mut record.scene, &mut record.camera, &mut record.host];
        for text in texts.into_iter().chain(&mut record.commands).chain(&mut record.failure) {
            *text = one_line(text, TEXT_MAX);
        }
        Ok(Some(record))
    }

    /// Writes the record into a job's folder, whole or not at all.
    ///
    /// # Errors
    /// What the system says.
    pub fn write(&self, job: &Path) -> io::Result<()> {
        replace(&job.join(JOB_NAME), |file| Ok(serde_json::to_writer_pretty(file, self)?))
    }
}

/// A study's folder and what its jobs came to.
#[derive(Clone, Debug)]
pub struct Study {
    /// The folder.
    pub root: PathBuf,
    /// Jobs that ended, finished or failed, by name of their folder.
    pub jobs: Vec<Job>,
}

/// A job that ended.
#[derive(Clone, Debug)]
pub struct Job {
    /// Its folder.
    pub folder: PathBuf,
    /// How it ended.
    pub record: JobRecord,
}

impl Study {
    /// Whether a path is the folder of a study.
    pub fn is_at(path: &Path) -> bool {
        path.join(PLAN_NAME).is_file() && path.join(JOBS_NAME).is_dir()
    }

    /// Reads the records of all jobs; the recordings themselves are not looked at.
    ///
    /// # Errors
    /// If a folder or a record cannot be read.
    pub fn open(root: &Path) -> Result<Self, StudyError> {
        let folder = root.join(JOBS_NAME);
        let io_error = |cause| StudyError::Io { path: folder.clone(), cause };
        let mut folders = std::fs::read_dir(&folder)
            .map_err(io_error)?
            .map(|entry| entry.map(|entry| entry.path()))
            .collect::<io::Result<Vec<PathBuf>>>()
            .map_err(io_error)?;
        folders.sort();
        let mut jobs = Vec::new();
        for folder in folders {
            if let Some(record) = JobRecord::read(&folder)? {
                jobs.push(Job { folder, record });
            }
        }
        Ok(Self { root: root.to_owned(), jobs })
    }

    /// The recordings of finished jobs, those of a job together, its source first.
    pub fn recordings(&self) -> impl Iterator<Item = PathBuf> + '_ {
        let finished = self.jobs.iter().filter(|job| job.record.failure.is_none());
        finished.flat_map(|job| job.record.recordings.iter().map(|name| job.folder.join(name)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(failure: Option<&str>) -> JobRecord {
        JobRecord {
            rayscope_job: JOB_VERSION,
            content_hash: "00ff".into(),
            scene: "builtin:cornell".into(),
            camera: "front".into(),
            seed: 1,
            commands: vec!["recorder record builtin:cornell".into()],
            recordings: vec!["recording.raydump".into(), "bits.raydump".into()],
            host: "node1".into(),
            seconds: 2.5,
            bytes: 10,
            failure: failure.map(str::to_owned),
        }
    }

    #[test]
    fn a_study_is_read_job_by_job() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path();
        assert!(!Study::is_at(root));
        assert!(matches!(Study::open(root), Err(StudyError::Io { .. })));
        std::fs::write(root.join(PLAN_NAME), "").unwrap();
        for job in ["b-finished", "a-failed", "c-running"] {
            std::fs::create_dir_all(root.join(JOBS_NAME).join(job)).unwrap();
        }
        assert!(Study::is_at(root));
        record(None).write(&root.join("jobs/b-finished")).unwrap();
        record(Some("the disk is full\u{1b}")).write(&root.join("jobs/a-failed")).unwrap();
        std::fs::write(root.join("jobs/.DS_Store"), "").unwrap();
        let study = Study::open(root).unwrap();
        let ends: Vec<Option<&str>> = study.jobs.iter().map(|job| job.record.failure.as_deref()).collect();
        assert_eq!(ends, [Some("the disk is full\\u{1b}"), None]);
        assert_eq!(study.jobs[1].record, record(None));
        let names: Vec<PathBuf> = study.recordings().collect();
        let job = root.join("jobs/b-finished");
        assert_eq!(names, [job.join("recording.raydump"), job.join("bits.raydump")]);
    }

    #[test]
    fn records_that_lead_elsewhere_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        for (found, part) in [
            (JobRecord { rayscope_job: 9, ..record(None) }, "version 9, this program reads 1"),
            (JobRecord { recordings: vec!["../else.raydump".into()], ..record(None) }, "'../else.raydump'"),
            (JobRecord { recordings: vec!["/etc".into()], ..record(None) }, "'/etc'"),
            (JobRecord { recordings: vec!["..".into()], ..record(None) }, "'..'"),
        ] {
            found.write(folder.path()).unwrap();
            let message = JobRecord::read(folder.path()).unwrap_err().to_string();
            assert!(message.contains(part), "{message}");
        }
        std::fs::write(folder.path().join(JOB_NAME), "{}").unwrap();
        let message = JobRecord::read(folder.path()).unwrap_err().to_string();
        assert!(message.contains("missing field"), "{message}");
    }
}
