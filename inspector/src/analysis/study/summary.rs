//! What means over a study take of each recording, and where it is kept.

use std::path::{Path, PathBuf};

use formats::files::{read_plain, replace};
use formats::manifest;
use formats::metrics::frame::FrameTimes;
use formats::ray::Kind;
use formats::reader::{Dump, ReadError};
use formats::study::{SUMMARIES_NAME, Study};
use formats::summary::hexadecimal;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::analysis::labels::configuration;
use crate::analysis::summary::RayClass;
use crate::analysis::{AnalysisError, AnalysisOptions, Depth, analyse};
use crate::shown;

/// Changes with the numbers of a summary, or with what they are made of.
const VERSION: u32 = 1;
/// Bytes of the largest summary that is read, and of the largest manifest that is hashed.
const BYTES_MAX: u64 = 256 << 20;

/// A recording without its arrays and queues.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RecordingSummary {
    /// Name of the scene.
    pub scene: String,
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

/// The summary of a recording of a study: as it was kept, if that was made from the same recording by the same
/// program, else made anew and kept. Second, why it could not be kept.
///
/// # Errors
/// If the recording cannot be read.
pub fn summary(study: &Study, recording: &Path) -> Result<(RecordingSummary, Option<String>), SummaryError> {
    let path = study.root.join(SUMMARIES_NAME).join(format!("{}.json", key(recording)?));
    let kept = read_plain(&path, BYTES_MAX).ok().and_then(|bytes| serde_json::from_slice(&bytes).ok());
    if let Some(kept) = kept {
        return Ok((kept, None));
    }
    let summary = RecordingSummary::of(recording)?;
    Ok((summary.clone(), keep(&path, &summary).err().map(|error| error.to_string())))
}

fn keep(path: &Path, summary: &RecordingSummary) -> std::io::Result<()> {
    path.parent().map(std::fs::create_dir_all).transpose()?;
    replace(path, |file| Ok(serde_json::to_writer(file, summary)?))
}

/// A hash of the program, of the manifest, which holds a checksum of every array and of a replay's source, and of
/// whether that is there.
fn key(recording: &Path) -> Result<String, SummaryError> {
    let path = recording.join(manifest::FILE_NAME);
    let bytes = read_plain(&path, BYTES_MAX).map_err(|cause| SummaryError::Io { path, cause })?;
    let neighbours = recording.parent().and_then(|job| std::fs::read_dir(job).ok());
    let dumps = neighbours.into_iter().flatten().flatten();
    let mut names: Vec<_> = dumps.map(|entry| entry.file_name()).collect();
    names.sort();
    let mut hash = Sha256::new();
    hash.update(format!("{VERSION} {} {names:?}", env!("CARGO_PKG_VERSION")));
    hash.update(bytes);
    Ok(hexadecimal(&hash.finalize()))
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
        let kind = |rays: RayClass| match rays {
            RayClass::Secondary => Kind::Closest,
            RayClass::Shadow => Kind::Shadow,
        };
        let frames = analysis.recordings.iter().flat_map(|recording| &recording.frames);
        let area = |frame: &crate::analysis::FrameAnalysis| {
            Some((kind(frame.rays), frame.method.clone(), *frame.capsule_area_ratio.known()?))
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
            scene: header.scene.name,
        })
    }
}
