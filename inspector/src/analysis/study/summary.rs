//! What means over a study take of each recording.

use std::path::{Path, PathBuf};

use formats::manifest;
use formats::metrics::frame::FrameTimes;
use formats::ray::Kind;
use formats::reader::{Dump, ReadError};
use formats::study::Study;
use formats::summary::hexadecimal;
use serde::{Deserialize, Serialize};

use super::kept::{kept, place};
use crate::analysis::labels::configuration;
use crate::analysis::{AnalysisError, AnalysisOptions, Depth, analyse};
use crate::shown;

/// A recording without its arrays and queues.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RecordingSummary {
    /// Name of the scene.
    pub scene: String,
    /// SHA-256 of what is in it, hexadecimal.
    pub content_hash: String,
    /// Camera.
    pub camera: String,
    /// Seed.
    pub seed: u64,
    /// Backend, adapter, kernel and threads.
    pub configuration: String,
    /// Each method over all bounces, round by round.
    pub times: Vec<FrameTimes>,
    /// Methods that are variants of others, as in a sweep.
    pub variants: Vec<String>,
    /// Mean capsule areas over those of unsorted rays, by kind and method, where they are known.
    pub areas: Vec<(Kind, String, f64)>,
}

/// Why there is no summary of a recording.
#[derive(Debug, thiserror::Error)]
pub enum SummaryError {
    /// It cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// It cannot be analysed.
    #[error(transparent)]
    Analysis(#[from] AnalysisError),
    /// Its manifest cannot be read.
    #[error("cannot read {}: {cause}", path.display())]
    Io {
        /// The manifest.
        path: PathBuf,
        /// What the system said.
        cause: std::io::Error,
    },
}

/// The summary of a recording of a study, kept. Second, why it could not be kept.
///
/// # Errors
/// If the recording cannot be read.
pub fn summary(study: &Study, recording: &Path) -> Result<(RecordingSummary, Option<String>), SummaryError> {
    let path = place(study, recording, "")
        .map_err(|cause| SummaryError::Io { path: recording.join(manifest::FILE_NAME), cause })?;
    kept(&path, || RecordingSummary::of(recording))
}

impl RecordingSummary {
    /// Of a recording, its arrays included.
    ///
    /// # Errors
    /// If it cannot be read or is not finished.
    pub fn of(recording: &Path) -> Result<Self, SummaryError> {
        let dump = Dump::open(recording)?;
        let options = AnalysisOptions { depth: Depth::Arrays, ..AnalysisOptions::default() };
        let analysis = analyse(std::slice::from_ref(&dump), &options)?;
        let header = shown::header(&dump.manifest().header);
        let frames = analysis.recordings.iter().flat_map(|recording| &recording.frames);
        let area = |frame: &crate::analysis::FrameAnalysis| {
            Some((frame.rays.kind(), frame.method.clone(), *frame.capsule_area_ratio.known()?))
        };
        let methods = &dump.manifest().methods;
        Ok(Self {
            camera: header.options.camera.clone(),
            seed: header.options.seed,
            configuration: configuration(&header),
            times: FrameTimes::all(dump.manifest()),
            variants: methods
                .iter()
                .filter(|record| record.name != record.base)
                .map(|record| record.name.clone())
                .collect(),
            areas: frames.filter_map(area).collect(),
            content_hash: hexadecimal(&header.scene.content_hash),
            scene: header.scene.name,
        })
    }
}
