//! Whole recordings by the numbers of [`formats::metrics`]: nothing is drawn or printed here.
//!
//! - [`options`]: group width, threads, how deep to look
//! - [`metric`]: a number, or why there is none
//! - [`recording`], [`queue`], [`order`]: the numbers of one recording, queue and order
//! - `arrays`: the arrays of a queue that its orders share; [`known`]: what need not be read again
//! - [`timing`]: times, speedups, bandwidths of an order's stages
//! - [`frame`]: a method over all bounces; [`versus`]: one order against another; [`ranking`]: all of them, the best first
//! - [`break_even`]: what a sort may cost
//! - [`coherence`]: capsules, direction spread and lane utilisation, streamed over arrays
//! - [`tables`]: fill of the length table, errors of estimated lengths
//! - [`summary`], [`correlations`]: over all recordings; [`study`]: over those of studies
//! - [`labels`]: what recordings are called beside each other; [`lacking`]: what some queues lack of what others have
//! - [`work`]: nodes and triangles of the recording's own kernel
//! - [`picture`]: the image and what each pixel cost; [`image_plane`]: which path starts where on it
//! - [`key_bits`]: what each bit of an order's keys is worth
//! - [`jumps`], [`neighbours`], [`estimates`], [`visits`], [`costliest`]: of the rays of one queue, the longest jumps,
//!   means over near ones, estimated against traced lengths, the boxes that they enter, the triangles that cost most
//! - [`comparison`], [`differences`]: two orders ray by ray; two recordings as a table of what differs
//! - [`headline`]: one view, unsorted and sorted
//!
//! Arrays are mapped one queue at a time. Beyond the maps, memory is about 12 bytes for each ray of the
//! largest queue and 16 for each of its groups, for any number of methods.

mod arrays;
pub mod break_even;
pub mod coherence;
pub mod comparison;
pub mod correlations;
pub mod costliest;
pub mod differences;
pub mod estimates;
pub mod frame;
pub mod headline;
pub mod image_plane;
pub mod jumps;
pub mod key_bits;
pub mod known;
pub mod labels;
pub mod lacking;
pub mod metric;
pub mod neighbours;
pub mod options;
pub mod order;
pub mod picture;
pub mod queue;
pub mod ranking;
pub mod recording;
pub mod study;
pub mod summary;
pub mod tables;
pub mod timing;
pub mod versus;
pub mod visits;
pub mod work;

use std::path::{Path, PathBuf};
use std::slice;

use formats::key::method::UNSORTED;
use formats::reader::{Dump, DumpState};
use formats::study::Study;
use serde::Serialize;

pub use correlations::CorrelationLine;
pub use frame::FrameAnalysis;
pub use known::KnownQueues;
pub use metric::Metric;
pub use options::{AnalysisOptions, Depth, GroupWidth};
pub use order::OrderAnalysis;
pub use queue::QueueAnalysis;
pub use recording::RecordingAnalysis;
pub use study::StudyAnalysis;
pub use summary::MethodSummary;
use summary::distinct;
pub use versus::Versus;

/// The numbers of recordings.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Analysis {
    /// Rays of a group.
    pub group_width: usize,
    /// The recordings, in the order in which they were given.
    pub recordings: Vec<RecordingAnalysis>,
    /// Per machine, rays and method: means over recordings.
    pub summaries: Vec<MethodSummary>,
    /// How capsule area and trace time go together.
    pub correlations: Vec<CorrelationLine>,
    /// Means over the studies that were given; the recordings above are then each scene's first view.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub study: Option<StudyAnalysis>,
}

impl Analysis {
    /// The same of some methods alone, their variants and unsorted rays.
    ///
    /// # Errors
    /// The first of them that was measured nowhere, and those that were.
    pub fn only(mut self, methods: &[String]) -> Result<Self, String> {
        let orders = self.recordings.iter().flat_map(|one| &one.queues).flat_map(|queue| &queue.orders);
        let of_studies = self.study.iter().flat_map(|study| &study.groups).flat_map(|group| &group.rows);
        let measured =
            orders.map(|order| order.base.as_str()).chain(of_studies.map(|row| row.method.as_str()));
        let measured = distinct(measured.filter(|name| *name != UNSORTED));
        if let Some(unknown) = methods.iter().find(|name| !measured.contains(&name.as_str())) {
            return Err(format!("there is no method {unknown} in them; there are {}", measured.join(", ")));
        }
        let is_kept = |name: &str| name == UNSORTED || methods.iter().any(|method| method == name);
        for recording in &mut self.recordings {
            recording.frames.retain(|frame| is_kept(&frame.base));
            recording.queues.iter_mut().for_each(|queue| queue.orders.retain(|order| is_kept(&order.base)));
        }
        for group in self.study.iter_mut().flat_map(|study| &mut study.groups) {
            group.rows.retain(|row| is_kept(&row.method));
        }
        Ok(self.summed_up())
    }

