//! Recordings as one tidy dataset for the engines of others: DuckDB, Polars, Spark and their like.
//!
//! ```text
//! DIR/rays/scene=…/machine=…/bounce=…/kind=…/method=…/NNNNN-pass-PPP.parquet   rays in the order of a method
//! DIR/timings.parquet     every sample of every time
//! DIR/summaries.parquet   what `inspector info --metrics` says of each order
//! ```
//! - `table`: columns as data, rows by row groups; `cell`, `runs`, `encode`: cells as bytes; `file`: pages
//! - `rays`, `timings`, `summaries`: what the tables have; `found`: all that is known of a ray, side by side
//! - `partition`: folders that say what is in them; `destination`: complete or not there
//!
//! Memory: the arrays of a bounce twice, and for each thread those of a method and a row group.

mod cell;
mod destination;
mod encode;
mod file;
mod found;
mod partition;
mod queues;
mod rays;
mod runs;
mod summaries;
mod table;
mod timings;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::bail;
use formats::reader::Dump;
use formats::study::{JOBS_NAME, Study};
use serde::Serialize;

use super::rays::RayChoice;
use crate::analysis::labels::configuration;
use crate::analysis::{AnalysisOptions, Depth, analyse_known, open_finished};
use crate::output::sentence;
use crate::shown;
use destination::{Destination, SUMMARIES, TIMINGS};
use queues::RayFiles;
use summaries::SummaryRow;
use table::TableWriter;
use timings::TimingRow;

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
        timings: TableWriter::create(destination.file(TIMINGS), timings::columns())?,
        summaries: TableWriter::create(destination.file(SUMMARIES), summaries::columns())?,
        rays: RayFiles { destination, choice, written: Written::default() },
    };
    for path in &recordings {
        match open_finished(path) {
            Ok(dump) => {
                // A study has one of a name in each job.
                let folder = if is_study { path.strip_prefix(input.join(JOBS_NAME)).ok() } else { None };
                let folder = folder.or_else(|| dump.root().file_name().map(Path::new)).unwrap_or(dump.root());
                dataset.add(&dump, &options, shown::name(&folder.to_string_lossy()))?;
            }
            Err(error) if is_study => dataset.rays.written.left_out.push(sentence(&error)),
            Err(error) => return Err(error),
        }
    }
    dataset.finish(input)
}

/// A dataset in the making.
struct Dataset<'a> {
    timings: TableWriter<'static, TimingRow>,
    summaries: TableWriter<'static, SummaryRow>,
    rays: RayFiles<'a>,
}

impl Dataset<'_> {
    fn add(&mut self, dump: &Dump, options: &AnalysisOptions, recording: String) -> anyhow::Result<()> {
        let header = shown::header(&dump.manifest().header);
        let recorded = Arc::new(Recorded {
            scene: partition::cut(&header.scene.name),
            machine: partition::cut(&configuration(&header)),
            recording,
        });
        timings::add(&mut self.timings, &recorded, dump.manifest())?;
        let known = self.rays.add(dump, &recorded)?;
        let analysis = analyse_known(dump, options, &known)?;
        for analysis in &analysis.recordings {
            summaries::add(&mut self.summaries, &recorded, analysis)?;
        }
        self.rays.written.recordings += 1;
        Ok(())
    }

    fn finish(self, input: &Path) -> anyhow::Result<Written> {
        let Self { timings, summaries, rays: RayFiles { destination, choice, mut written } } = self;
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
