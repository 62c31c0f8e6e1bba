//! What a manifest says, record by record.
//!
//! The order of fields and variants is the order of the bytes: FORMAT.md documents both, and any
//! change here is a new [`FORMAT_VERSION`](super::FORMAT_VERSION).

use std::fmt;

use bincode::{Decode, Encode};
use serde::{Deserialize, Serialize, Serializer};

use super::{Place, QueueId};
use crate::key::LightSite;
use crate::npy::Dtype;
use crate::ray::Kind;

/// One record of a manifest.
#[derive(Clone, Debug, PartialEq, Encode, Decode)]
pub enum Record {
    /// What is recorded and how; the first record, and only there.
    Header(Box<Header>),
    /// A method; before the first array that it made.
    Method(MethodRecord),
    /// An array whose bytes are complete.
    Array(ArrayRecord),
    /// A queue whose arrays are complete.
    Queue(QueueRecord),
    /// The samples of one timing.
    Timing(TimingRecord),
    /// The last record of a whole dump, and only there.
    End(End),
    /// What the cache model says of one order.
    Cache(CacheRecord),
    /// Which times of a timing were disturbed.
    Disturbed(DisturbedRecord),
    /// How a method's rays are traced in its totals.
    Way(WayRecord),
    /// What orders were worth on one queue before the recording.
    Calibration(CalibrationRecord),
    /// Which order `auto` gave a queue.
    Decision(DecisionRecord),
}

/// What is recorded, on which machine and how.
#[derive(Clone, Debug, PartialEq, Encode, Decode)]
pub struct Header {
    /// Version of the program that recorded.
    pub program_version: String,
    /// What was asked for.
    pub options: Options,
    /// The scene, as far as keys, tables and pictures need it.
    pub scene: SceneSummary,
    /// The camera.
    pub camera: CameraPose,
    /// The lights by index, in unit space: what keys of shadow rays are made from.
    pub lights: Vec<LightSite>,
    /// Where the stages ran.
    pub backend: Backend,
    /// The adapter, or the processor for the cpu backend.
    pub adapter: Adapter,
    /// Limits of the adapter by name.
    pub limits: Vec<(String, u64)>,
    /// What the self-check of the adapter found, and of hits that came with imported rays
    /// ([`IMPORTED_HITS`](super::IMPORTED_HITS)).
    pub self_check: Vec<Check>,
    /// Whether what traces rays and makes keys rounds as IEEE 754 has it, by itself or guarded: if so, every key
    /// must equal the one that [`Encoder`](crate::key::Encoder) makes; if not, differences are counted.
    pub ieee_arithmetic: bool,
    /// What the scene needed.
    pub features: Features,
    /// What the times were taken with, such as `gpu timestamps` or `monotonic clock`.
    pub time_source: String,
    /// Whatever else was said to the user, such as extensions of a file that were not used.
    pub notices: Vec<String>,
    /// Where the rays come from.
    pub source: Source,
}

/// Where the rays of a recording come from.
#[derive(Clone, Debug, PartialEq, Eq, Encode, Decode, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Source {
    /// They were traced along paths from the camera.
    Traced,
    /// They are another recording's: `recorder replay`. That recording keeps the arrays that do not
    /// depend on the methods, and readers find it beside this one.
    Replayed {
        /// Name of its folder.
        name: String,
        /// SHA-256 of its `manifest.bin`, which holds a checksum of every array.
        manifest_sha256: [u8; 32],
    },
    /// Another program wrote them: `recorder import`.
    Imported {
        /// Name of the file, or of the folder of queues.
        name: String,
        /// SHA-256 of the file; of a folder, of its files' paths and bytes, in the order in which they were read.
        sha256: [u8; 32],
    },
}

/// The options of a recording, with defaults filled in.
#[derive(Clone, Debug, PartialEq, Encode, Decode, Serialize)]
pub struct Options {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Bounces traced at most; bounce 0 is the camera rays.
    pub bounces: u32,
    /// Samples per pixel.
    pub passes: u32,
    /// How often each method was measured.
    pub repeats: u32,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Name of the camera.
    pub camera: String,
    /// Names of the methods, `unsorted` included.
    pub methods: Vec<String>,
    /// Bits of a key, 8 to 64.
    pub key_bits: u32,
    /// Length that `two-point` assumes, in unit lengths.
    pub two_point_length: f32,
    /// Address bits of the length tables, 8 to 24.
    pub table_bits: u32,
    /// Method whose layout addresses the length tables.
    pub table_method: String,
    /// That layout as text (see [`LayoutText`](crate::key::LayoutText)).
    pub table_layout: String,
    /// Trace kernel: `wide`, `cwbvh`, `bvh2`, `lanes`, `packet` or `ray-query`.
    pub trace_kernel: String,
    /// Threads of the cpu backend; 0 for the gpu backend.
    pub threads: u32,
    /// What was kept, in the words of `--keep`.
    pub keep: Vec<String>,
    /// Which passes were kept: `measured` or `all`.
    pub keep_passes: String,
    /// Whether paths were ended at random by their throughput.
    pub russian_roulette: bool,
}

