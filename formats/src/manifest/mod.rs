//! The manifest of a dump: what was recorded, how, and which arrays there are.
//!
//! - [`records`]: what the manifest says, record by record
//! - [`place`]: where each array lies and what it may look like
//! - `codec`: a record as bytes, and back
//! - [`scan`]: a manifest file as records, up to the first fault or past damaged ones
//! - [`check`]: whether a header is one that a recorder writes
//!
//! The bytes are described in FORMAT.md.

pub mod check;
mod codec;
pub mod place;
pub mod records;
pub mod scan;

pub use codec::encode_frame;
pub use place::{MethodArray, Place, QueueArray, QueueId, SceneArray};
pub use records::{
    Adapter, ArrayRecord, Backend, CacheRecord, CalibrationRecord, CameraPose, Candidate, Check, Choice,
    DecisionRecord, DisturbedRecord, End, Features, Header, ImageDigest, LEFT_ALONE, MethodRecord,
    Mismatches, Options, Outcome, QueueRecord, Record, SceneSummary, Source, Stage, TimingRecord, Way,
    WayRecord,
};
pub use scan::{Fault, Manifest, ManifestError};

/// Name, among the header's self-checks, of what was found of hits that came with imported rays.
pub const IMPORTED_HITS: &str = "imported hits";
/// Name of the manifest in a dump's folder.
pub const FILE_NAME: &str = "manifest.bin";
/// The first bytes of a manifest.
pub const MAGIC: [u8; 8] = *b"RAYDUMP\0";
/// Version of the format, of which FORMAT.md speaks. A new kind of record or array is a new version, and so is
/// another rule for what one says.
pub const FORMAT_VERSION: u32 = 13;
/// The oldest version that is read: it lacks some kinds of records, and what means something else in a version
/// is read by that version's rule (FORMAT.md, "Versions").
pub const OLDEST_VERSION: u32 = 2;
/// Magic, version and four reserved bytes that are 0.
pub const PREAMBLE_BYTES: usize = 16;
/// Length and checksum before every record.
pub const FRAME_BYTES: usize = 8;
/// Longest record that is read or written; no header, however many lights there are, comes near it.
pub const RECORD_BYTES_MAX: usize = 64 << 20;

/// The first [`PREAMBLE_BYTES`] bytes of a new manifest.
pub fn preamble() -> [u8; PREAMBLE_BYTES] {
    preamble_of(FORMAT_VERSION)
}

/// Those of a manifest of some version.
pub fn preamble_of(version: u32) -> [u8; PREAMBLE_BYTES] {
    let mut bytes = [0; PREAMBLE_BYTES];
    bytes[..8].copy_from_slice(&MAGIC);
    bytes[8..12].copy_from_slice(&version.to_le_bytes());
    bytes
}
