//! Makes the jobs of a study that are not finished, one after the other.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result, bail};
use formats::files::replace;
use formats::folder::{EXTENSION, partial_of};
use formats::study::{JOB_NAME, JOBS_NAME, JobRecord, PLAN_NAME};
use indicatif::{HumanBytes, ProgressBar, ProgressStyle};

use super::child;
use super::jobs::{Command, Job};
use super::plan::Plan;
use super::state::{LOCK_NAME, State, ended, folder, record};
use crate::bench::folder_bytes;
use crate::interrupt;
use crate::output::say;

/// What a job's commands said.
pub const LOG_NAME: &str = "log.txt";

/// Makes the folder of a study, if it is not there, and writes the plan into it.
///
/// # Errors
/// If it cannot be made, or holds another file of the plan's name.
pub fn prepare(out: &Path, plan: &Plan) -> Result<()> {
    let (jobs, copy) = (out.join(JOBS_NAME), out.join(PLAN_NAME));
    let before = fs::read_to_string(&copy).ok();
    let is_same = before.as_ref().is_some_and(|before| *before == plan.text);
    if !jobs.is_dir() && before.is_some() && !is_same {
        bail!(
            "{} is a file of something else, and {} no folder of a study; choose another folder with --out",
            copy.display(),
            out.display()
        );
    }
    // The plan comes first: in a recording, where it is refused, no folder is made.
    fs::create_dir_all(out).with_context(|| format!("cannot make the folder {}", out.display()))?;
    if !is_same {
        replace(&copy, |file| file.write_all(plan.text.as_bytes()))
            .with_context(|| format!("cannot write {}", copy.display()))?;
    }
    fs::create_dir_all(&jobs).with_context(|| format!("cannot make the folder {}", jobs.display()))?;
    Ok(())
}

/// Makes those of `jobs` that are not finished in the folder `out`, and says how each ended. What another process is
/// making is waited for at the end.
///
/// # Errors
/// If this program cannot be found to be started again; what a job fails by is in its state.
pub fn run(out: &Path, jobs: &[&Job]) -> Result<Vec<State>> {
    let program = std::env::current_exe().context("cannot find this program to start it again")?;
    let out = std::path::absolute(out)?;
    interrupt::say_at_end(Some(format!(
        "finished jobs stay in {}; the same command makes the rest",
        out.display()
    )));
    let bar = bar(jobs);
    let runner = Runner { program: &program, out: &out, bar: &bar, count: jobs.len() };
    let states: Vec<_> = jobs.iter().map(|job| runner.turn(job, Patience::None)).collect();
    // Two studies on one folder share its jobs out.
    let states = states.into_iter().zip(jobs).map(|(state, job)| {
        let state = state.or_else(|| runner.turn(job, Patience::UntilFree));
        state.unwrap_or(State::Running)
    });
    let states = states.collect();
    bar.finish_and_clear();
    interrupt::say_at_end(None);
    Ok(states)
}

/// One bar over all jobs, in seconds of their estimates; hidden where stderr is no terminal.
fn bar(jobs: &[&Job]) -> ProgressBar {
    let seconds: f64 = jobs.iter().map(|job| job.estimate.seconds).sum();
    let bar = ProgressBar::new(in_ms(seconds));
    match ProgressStyle::with_template("{msg:40} {wide_bar} {percent} %  {elapsed} so far, about {eta} left")
    {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}

fn in_ms(seconds: f64) -> u64 {
    (1e3 * seconds) as u64
}

/// Whether a job that another process is making is waited for.
#[derive(Clone, Copy, PartialEq)]
enum Patience {
    None,
    UntilFree,
}

struct Runner<'a> {
    program: &'a Path,
    out: &'a Path,
    bar: &'a ProgressBar,
    count: usize,
}