/// The scene, as far as a dump's numbers refer to it.
#[derive(Clone, Debug, PartialEq, Encode, Decode)]
pub struct SceneSummary {
    /// Name of the file or built-in scene.
    pub name: String,
    /// SHA-256 of everything in the scene that a recording depends on.
    pub content_hash: [u8; 32],
    /// Lowest corner of the bounding box, world units: where unit space starts.
    pub bounds_min: [f32; 3],
    /// Highest corner.
    pub bounds_max: [f32; 3],
    /// Number of triangles.
    pub triangles: u64,
    /// Number of vertices.
    pub vertices: u64,
}

/// A pinhole camera in world space.
#[derive(Clone, Copy, Debug, PartialEq, Encode, Decode)]
pub struct CameraPose {
    /// Where it stands.
    pub eye: [f32; 3],
    /// Unit vector in which it looks.
    pub forward: [f32; 3],
    /// Unit vector to the right of the picture.
    pub right: [f32; 3],
    /// Unit vector to the top of the picture.
    pub up: [f32; 3],
    /// Vertical field of view in radians, in (0, π).
    pub yfov_radians: f32,
}

/// Where the stages ran.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Encode, Decode, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Backend {
    /// wgpu compute.
    Gpu,
    /// Native threads.
    Cpu,
}

impl Backend {
    /// Name on the command line and in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::Gpu => "gpu",
            Self::Cpu => "cpu",
        }
    }
}

/// The machine that was measured.
#[derive(Clone, Debug, PartialEq, Eq, Encode, Decode, Serialize)]
pub struct Adapter {
    /// Name of the adapter or processor.
    pub name: String,
    /// Driver with its version; empty for the cpu backend.
    pub driver: String,
    /// `discrete`, `integrated`, `virtual`, `software` or `other`; `cpu` for the cpu backend.
    pub device_type: String,
    /// Interface that it was reached by, such as `vulkan`; `threads` for the cpu backend.
    pub backend: String,
}

/// One finding of the self-check.
#[derive(Clone, Debug, PartialEq, Eq, Encode, Decode, Serialize)]
pub struct Check {
    /// What was checked.
    pub name: String,
    /// What came out, in a word: `passed`, `failed`, `differs`.
    pub outcome: String,
    /// The numbers behind it; may be empty.
    pub detail: String,
}

/// What the scene needed of the tracer.
#[derive(Clone, Debug, Default, PartialEq, Eq, Encode, Decode, Serialize)]
pub struct Features {
    /// Features that the scene uses.
    pub used: Vec<String>,
    /// Features that cost nothing because the scene does not use them.
    pub skipped: Vec<String>,
}

/// A method that made keys.
#[derive(Clone, Debug, PartialEq, Encode, Decode)]
pub struct MethodRecord {
    /// Name, as in the paths of its arrays.
    pub name: String,
    /// The layout as it was written; empty for an order of another tracer that does not say what its keys are.
    pub text: String,
    /// Name of each bit's coordinate, most significant first, at most 64: `text` for the lights of this scene.
    pub layout: Vec<String>,
    /// Where the estimate of the ray's length comes from.
    pub termination: crate::key::Termination,
    /// Bits of its keys, 8 to 64; keys of up to 32 bits are stored as u32, wider ones as u64.
    pub key_bits: u32,
    /// The method that this is a variant of, as in a sweep over key bits; its own name if it is none.
    pub base: String,
    /// Length that a fixed estimate assumes, in unit lengths.
    pub two_point_length: f32,
}

impl MethodRecord {
    /// Whether it says what its keys are; an order of another tracer need not, and need not have any.
    pub fn has_layout(&self) -> bool {
        !self.text.is_empty()
    }
}

