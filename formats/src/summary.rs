//! A dump in one object: what `recorder record --json` and `inspector info --json` print.

use std::path::Path;

use serde::Serialize;

use crate::key::LightSite;
use crate::manifest::{
    Adapter, ArrayRecord, CacheRecord, CalibrationRecord, Check, DecisionRecord, Features, Manifest, Options,
    Outcome, QueueRecord, Source, TimingRecord,
};
use crate::metrics::frame::Frame;
use crate::metrics::speedup::{interquartile_range, median};
use crate::ray::Kind;

/// What a dump holds, without its arrays' contents.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// Path of the dump, as it was given.
    pub dump: String,
    /// Version of the format.
    pub format_version: u32,
    /// Version of the program that recorded.
    pub program_version: String,
    /// Whether the recording ran to its end.
    pub complete: bool,
    /// Whether `recover` made this dump.
    pub recovered: bool,
    /// `gpu` or `cpu`.
    pub backend: &'static str,
    /// The machine.
    pub adapter: Adapter,
    /// The scene.
    pub scene: SceneLine,
    /// The picture.
    pub image: ImageLine,
    /// What the scene needed.
    pub features: Features,
    /// Where the rays come from.
    pub source: SourceLine,
    /// What was asked for.
    pub options: Options,
    /// What the times were taken with.
    pub time_source: String,
    /// Wall time of the recording in nanoseconds; `null` if it is not known.
    pub wall_ns: Option<u64>,
    /// What the self-check found.
    pub self_check: Vec<Check>,
    /// What else was said to the user.
    pub notices: Vec<String>,
    /// What sorting was worth: each method over all bounces.
    pub frame: Frame,
    /// The queues, in the order in which they were traced.
    pub queues: Vec<QueueRecord>,
    /// The timings.
    pub timings: Vec<TimingLine>,
    /// What the cache model says.
    pub caches: Vec<CacheRecord>,
    /// What orders were worth before the recording.
    pub calibration: Vec<CalibrationRecord>,
    /// Which order `auto` gave each queue.
    pub decisions: Vec<DecisionRecord>,
    /// The arrays.
    pub arrays: Vec<ArrayRecord>,
}

/// The scene in a [`Summary`].
#[derive(Clone, Debug, Serialize)]
pub struct SceneLine {
    /// Name of the file or built-in scene.
    pub name: String,
    /// Number of triangles.
    pub triangles: u64,
    /// Number of vertices.
    pub vertices: u64,
    /// Number of lights.
    pub lights: usize,
    /// Where each is, in unit space.
    pub light_sites: Vec<LightSite>,
    /// Hash of its content, hexadecimal.
    pub content_hash: String,
    /// Lowest corner of its bounding box, world units.
    pub bounds_min: [f32; 3],
    /// Highest corner.
    pub bounds_max: [f32; 3],
}

/// Where the rays come from, in a [`Summary`].
#[derive(Clone, Debug, Serialize)]
pub struct SourceLine {
    /// `traced`, `replayed` or `imported`.
    pub how: &'static str,
    /// Name of the recording or file; `null` if the rays were traced here.
    pub name: Option<String>,
    /// SHA-256 of its manifest, or of the file.
    pub sha256: Option<String>,
}

impl From<&Source> for SourceLine {
    fn from(source: &Source) -> Self {
        let (how, from) = match source {
            Source::Traced => ("traced", None),
            Source::Replayed { name, manifest_sha256 } => ("replayed", Some((name, manifest_sha256))),
            Source::Imported { name, sha256 } => ("imported", Some((name, sha256))),
        };
        Self {
            how,
            name: from.map(|(name, _)| name.clone()),
            sha256: from.map(|(_, sha256)| hexadecimal(sha256)),
        }
    }
}

/// The picture in a [`Summary`].
#[derive(Clone, Debug, Serialize)]
pub struct ImageLine {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Hash of its data, hexadecimal; `null` if there is no picture.
    pub sha256: Option<String>,
}

/// A timing in a [`Summary`].
#[derive(Clone, Debug, Serialize)]
pub struct TimingLine {
    /// Pass, from 0.
    pub pass: u32,
    /// Bounce, from 0.
    pub bounce: u32,
    /// Kind of the queue; `null` for stages that serve both.
    pub kind: Option<Kind>,
    /// Method.
    pub method: String,
    /// Stage.
    pub stage: &'static str,
    /// Median of the samples in nanoseconds; `null` without samples.
    pub median_ns: Option<f64>,
    /// Interquartile range in nanoseconds; `null` without samples.
    pub iqr_ns: Option<f64>,
    /// Number of samples.
    pub samples: usize,
}

impl Summary {
    /// Of the dump at `path`, whose manifest this is.
    pub fn new(path: &Path, manifest: &Manifest) -> Self {
        let header = &manifest.header;
        let end = manifest.end.as_ref();
        let image = end.and_then(|end| end.image);
        let outcome = end.map(|end| end.outcome);
        Self {
            dump: path.display().to_string(),
            format_version: manifest.version,
            program_version: header.program_version.clone(),
            complete: outcome == Some(Outcome::Complete),
            recovered: outcome == Some(Outcome::Recovered),
            backend: header.backend.name(),
            adapter: header.adapter.clone(),
            scene: SceneLine {
                name: header.scene.name.clone(),
                triangles: header.scene.triangles,
                vertices: header.scene.vertices,
                lights: header.lights.len(),
                light_sites: header.lights.clone(),
                content_hash: hexadecimal(&header.scene.content_hash),
                bounds_min: header.scene.bounds_min,
                bounds_max: header.scene.bounds_max,
            },
            image: ImageLine {
                width: image.map_or(header.options.width, |image| image.width),
                height: image.map_or(header.options.height, |image| image.height),
                sha256: image.map(|image| hexadecimal(&image.sha256)),
            },
            features: header.features.clone(),
            source: SourceLine::from(&header.source),
            options: header.options.clone(),
            time_source: header.time_source.clone(),
            wall_ns: end.map(|end| end.wall_ns).filter(|&wall_ns| wall_ns > 0),
            self_check: header.self_check.clone(),
            notices: header.notices.clone(),
            frame: Frame::of(manifest),
            queues: manifest.queues.clone(),
            timings: manifest.timings.iter().map(TimingLine::from).collect(),
            caches: manifest.caches.clone(),
            calibration: manifest.calibration.clone(),
            decisions: manifest.decisions.clone(),
            arrays: manifest.arrays.clone(),
        }
    }
}

impl From<&TimingRecord> for TimingLine {
    fn from(timing: &TimingRecord) -> Self {
        Self {
            pass: timing.pass,
            bounce: timing.bounce,
            kind: timing.kind,
            method: timing.method.clone(),
            stage: timing.stage.name(),
            median_ns: median(&timing.samples_ns),
            iqr_ns: interquartile_range(&timing.samples_ns),
            samples: timing.samples_ns.len(),
        }
    }
}

/// Bytes as lower-case hexadecimal digits.
pub fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