    /// What follows from all recordings together.
    fn summed_up(self) -> Self {
        let summaries = summary::summaries(&self.recordings);
        let correlations = correlations::correlations(&self.recordings);
        Self { summaries, correlations, ..self }
    }
}

/// Why recordings cannot be analysed.
#[derive(Debug, thiserror::Error)]
pub enum AnalysisError {
    /// A recording without an end.
    #[error(
        "{} is not finished: wait until its recorder has ended, or make a recording of what a killed one left with `inspector recover`",
        path.display()
    )]
    Unfinished {
        /// The recording.
        path: PathBuf,
    },
    /// Threads that cannot be had.
    #[error("cannot start {threads} threads: {cause}")]
    Threads {
        /// How many were asked for.
        threads: usize,
        /// What the system said.
        cause: rayon::ThreadPoolBuildError,
    },
}

/// Analyses recordings, together. The results do not depend on the number of threads.
///
/// # Errors
/// If a recording is not finished, or the threads cannot be had. Arrays that were not kept or cannot be
/// read are no error: what needs them says so.
pub fn analyse(dumps: &[Dump], options: &AnalysisOptions) -> Result<Analysis, AnalysisError> {
    analyse_by(dumps, options, |dump| QueueAnalysis::all(dump, options, &KnownQueues::new()))
}

/// Analyses a recording of whose queues something is known, which is not computed again.
///
/// # Errors
/// As [`analyse`].
pub fn analyse_known(
    dump: &Dump,
    options: &AnalysisOptions,
    known: &KnownQueues,
) -> Result<Analysis, AnalysisError> {
    analyse_by(slice::from_ref(dump), options, |dump| QueueAnalysis::all(dump, options, known))
}

/// Analyses studies: the means over all their recordings, and together the recordings that are given, arrays
/// included; their numbers are kept in the study that they are of.
///
/// # Errors
/// As [`analyse`].
pub fn analyse_studies(studies: &[Study], dumps: &[Dump]) -> Result<Analysis, AnalysisError> {
    let options = AnalysisOptions { depth: Depth::Arrays, ..AnalysisOptions::default() };
    let mut notices = Vec::new();
    let analysis = analyse_by(dumps, &options, |dump| {
        match studies.iter().find(|study| dump.root().starts_with(&study.root)) {
            None => QueueAnalysis::all(dump, &options, &KnownQueues::new()),
            Some(study) => {
                let (queues, notice) = study::queues(study, dump, &options);
                notices.extend(notice);
                queues
            }
        }
    })?;
    let mut study = (!studies.is_empty()).then(|| StudyAnalysis::of(studies));
    if let Some(study) = &mut study {
        study.notices = distinct(study.notices.drain(..).chain(notices));
    }
    Ok(Analysis { study, ..analysis })
}

fn analyse_by(
    dumps: &[Dump],
    options: &AnalysisOptions,
    queues: impl FnMut(&Dump) -> Vec<QueueAnalysis> + Send,
) -> Result<Analysis, AnalysisError> {
    check_finished(dumps)?;
    let Some(threads) = options.threads else { return Ok(of_queues(dumps, options, queues)) };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|cause| AnalysisError::Threads { threads, cause })?;
    Ok(pool.install(|| of_queues(dumps, options, queues)))
}

/// Opens a recording that can be analysed.
///
/// # Errors
/// If it cannot be read or is not finished.
pub(crate) fn open_finished(path: &Path) -> anyhow::Result<Dump> {
    let dump = Dump::open(path)?;
    check_finished(slice::from_ref(&dump))?;
    Ok(dump)
}

/// Whether recordings can be analysed.
///
/// # Errors
/// If one is not finished.
fn check_finished(dumps: &[Dump]) -> Result<(), AnalysisError> {
    match dumps.iter().find(|dump| dump.state() == DumpState::Partial) {
        Some(dump) => Err(AnalysisError::Unfinished { path: dump.root().to_owned() }),
        None => Ok(()),
    }
}

fn of_queues(
    dumps: &[Dump],
    options: &AnalysisOptions,
    mut queues: impl FnMut(&Dump) -> Vec<QueueAnalysis>,
) -> Analysis {
    let labels = labels::labels(dumps);
    let recording = |(dump, label)| RecordingAnalysis::of(dump, label, queues(dump));
    let recordings = dumps.iter().zip(labels).map(recording).collect();
    Analysis { group_width: options.group_width.rays(), recordings, ..Analysis::default() }.summed_up()
}
