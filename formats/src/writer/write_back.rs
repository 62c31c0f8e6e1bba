//! A thread that brings files to the disk while others are being written.
//!
//! Without it the system keeps gigabytes in memory, and the sync at the end takes as long as
//! everything before it.

use std::fs::File;
use std::io;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{self, Receiver, SyncSender};

/// Files that may wait; whoever is that far ahead of the disk has to wait for it.
const QUEUE_FILES: usize = 64;

/// A path that could not be brought to the disk, and why.
pub(super) type Failure = (PathBuf, io::Error);

#[derive(Debug)]
enum Job {
    /// Bring a file to the disk.
    Sync(Arc<File>, PathBuf),
    /// Answer when all jobs before this one are done, with their first failure.
    Answer(SyncSender<Option<Failure>>),
}

/// The way to the thread, which ends when this is dropped.
#[derive(Debug)]
pub(super) struct WriteBack {
    jobs: SyncSender<Job>,
}

impl WriteBack {
    /// Starts the thread.
    pub(super) fn start() -> io::Result<Self> {
        let (jobs, receiver) = mpsc::sync_channel(QUEUE_FILES);
        std::thread::Builder::new().name("write-back".into()).spawn(move || work(&receiver))?;
        Ok(Self { jobs })
    }

    /// Starts bringing what was written so far to the disk, unless there is enough to do already.
    pub(super) fn hint(&self, file: &Arc<File>, path: &std::path::Path) {
        // A full queue means that the disk is busy anyway.
        let _ = self.jobs.try_send(Job::Sync(Arc::clone(file), path.to_owned()));
    }

    /// Brings a finished file to the disk, now or soon.
    pub(super) fn finish_file(&self, file: Arc<File>, path: PathBuf) {
        // The thread ends only after a panic, and then `wait` says so.
        let _ = self.jobs.send(Job::Sync(file, path));
    }

    /// Waits for all files given so far; the first failure is the result.
    pub(super) fn wait(&self) -> Result<(), Failure> {
        let (sender, answer) = mpsc::sync_channel(1);
        let gone = || (PathBuf::from("the recording"), io::Error::other("the write-back thread has ended"));
        self.jobs.send(Job::Answer(sender)).map_err(|_| gone())?;
        match answer.recv() {
            Ok(None) => Ok(()),
            Ok(Some(failure)) => Err(failure),
            Err(_) => Err(gone()),
        }
    }
}

fn work(jobs: &Receiver<Job>) {
    let mut first_failure = None;
    for job in jobs {
        match job {
            Job::Sync(file, path) => {
                if let Err(error) = file.sync_data() {
                    first_failure.get_or_insert((path, error));
                }
            }
            Job::Answer(sender) => {
                // Nobody waits any more only if the writer is gone.
                let _ = sender.send(first_failure.take());
            }
        }
    }
}
