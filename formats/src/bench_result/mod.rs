//! What `recorder bench --json` prints and `inspector plot` reads.
//!
//! - [`error`]: run time against error, four curves
//! - [`growth`]: how costs grow with sizes
//! - [`skip`]: what skipping saves, and what comes before the first ray

pub mod error;
pub mod growth;
pub mod skip;

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::files::read_plain;
use crate::metrics::speedup::{Instrument, Speedup};
use crate::ray::Kind;
use crate::text::one_line;
use error::ErrorRows;
use growth::GrowthRow;
use skip::{SkipRow, StartupRow};

/// Version of this object.
pub const BENCH_VERSION: u32 = 1;

/// Bytes of the largest file that is read as a result: thousands of times what benchmarks print.
const BYTES_MAX: u64 = 64 << 20;
/// Characters of the longest text in a result: a command line.
const TEXT_MAX: usize = 1000;

/// The result of one benchmark on one machine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BenchResult {
    /// [`BENCH_VERSION`]; the field that tells such a file from any other JSON.
    pub rayscope_bench: u32,
    /// Version of the program.
    pub program_version: String,
    /// The command that gave it.
    pub command: String,
    /// `gpu` or `cpu`.
    pub backend: String,
    /// Name of the adapter or processor.
    pub adapter: String,
    /// Driver with its version; empty for the cpu backend.
    pub driver: String,
    /// Threads of the cpu backend; 0 for the gpu backend.
    pub threads: u32,
    /// What the times were taken with.
    pub time_source: String,
    /// What `bench instrument` comes to over all queues, or the control of `bench render` and `bench capture` over all scenes, its
    /// fields among these; of no other benchmark.
    #[serde(flatten)]
    pub instrument: Option<Instrument>,
    /// What was measured.
    pub rows: Rows,
}

/// The rows of a benchmark, by what it measures.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "bench", content = "rows", rename_all = "lowercase")]
pub enum Rows {
    /// `bench sort`.
    Sort(Vec<SortRow>),
    /// `bench trace`.
    Trace(Vec<TraceRow>),
    /// `bench error`.
    Error(Box<ErrorRows>),
    /// `bench skip`.
    Skip(Vec<SkipRow>),
    /// `bench startup`.
    Startup(Vec<StartupRow>),
    /// `bench instrument`.
    Instrument(Vec<InstrumentRow>),
    /// `bench render`.
    Render(Vec<RenderRow>),
    /// `bench capture`.
    Capture(Vec<CaptureRow>),
    /// `bench growth`.
    Growth(Vec<GrowthRow>),
}

/// One queue traced in orders whose speedups are known, or bound.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct InstrumentRow {
    /// Name of the scene.
    pub scene: String,
    /// The queue.
    pub pass: u32,
    /// Its bounce.
    pub bounce: u32,
    /// Its kind.
    pub kind: Kind,
    /// Its rays.
    pub rays: u64,
    /// Trace speedup of canonical order, gathered like any other: 1, but for the instrument's error.
    pub control: Speedup,
    /// Trace speedup of a random order, gathered: what canonical order has over none.
    pub shuffled: Speedup,
}

/// Frames of a scene as a renderer makes them that keeps to one order.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RenderRow {
    /// Name of the scene.
    pub scene: String,
    /// The order: a method, `unsorted`, the control, which moves paths from canonical order to itself, or what hits
    /// are sorted by before they are shaded.
    pub method: String,
    /// Width of the picture in pixels.
    pub width: u32,
    /// Height of the picture in pixels.
    pub height: u32,
    /// Samples per pixel of a frame.
    pub passes: u32,
    /// Bounces of each.
    pub bounces: u32,
    /// The time of all stages, a sample per frame, nanoseconds.
    pub frame_ns: Vec<u64>,
    /// That of tracing.
    pub trace_ns: Vec<u64>,
    /// That of keys, sorting, moving paths and learning lengths.
    pub reorder_ns: Vec<u64>,
    /// Of frames over unsorted ones, end to end; of all but these.
    pub speedup: Option<Speedup>,
    /// Of shading alone, likewise.
    #[serde(default)]
    pub shade_speedup: Option<Speedup>,
    /// What neighbours have in common when they are shaded; not in results of before.
    #[serde(default)]
    pub coherence: Option<ShadeCoherence>,
}

/// What 32 neighbours shade together, means over all closest rays of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ShadeCoherence {
    /// Distinct materials, rays that hit nothing as one more.
    pub materials: f64,
    /// Distinct ways that shading takes: nothing hit, or a material with or without a texture, gloss and light.
    pub branches: f64,
}

impl RenderRow {
    /// What is left of each frame: generating and shading rays, and adding light.
    pub fn shade_ns(&self) -> impl Iterator<Item = u64> {
        let parts = self.frame_ns.iter().zip(&self.trace_ns).zip(&self.reorder_ns);
        parts.map(|((&frame, &trace), &reorder)| frame.saturating_sub(trace.saturating_add(reorder)))
    }
}

/// Recordings of a scene with nothing and with everything kept, and the same bytes written by themselves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CaptureRow {
    /// Name of the scene.
    pub scene: String,
    /// Width of the picture in pixels.
    pub width: u32,
    /// Height of the picture in pixels.
    pub height: u32,
    /// Bounces of each pass.
    pub bounces: u32,
    /// Methods measured, whose keys and permutations are kept.
    pub methods: Vec<String>,
    /// Rays of the pass that is kept.
    pub rays: u64,
    /// Bytes of the files of a recording with everything kept.
    pub bytes: u64,
    /// A recording with nothing kept, from the first ray to its name; a sample per round, nanoseconds.
    pub nothing_ns: Vec<u64>,
    /// The same with everything kept.
    pub everything_ns: Vec<u64>,
    /// As many bytes written to one file of the same folder and synced, nothing else running.
    pub alone_ns: Vec<u64>,
    /// Time with everything kept over that of the larger of the two others, by rounds.
    pub cost: Speedup,
    /// Time with nothing kept over that of a second turn with nothing kept: 1, but for the clock's error.
    pub control: Speedup,
}

