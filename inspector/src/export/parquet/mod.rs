//! Recordings as one tidy dataset for the engines of others: DuckDB, Polars, Spark and their like.
//!
//! ```text
//! DIR/rays/scene=…/machine=…/bounce=…/kind=…/method=…/NNNNN-pass-PPP.parquet   rays in the order of a method
//! DIR/timings.parquet     every sample of every time
//! DIR/summaries.parquet   what `inspector info --metrics` says of each order
//! ```
//! - `table`: columns as data, rows by row groups; `rays`, `timings`, `summaries`: what the tables have
//! - `partition`: folders that say what is in them; `destination`: complete or not there
//!
//! Memory: the arrays of one queue, and for each thread those of a method and a row group.

mod destination;
mod partition;
mod rays;
mod summaries;
mod table;
mod timings;

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context, bail};
use formats::key::method::UNSORTED;
use formats::manifest::QueueRecord;
use formats::reader::Dump;
use formats::study::{JOBS_NAME, Study};
use rayon::prelude::*;
use serde::Serialize;

use super::rays::RayChoice;
use crate::analysis::{Analysis, AnalysisOptions, Depth, RecordingAnalysis, analyse};
use crate::model::{Order, Queue};
use crate::output::sentence;
use crate::shown;
use destination::{Destination, SUMMARIES, TIMINGS};
use rays::OrderedRays;
use summaries::Summaries;
use timings::Timings;

/// The recording that a row is of, by the values of its folder.
#[derive(Default)]
struct Recorded {
    scene: String,
    machine: String,
    recording: String,
}

/// What was written.
#[derive(Debug, Default, Serialize)]
pub(super) struct Written {
    /// The folder.
    pub(super) folder: PathBuf,
    /// Recordings in it.
    pub(super) recordings: usize,
    /// Files of rays.
    pub(super) ray_files: usize,
    /// Rows in them.
    pub(super) rays: u64,
    /// Bytes of them.
    pub(super) ray_bytes: u64,
    /// Samples of times.
    pub(super) samples: u64,
    /// Orders that are summarised.
    pub(super) summaries: u64,
    /// What is not in it, and why.
    pub(super) left_out: Vec<String>,
}

/// Writes a recording, or all of a study, into the folder `out`: all rays that the choice does not leave out.
///
/// # Errors
/// If nothing can be read or something cannot be written; then `out` is as it was. What cannot be read of a study is
/// left out.
pub(super) fn write(
    input: &Path,
    out: &Path,
    may_replace: bool,
    choice: &RayChoice,
) -> anyhow::Result<Written> {
    let options = AnalysisOptions {
        group_width: choice.group_width,
        depth: Depth::Arrays,
        ..AnalysisOptions::default()
    };
    let is_study = Study::is_at(input);
    let recordings =
        if is_study { Study::open(input)?.recordings().collect() } else { vec![input.to_owned()] };
    let destination = Destination::new(out, may_replace)?;
    let mut dataset = Dataset {
        timings: Timings::create(destination.file(TIMINGS))?,
        summaries: Summaries::create(destination.file(SUMMARIES))?,
        destination,
        choice,
        written: Written::default(),
    };
    for path in &recordings {
        match open(path, &options) {
            Ok((dump, Analysis { recordings, .. })) => {
                // A study has one of a name in each job.
                let folder = if is_study { path.strip_prefix(input.join(JOBS_NAME)).ok() } else { None };
                let folder = folder.or_else(|| dump.root().file_name().map(Path::new)).unwrap_or(dump.root());
                let name = shown::name(&folder.to_string_lossy());
                for analysis in &recordings {
                    dataset.add(&dump, analysis, name.clone())?;
                }
            }
            Err(error) if is_study => dataset.written.left_out.push(sentence(&error)),
            Err(error) => return Err(error),
        }
    }
    dataset.finish(input)
}

fn open(path: &Path, options: &AnalysisOptions) -> anyhow::Result<(Dump, Analysis)> {
    let dump = Dump::open(path)?;
    let analysis = analyse(std::slice::from_ref(&dump), options)?;
    Ok((dump, analysis))
}

/// A dataset in the making.
struct Dataset<'a> {
    destination: Destination,
    timings: Timings,
    summaries: Summaries,
    choice: &'a RayChoice,
    written: Written,
}

impl Dataset<'_> {
    fn add(&mut self, dump: &Dump, analysis: &RecordingAnalysis, recording: String) -> anyhow::Result<()> {
        let recorded = Arc::new(Recorded {
            scene: partition::cut(&analysis.scene),
            machine: partition::cut(&analysis.configuration),
            recording,
        });
        self.timings.add(&recorded, dump.manifest())?;
        self.summaries.add(&recorded, analysis)?;
        for queue in dump.manifest().queues.iter().filter(|queue| self.choice.includes(queue.id)) {
            self.add_queue(dump, queue, &recorded)?;
        }
        self.written.recordings += 1;
        Ok(())
    }

    /// The rays of a queue in each order: those of a pass that was not measured in canonical order alone.
    fn add_queue(&mut self, dump: &Dump, record: &QueueRecord, recorded: &Recorded) -> anyhow::Result<()> {
        let mut methods: Vec<&str> = record.methods.iter().map(String::as_str).collect();
        if methods.is_empty() {
            methods.push(UNSORTED);
        }
        methods.retain(|method| self.choice.includes_method(method));
        let left_out = |what: String| format!("{}, {}: {what}", recorded.recording, record.id);
        let queue = match Queue::open(dump, record.id) {
            Ok(queue) => Arc::new(queue),
            Err(reason) => {
                self.written.left_out.push(left_out(reason));
                return Ok(());
            }
        };
        let write = |method: &&str| -> anyhow::Result<Result<(u64, u64), String>> {
            let order = match Order::open(dump, queue.clone(), method) {
                Ok(order) => order,
                Err(reason) => return Ok(Err(left_out(format!("{method}: {reason}")))),
            };
            let folder =
                partition::folder(&recorded.scene, &recorded.machine, record.id, &partition::cut(method));
            let name = format!("{:05}-pass-{:03}.parquet", self.written.recordings, record.id.pass);
            let path = self.destination.rays_file(&folder, &name)?;
            let rows = OrderedRays {
                recording: &recorded.recording,
                order: &order,
                method: dump.manifest().methods.iter().find(|known| known.name == **method),
                group_width: self.choice.group_width.rays(),
            };
            let rows = rows.write(path.clone())?;
            let bytes = fs::metadata(&path).with_context(|| format!("cannot find {}", path.display()))?.len();
            Ok(Ok((rows, bytes)))
        };
        let files: Vec<_> = methods.par_iter().map(write).collect::<anyhow::Result<_>>()?;
        for file in files {
            match file {
                Ok((rows, bytes)) => {
                    self.written.ray_files += 1;
                    self.written.rays += rows;
                    self.written.ray_bytes += bytes;
                }
                Err(reason) => self.written.left_out.push(reason),
            }
        }
        Ok(())
    }

    fn finish(self, input: &Path) -> anyhow::Result<Written> {
        let Self { destination, timings, summaries, mut written, choice } = self;
        if written.recordings == 0 {
            let why = written.left_out.first().map_or("none is finished", String::as_str);
            bail!("{} has no recording that can be read: {why}", input.display());
        }
        if written.ray_files == 0 && choice.names_rays() {
            let why = written.left_out.first().map_or("it has no such rays", String::as_str);
            bail!("there is nothing to export of {}: {why}", input.display());
        }
        (written.samples, written.summaries) = (timings.finish()?, summaries.finish()?);
        written.folder = destination.complete()?;
        Ok(written)
    }
}