/// What the cache model says of one order: node and triangle addresses of sampled whole groups,
/// replayed through two set-associative caches. A model, not a measurement.
#[derive(Clone, Debug, PartialEq, Eq, Encode, Decode, Serialize)]
pub struct CacheRecord {
    /// The queue.
    #[serde(flatten)]
    pub queue: QueueId,
    /// Method whose order was traced; `unsorted` for canonical order.
    pub method: String,
    /// Groups that were sampled.
    pub groups: u64,
    /// Rays in them.
    pub rays: u64,
    /// Bytes of a cache line.
    pub line_bytes: u32,
    /// Bytes of the first level.
    pub l1_bytes: u64,
    /// Bytes of the second level.
    pub l2_bytes: u64,
    /// Lines that were asked for.
    pub accesses: u64,
    /// Of these, found in the first level.
    pub l1_hits: u64,
    /// Of those not found there, found in the second level.
    pub l2_hits: u64,
}

/// An array whose file is complete.
#[derive(Clone, Debug, PartialEq, Eq, Encode, Decode, Serialize)]
pub struct ArrayRecord {
    /// Where it lies.
    #[serde(rename = "path", serialize_with = "as_text")]
    pub place: Place,
    /// Element type.
    #[serde(serialize_with = "as_text")]
    pub dtype: Dtype,
    /// Lengths of the dimensions, slowest first.
    pub shape: Vec<u64>,
    /// CRC-32C (Castagnoli) of the data, the NPY header not included.
    #[serde(skip)]
    pub crc32c: u32,
    /// Bytes of the data, the NPY header not included.
    pub bytes: u64,
}

/// The path of an array or NumPy's description of its elements, in JSON.
fn as_text<S: Serializer>(value: &impl std::fmt::Display, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(value)
}

/// A queue of rays whose arrays are complete.
#[derive(Clone, Debug, PartialEq, Eq, Encode, Decode, Serialize)]
pub struct QueueRecord {
    /// Which queue.
    #[serde(flatten)]
    pub id: QueueId,
    /// Rays in it.
    pub rays: u64,
    /// Methods that were measured on it, `unsorted` included; empty in a pass that was not measured.
    pub methods: Vec<String>,
    /// How many results of each method's traces differed from those of `unsorted`.
    pub mismatches: Vec<Mismatches>,
}

/// How many results of a method's traces differed from the baseline's.
#[derive(Clone, Debug, PartialEq, Eq, Encode, Decode, Serialize)]
pub struct Mismatches {
    /// The method.
    pub method: String,
    /// Rays with another result.
    pub rays: u64,
}

/// The samples of one stage's time.
#[derive(Clone, Debug, PartialEq, Eq, Encode, Decode)]
pub struct TimingRecord {
    /// Pass in which it was taken.
    pub pass: u32,
    /// Bounce.
    pub bounce: u32,
    /// Kind of the queue; `None` for stages that serve both kinds, such as generate and shade.
    pub kind: Option<Kind>,
    /// Method; `unsorted` for the baseline and for stages without one.
    pub method: String,
    /// Stage.
    pub stage: Stage,
    /// One sample per repeat, nanoseconds.
    pub samples_ns: Vec<u64>,
}

/// Samples of a timing that were taken while the machine did other work.
#[derive(Clone, Debug, PartialEq, Eq, Encode, Decode)]
pub struct DisturbedRecord {
    /// The timing's queue.
    pub queue: QueueId,
    /// Its method.
    pub method: String,
    /// Its stage.
    pub stage: Stage,
    /// Places among its samples, ascending.
    pub samples: Vec<u32>,
}

/// How a method's rays are traced in its totals: chosen once per recording, from a round that no figure uses.
#[derive(Clone, Debug, PartialEq, Eq, Encode, Decode)]
pub struct WayRecord {
    /// The method.
    pub method: String,
    /// The way.
    pub way: Way,
}

/// What orders were worth on one queue of the calibration, from times that are not in the recording.
#[derive(Clone, Debug, PartialEq, Encode, Decode, Serialize)]
pub struct CalibrationRecord {
    /// Bounce of the queue.
    pub bounce: u32,
    /// Its kind.
    pub kind: Kind,
    /// Rays in it.
    pub rays: u64,
    /// Mean capsule area of its sample, unit space: see [`sampled_area`](crate::auto::sampled_area).
    pub area: f64,
    /// What was tried.
    pub candidates: Vec<Candidate>,
}

/// An order that `auto` may choose, and what it was worth.
#[derive(Clone, Debug, PartialEq, Encode, Decode, Serialize)]
pub struct Candidate {
    /// The order.
    #[serde(flatten)]
    pub choice: Choice,
    /// Net speedup: the trace of canonical order over all that this order took, deciding not included; median
    /// over rounds.
    pub net: f64,
    /// Lower end of its 95 % interval.
    pub net_low: f64,
}

/// A method, the bits of its key, and how its rays are traced.
#[derive(Clone, Debug, PartialEq, Eq, Encode, Decode, Serialize)]
pub struct Choice {
    /// Name of a built-in method.
    pub method: String,
    /// Bits of its keys, 8 to 64.
    pub key_bits: u32,
    /// How its rays are traced.
    pub way: Way,
}