/// Sorting n keys with their indices.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SortRow {
    /// Keys sorted.
    pub n: u64,
    /// Bits of a key, 8 to 64, all of them random.
    pub key_bits: u32,
    /// One sample per repeat, nanoseconds.
    pub samples_ns: Vec<u64>,
}

/// Tracing one queue of a scene in one order with one kernel.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TraceRow {
    /// Name of the scene.
    pub scene: String,
    /// Its triangles.
    pub triangles: u64,
    /// Trace kernel.
    pub kernel: String,
    /// Bounce of the rays.
    pub bounce: u32,
    /// Kind of the rays.
    pub kind: Kind,
    /// Their order: a method, or `unsorted`. Sorted rays are gathered before, untimed.
    pub order: String,
    /// Rays traced.
    pub rays: u64,
    /// One sample per repeat, nanoseconds.
    pub samples_ns: Vec<u64>,
    /// How busy lanes were, of kernels that trace several rays at once.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lanes: Option<LaneRow>,
}

/// How many of a group's lanes work, in (0, 1]: measured, and by the model.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LaneRow {
    /// Lanes of a group.
    pub width: u64,
    /// Work of all rays over what the steps of their groups had room for.
    pub measured: f64,
    /// What [`crate::metrics::lanes::LaneUse`] says of each ray's own work.
    pub model: f64,
}

/// Why a file is no benchmark result.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "each message says what it and its fields mean")]
pub enum BenchError {
    #[error("cannot read {}: {cause}", path.display())]
    Io { path: PathBuf, cause: std::io::Error },
    #[error("{} is not what `recorder bench --json` prints: {cause}", path.display())]
    Json { path: PathBuf, cause: serde_json::Error },
    #[error("{} is a benchmark result of version {found}, this program reads version {BENCH_VERSION}; use the program that made it", path.display())]
    Version { path: PathBuf, found: u32 },
}

impl BenchResult {
    /// Reads a file that `recorder bench --json` printed. Its texts are made fit to be shown: longer ones than
    /// a command line are cut, and what a terminal would obey is escaped.
    ///
    /// # Errors
    /// If it cannot be read, is something else, or of another version.
    pub fn read(path: &Path) -> Result<Self, BenchError> {
        let io_error = |cause| BenchError::Io { path: path.to_owned(), cause };
        let json_error = |cause| BenchError::Json { path: path.to_owned(), cause };
        let bytes = read_plain(path, BYTES_MAX).map_err(io_error)?;
        let mut value: serde_json::Value = serde_json::from_slice(&bytes).map_err(json_error)?;
        let version = value.get("rayscope_bench").and_then(serde_json::Value::as_u64);
        if let Some(found) = version.filter(|&version| version != u64::from(BENCH_VERSION)) {
            return Err(BenchError::Version { path: path.to_owned(), found: found as u32 });
        }
        shorten(&mut value);
        serde_json::from_value(value).map_err(json_error)
    }
}

/// Makes all texts in a value fit to be shown. The parser bounds how deep it is.
fn shorten(value: &mut serde_json::Value) {
    match value {
        serde_json::Value::String(text) => *text = one_line(text, TEXT_MAX),
        serde_json::Value::Array(items) => items.iter_mut().for_each(shorten),
        serde_json::Value::Object(fields) => fields.values_mut().for_each(shorten),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn a_result_comes_back_and_other_files_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("sort.json");
        let result = BenchResult {
            rayscope_bench: BENCH_VERSION,
            program_version: "0".into(),
            command: "recorder bench sort".into(),
            backend: "cpu".into(),
            adapter: "a processor".into(),
            driver: String::new(),
            threads: 2,
            time_source: "monotonic clock".into(),
            instrument: None,
            rows: Rows::Sort(vec![SortRow { n: 1024, key_bits: 32, samples_ns: vec![5, 6] }]),
        };
        fs::write(&path, serde_json::to_string(&result).unwrap()).unwrap();
        assert_eq!(BenchResult::read(&path).unwrap(), result);
        let skip = skip::SkipRow {
            scene: "box".into(),
            what: "textures".into(),
            of: "shade".into(),
            skipped: skip::Cost::default(),
            done: skip::Cost { samples_ns: vec![7], bytes: 8 },
            same: "picture".into(),
            is_same: true,
        };
        let image = error::ImageRow {
            scene: "box".into(),
            method: "aila".into(),
            width: 4,
            height: 3,
            passes: 2,
            wall_ns: 9,
            speedup: Some(Speedup { ratio: 1.5, interval: Some((1.25, 2.0)) }),
            relative_mse: 0.125,
            reference_passes: 64,
        };
        let errors = ErrorRows { image: vec![image], ..ErrorRows::default() };
        for rows in [Rows::Skip(vec![skip]), Rows::Error(Box::new(errors)), Rows::Startup(Vec::new())] {
            let result = BenchResult { rows, ..result.clone() };
            fs::write(&path, serde_json::to_string(&result).unwrap()).unwrap();
            assert_eq!(BenchResult::read(&path).unwrap(), result);
        }
        for (text, expected) in
            [("{}", "is not what"), ("{\"rayscope_bench\": 9}", "version 9"), ("[", "is not what")]
        {
            fs::write(&path, text).unwrap();
            let message = BenchResult::read(&path).unwrap_err().to_string();
            assert!(message.contains(expected), "{message}");
        }
        assert!(BenchResult::read(&folder.path().join("none")).is_err());
    }
}
