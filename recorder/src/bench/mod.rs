//! Benchmarks of single stages, as `formats::bench_result` for figures and as a table.
//!
//! - [`sort`]: sort throughput over the number of keys and their bits
//! - [`trace`]: trace rate per scene, kernel, bounce, kind and order
//! - [`error`]: run time against error: triangle tests, length tables, key bits, pictures
//! - [`skip`]: what skipping saves, each thing on and off
//! - [`instrument`]: what the clock itself misses by
//! - [`render`]: frames as a renderer makes them that keeps to one order
//! - [`capture`]: what keeping everything costs beside tracing and beside the disk
//! - [`growth`]: how time and memory grow with sizes
//! - [`startup`]: what happens before the first ray
//! - `backends`, `queues`: what they share

mod backends;
pub mod capture;
pub mod error;
pub mod growth;
mod hit_orders;
pub mod instrument;
mod queues;
pub mod render;
pub mod skip;
pub mod sort;
pub mod startup;
pub mod trace;

use std::path::Path;

use anyhow::Result;
use formats::bench_result::{BENCH_VERSION, BenchResult, Rows};
use formats::metrics::speedup::{interquartile_range, median};

use crate::machine::Device;
use crate::machine::description::Description;
use crate::options::RecordOptions;

/// Scenes to run, one after the other.
#[derive(Clone, Debug)]
pub struct Runs {
    /// Scenes, files or built-in names.
    pub scenes: Vec<String>,
    /// Size of the run, methods, device; what is to be kept is of no interest.
    pub run: RecordOptions,
}

/// What was measured, on which device.
pub(crate) fn result(device: &Device, rows: Rows) -> BenchResult {
    let device = Description::of(device);
    let command: Vec<String> = std::env::args().skip(1).collect();
    BenchResult {
        rayscope_bench: BENCH_VERSION,
        program_version: env!("CARGO_PKG_VERSION").to_owned(),
        command: format!("recorder {}", command.join(" ")),
        backend: device.backend.name().to_owned(),
        adapter: device.adapter.name,
        driver: device.adapter.driver,
        threads: device.threads,
        time_source: device.time_source.to_owned(),
        instrument: None,
        rows,
    }
}

/// Millions of items a second at the median, and the interquartile range in percent of the median.
pub(crate) fn rate(items: u64, samples_ns: &[u64]) -> Option<(f64, f64)> {
    let median_ns = median(samples_ns)?;
    let spread = interquartile_range(samples_ns)? / median_ns.max(1.0) * 100.0;
    Some((items as f64 / median_ns.max(1.0) * 1e3, spread))
}

/// Bytes of all files in a folder.
pub(crate) fn folder_bytes(folder: &Path) -> Result<u64> {
    let mut bytes = 0;
    for entry in std::fs::read_dir(folder)? {
        let entry = entry?;
        let metadata = entry.metadata()?;
        bytes += if metadata.is_dir() { folder_bytes(&entry.path())? } else { metadata.len() };
    }
    Ok(bytes)
}