impl fmt::Display for Choice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let way = match self.way {
            Way::Gathered => "gathered",
            Way::Indices => "through indices",
        };
        write!(f, "{}, {} bits, {way}", self.method, self.key_bits)
    }
}

/// Which order `auto` gave a queue.
#[derive(Clone, Debug, PartialEq, Encode, Decode, Serialize)]
pub struct DecisionRecord {
    /// The queue.
    #[serde(flatten)]
    pub queue: QueueId,
    /// Mean capsule area of its sample, unit space; 0 where none was taken: the queue was known by its bounce and rays,
    /// or there was nothing to choose.
    pub area: f64,
    /// What was chosen; `None` to leave the queue alone.
    pub choice: Option<Choice>,
}

/// What is said of rays that `auto` gave no order.
pub const LEFT_ALONE: &str = "left alone";

impl DecisionRecord {
    /// What was chosen, in words; [`LEFT_ALONE`] if nothing was.
    pub fn chosen(&self) -> String {
        self.choice.as_ref().map_or(LEFT_ALONE.to_owned(), ToString::to_string)
    }
}

/// How sorted rays are traced.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Encode, Decode, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Way {
    /// Gathered, traced as they then lie, results scattered home.
    Gathered,
    /// Through indices, from and to canonical places.
    Indices,
}

impl Way {
    /// Both ways, in the order in which numbers by way are kept.
    pub const ALL: [Self; 2] = [Self::Gathered, Self::Indices];

    /// The stages that it takes.
    pub fn stages(self) -> &'static [Stage] {
        match self {
            Self::Gathered => &[Stage::Gather, Stage::Trace, Stage::Scatter],
            Self::Indices => &[Stage::TraceIndirect],
        }
    }

    /// Whether a stage counts: all but those of the other way.
    pub fn counts(self, stage: Stage) -> bool {
        let other = match self {
            Self::Gathered => Self::Indices,
            Self::Indices => Self::Gathered,
        };
        !other.stages().contains(&stage)
    }
}

/// A stage that is timed.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Encode, Decode, Serialize, Deserialize,
)]
#[serde(rename_all = "snake_case")]
pub enum Stage {
    /// Making keys, with the table query of two-point-adaptive.
    Key,
    /// Sorting them.
    Sort,
    /// Gathering rays into the new order.
    Gather,
    /// Tracing rays as they lie, gathered or, for the baseline, in canonical order. Until version 2 the
    /// trace of gathered rays wrote each result to its canonical place.
    Trace,
    /// Tracing through indices, without gather.
    TraceIndirect,
    /// Adding traced lengths to the table.
    Accumulate,
    /// Making camera rays.
    Generate,
    /// From hits to the next rays.
    Shade,
    /// Bringing the results of gathered rays home to canonical places.
    Scatter,
    /// Choosing an order: looking at a sample of the rays.
    Decide,
}

impl Stage {
    /// What an order is timed by, in the order in which stages run; those of both ways of tracing.
    pub const OF_ORDERS: [Self; 8] = [
        Self::Decide,
        Self::Key,
        Self::Sort,
        Self::Gather,
        Self::Trace,
        Self::Scatter,
        Self::TraceIndirect,
        Self::Accumulate,
    ];

    /// Name in JSON and tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Key => "key",
            Self::Sort => "sort",
            Self::Gather => "gather",
            Self::Trace => "trace",
            Self::TraceIndirect => "trace_indirect",
            Self::Accumulate => "accumulate",
            Self::Generate => "generate",
            Self::Shade => "shade",
            Self::Scatter => "scatter",
            Self::Decide => "decide",
        }
    }
}

/// How a recording ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Encode, Decode)]
pub struct End {
    /// Whether it ran to its end.
    pub outcome: Outcome,
    /// The picture; `None` if there is none, as in a recovered dump.
    pub image: Option<ImageDigest>,
    /// Wall time of the whole recording in nanoseconds; 0 if not known, as in a recovered dump.
    pub wall_ns: u64,
}

/// Whether a recording ran to its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Encode, Decode)]
pub enum Outcome {
    /// It did.
    Complete,
    /// It was ended early, and what was complete was made a dump by `recover`.
    Recovered,
}

/// The picture's size and hash, whether or not the picture itself was kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Encode, Decode)]
pub struct ImageDigest {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// SHA-256 of the data of `image.npy` (the NPY header not included): f4 (H, W, 3), linear RGB, top row first.
    pub sha256: [u8; 32],
}
