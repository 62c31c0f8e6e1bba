//! Every figure that recordings and benchmark results can give, one file per family.
//!
//! - [`speedups`]: trace speedup, net speedup
//! - [`rates`], [`overhead`], [`bandwidth`]: rays a second, what each stage takes, bytes a second
//! - [`capsules`]: capsule area against trace time, its distribution
//! - [`sweeps`]: key bits, assumed length
//! - [`tables`]: fill of the length table, errors of estimated lengths
//! - [`models`]: lane utilisation, cache hit ratios
//! - [`benches`]: sort throughput, trace rate
//! - [`errors`]: run time against error, what skipping saves
//! - [`picture`]: the image and what each pixel cost
//! - [`building`]: what they share

pub mod bandwidth;
pub mod benches;
pub mod building;
pub mod capsules;
pub mod errors;
pub mod models;
pub mod overhead;
pub mod picture;
pub mod rates;
pub mod speedups;
pub mod sweeps;
pub mod tables;

use formats::bench_result::BenchResult;

use super::model::Figure;
use crate::analysis::Analysis;

/// What figures are made from.
#[derive(Clone, Copy, Debug)]
pub struct Material<'a> {
    /// Of the recordings.
    pub analysis: &'a Analysis,
    /// Benchmark results.
    pub benches: &'a [BenchResult],
}

/// Why a figure is not made: there is nothing to show.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{reason}")]
pub struct Skipped {
    /// In a sentence without its full stop.
    pub reason: String,
}

impl Skipped {
    /// For this reason.
    pub fn because(reason: impl Into<String>) -> Self {
        Self { reason: reason.into() }
    }
}

/// A figure of the catalogue.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    /// File name without extension, and the word for `--figure`.
    pub name: &'static str,
    /// What it shows, in one line.
    pub description: &'static str,
    /// Makes it.
    pub make: fn(&Material<'_>) -> Result<Figure, Skipped>,
}

const fn entry(
    name: &'static str,
    description: &'static str,
    make: fn(&Material<'_>) -> Result<Figure, Skipped>,
) -> Entry {
    Entry { name, description, make }
}

/// Every figure, in the order of a paper.
pub const CATALOGUE: &[Entry] = &[
    entry("trace-speedup", "trace speedup per scene and method", speedups::trace),
    entry("net-speedup", "speedup with all that sorting costs", speedups::net),
    entry("rays-per-second", "trace rate per bounce and method", rates::rays_per_second),
    entry("overhead", "time of each stage per method, against break-even", overhead::overhead),
    entry("capsule-area", "mean capsule area against trace time", capsules::against_time),
    entry("capsule-area-distribution", "share of rays by their group's capsule area", capsules::distribution),
    entry("key-bits", "speedup by bits of the key", sweeps::key_bits),
    entry("two-point-length", "speedup by the length that two-point assumes", sweeps::length),
    entry("table-fill", "fill of the length table over bounces and passes", tables::fill),
    entry("estimator-error", "errors of estimated ray lengths over bounces and passes", tables::errors),
    entry("lane-utilisation", "share of lanes that work, by width (a model)", models::lanes),
    entry("cache-hit-ratio", "cache lines found in L1 and L2 (a model)", models::caches),
    entry("bandwidth", "achieved bandwidth per stage", bandwidth::bandwidth),
    entry("sort-throughput", "keys sorted a second, by number and bits", benches::sort),
    entry("trace-rate", "rays traced a second, by kernel, rays and order", benches::trace),
    entry("precision-error", "trace rate against lost and wrong hits, by kernel and test", errors::precision),
    entry("estimator-cost", "cost of the length table against the error of its estimates", errors::estimator),
    entry("key-bits-cost", "key and sort time against capsule area and trace time", errors::key_bits),
    entry("image-error", "noise of the picture against wall time, by method", errors::image),
    entry("skipped", "what skipping saves, each thing on and off", errors::skipped),
    entry("pixel-cost", "the picture, and the work behind each pixel", picture::pixel_cost),
];

/// Makes every figure, or says why not.
pub fn make_all(material: &Material<'_>) -> Vec<(&'static Entry, Result<Figure, Skipped>)> {
    CATALOGUE.iter().map(|entry| (entry, (entry.make)(material))).collect()
}
