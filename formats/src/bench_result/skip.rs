//! Rows of `recorder bench skip` and `recorder bench startup`.

use serde::{Deserialize, Serialize};

/// One thing that is skipped where it is not needed, as it is and with the skip turned off.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SkipRow {
    /// Name of the scene.
    pub scene: String,
    /// What is skipped.
    pub what: String,
    /// What its time and bytes are those of: `shade`, `trace`, `sort`, `recording` and so on.
    pub of: String,
    /// As it is: without what the scene does not need.
    pub skipped: Cost,
    /// With the skip turned off.
    pub done: Cost,
    /// What was compared, and is the same to the last bit in both: `picture`, `hits`, `permutation`, ….
    pub same: String,
    /// Whether it is the same.
    pub is_same: bool,
}

/// Time and bytes of something.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Cost {
    /// One sample per repeat, nanoseconds; empty where time is not what is saved.
    pub samples_ns: Vec<u64>,
    /// Bytes in memory or on disk that only this is for; 0 where there are none.
    pub bytes: u64,
}

/// What happens before the first ray of a scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StartupRow {
    /// Name of the scene.
    pub scene: String,
    /// Its triangles.
    pub triangles: u64,
    /// Trace kernel.
    pub kernel: String,
    /// Step: `parse`, `tables`, `hierarchy-build`, `hierarchy-cached`, `upload`, `pipelines`.
    pub step: String,
    /// One sample per repeat, nanoseconds.
    pub samples_ns: Vec<u64>,
}