impl Runner<'_> {
    /// What becomes of a job; `None` if another process is making it.
    fn turn(&self, job: &Job, patience: Patience) -> Option<State> {
        let folder = folder(self.out, job);
        let start = Instant::now();
        let state = match self.locked(&folder, job, patience) {
            Ok(None) => return None,
            Ok(Some((_, Some(state)))) => {
                self.bar.inc(in_ms(job.estimate.seconds));
                return Some(state);
            }
            Ok(Some((lock, None))) => self.make(job, &folder, &lock),
            Err(error) => {
                self.bar.inc(in_ms(job.estimate.seconds));
                let seconds = start.elapsed().as_secs_f64();
                State::Failed(record(job, Vec::new(), 0, seconds, Some(format!("{error:#}"))))
            }
        };
        self.tell(job, &state);
        Some(state)
    }

    /// The job's lock, and if it is finished, its state; `None` if another process holds it.
    fn locked(&self, folder: &Path, job: &Job, patience: Patience) -> Result<Option<(File, Option<State>)>> {
        if let Some(problem) = &job.problem {
            bail!("{problem}");
        }
        fs::create_dir_all(folder).with_context(|| format!("cannot make the folder {}", folder.display()))?;
        let path = folder.join(LOCK_NAME);
        let lock = OpenOptions::new().create(true).truncate(false).read(true).write(true).open(&path);
        let lock = lock.with_context(|| format!("cannot write {}", path.display()))?;
        match lock.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) if patience == Patience::None => return Ok(None),
            Err(TryLockError::WouldBlock) => {
                self.bar.set_message(format!("waiting for another process: {}", job.name));
                lock.lock().with_context(|| format!("cannot wait for {}", path.display()))?;
            }
            Err(TryLockError::Error(error)) => {
                return Err(error).with_context(|| format!("cannot lock {}", path.display()));
            }
        }
        let finished = ended(folder, job)?.filter(|state| matches!(state, State::Finished(_)));
        let is_there = |state: &State| {
            let recordings = state.record().map(|record| &record.recordings);
            recordings.is_some_and(|names| names.iter().all(|name| folder.join(name).is_dir()))
        };
        Ok(Some((lock, finished.filter(is_there))))
    }

    /// Runs a job's commands and writes down how it ended.
    fn make(&self, job: &Job, folder: &Path, lock: &File) -> State {
        let start = Instant::now();
        let (recordings, failure) = self.commands(job, folder, lock);
        let bytes = recordings.iter().map(|name| folder_bytes(&folder.join(name))).sum::<Result<u64>>();
        let (bytes, failure) = match bytes {
            Ok(bytes) => (bytes, failure),
            Err(error) => (0, failure.or(Some(format!("its recordings cannot be listed: {error:#}")))),
        };
        let mut record = record(job, recordings, bytes, start.elapsed().as_secs_f64(), failure);
        if let Err(error) = record.write(folder) {
            record.failure.get_or_insert(format!("cannot write {JOB_NAME}: {error}"));
        }
        if record.failure.is_some() { State::Failed(record) } else { State::Finished(record) }
    }

    /// Runs a job's commands one after the other; gives the names of the recordings, and why the next one failed, if
    /// it did.
    fn commands(&self, job: &Job, folder: &Path, lock: &File) -> (Vec<String>, Option<String>) {
        let mut recordings = Vec::new();
        let mut log = match begin(job, folder) {
            Ok(log) => log,
            Err(error) => return (recordings, Some(format!("{error:#}"))),
        };
        for command in &job.commands {
            self.bar.set_message(format!("{}/{} {} {}", job.number, self.count, job.name, command.recording));
            // The bar shows what is being made; it stands still until that is done.
            self.bar.tick();
            let ended = writeln!(log, "$ {}", command.typed())
                .map_err(|error| format!("cannot write {LOG_NAME}: {error}"))
                .and_then(|()| child::run(self.program, &command.words, folder, lock, &mut log));
            self.bar.inc(in_ms(command.share * job.estimate.seconds));
            if let Err(sentence) = ended {
                let left = remove_partial(folder, command).err().map(|error| format!("; and {error:#}"));
                let left = left.unwrap_or_default();
                return (recordings, Some(format!("{}: {sentence}{left}", command.recording)));
            }
            recordings.push(command.recording.clone());
        }
        (recordings, None)
    }

    /// A line about a job that has just ended.
    fn tell(&self, job: &Job, state: &State) {
        let Some(record) = state.record() else { return };
        let (word, name, seconds, bytes) =
            (state.word(), &job.name, record.seconds, HumanBytes(record.bytes));
        let why = record.failure.as_ref().map(|failure| format!("  {failure}")).unwrap_or_default();
        let line = format!("{word:8} {}/{} {name}  {seconds:.1} s  {bytes}{why}", job.number, self.count);
        self.bar.suspend(|| say(line));
    }
}

/// Clears the job's folder of what was not finished and of replays that the job no longer has, whose recording is about
/// to be another one, and begins its log. A recording that is there stays until the new one is complete.
fn begin(job: &Job, folder: &Path) -> Result<File> {
    let before = JobRecord::read(folder)?.map(|record| record.recordings).unwrap_or_default();
    let is_left = |name: &&String| {
        Path::new(name).extension().is_some_and(|end| end == EXTENSION)
            && !job.commands.iter().any(|command| command.recording == **name)
    };
    before.iter().filter(is_left).map(|name| folder.join(name)).try_for_each(remove_folder)?;
    let record = folder.join(JOB_NAME);
    removed(&record, fs::remove_file(&record))?;
    job.commands.iter().try_for_each(|command| remove_partial(folder, command))?;
    let log = folder.join(LOG_NAME);
    File::create(&log).with_context(|| format!("cannot write {}", log.display()))
}

/// Removes what a command left unfinished.
fn remove_partial(folder: &Path, command: &Command) -> Result<()> {
    remove_folder(partial_of(&folder.join(&command.recording)))
}

fn remove_folder(folder: PathBuf) -> Result<()> {
    removed(&folder, fs::remove_dir_all(&folder))
}

/// How removing something went that need not be there.
fn removed(path: &Path, result: io::Result<()>) -> Result<()> {
    match result {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
        result => result.with_context(|| format!("cannot remove {}", path.display())),
    }
}
