//! Every figure that recordings and benchmark results can give, one file per family.
//!
//! - [`speedups`]: trace speedup, the same by kernel, net speedup
//! - [`rates`], [`overhead`], [`bandwidth`]: rays a second, what each stage takes, bytes a second
//! - [`break_even`]: what a sort may cost
//! - [`capsules`]: capsule area against trace time, its distribution
//! - [`sweeps`]: key bits, assumed length
//! - [`tables`]: fill of the length table, errors of estimated lengths
//! - [`models`]: lane utilisation, cache misses
//! - [`benches`]: sort throughput, trace rate
//! - [`errors`]: run time against error, what skipping saves
//! - [`shading`]: frames whose hits are sorted before they are shaded
//! - [`picture`], [`headline`]: the image and what each pixel cost; one view, unsorted and sorted
//! - [`curve`]: what a curve through a grid is
//! - [`building`]: what they share

pub mod bandwidth;
pub mod benches;
pub mod break_even;
pub mod building;
pub mod capsules;
pub mod curve;
pub mod errors;
pub mod headline;
pub mod models;
pub mod overhead;
pub mod picture;
pub mod rates;
pub mod shading;
pub mod speedups;
pub mod study;
pub mod sweeps;
pub mod tables;

use formats::bench_result::BenchResult;
use serde::Serialize;

use super::model::Figure;
use crate::analysis::Analysis;

/// What figures are made from.
#[derive(Clone, Copy, Debug)]
pub struct Findings<'a> {
    /// Of the recordings.
    pub analysis: &'a Analysis,
    /// Benchmark results.
    pub benches: &'a [BenchResult],
}

/// A figure, or why there is none in a sentence without its full stop.
pub type Made = Result<Figure, String>;

/// A figure that is not made: there is nothing to show.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Skipped {
    /// Its name.
    pub figure: String,
    /// In a sentence without its full stop.
    pub reason: String,
}

/// How a figure of the catalogue is made.
#[derive(Clone, Copy, Debug)]
pub struct FigureMaker {
    /// File name without extension, and the word for `--figure`.
    pub name: &'static str,
    /// What it shows, in one line.
    pub description: &'static str,
    made: fn(&Findings<'_>) -> Made,
}

const fn maker(
    name: &'static str,
    description: &'static str,
    made: fn(&Findings<'_>) -> Made,
) -> FigureMaker {
    FigureMaker { name, description, made }
}

impl FigureMaker {
    /// Makes it.
    ///
    /// # Errors
    /// If there is nothing to show: why.
    pub fn make(&self, findings: &Findings<'_>) -> Result<Figure, Skipped> {
        let name = || self.name.to_owned();
        let made = (self.made)(findings).map(|figure| Figure { name: name(), ..figure });
        made.map_err(|reason| Skipped { figure: name(), reason })
    }
}

/// Every figure, in the order of a paper.
pub const CATALOGUE: &[FigureMaker] = &[
    maker("study-speedup", "means over the scenes and views of a study", study::speedups),
    maker("trace-speedup", "trace speedup per scene and method", speedups::trace),
    maker("kernel-speedup", "trace speedup per kernel and method, beside the paper's", speedups::kernels),
    maker("net-speedup", "speedup with all that sorting costs", speedups::net),
    maker("rays-per-second", "trace rate per bounce and method", rates::rays_per_second),
    maker("overhead", "time of each stage per method, against break-even", overhead::overhead),
    maker("break-even", "what a sort saves in tracing and what it costs, per ray", break_even::break_even),
    maker("capsule-area", "mean capsule area against trace time", capsules::against_time),
    maker("capsule-area-distribution", "share of rays by their group's capsule area", capsules::distribution),
    maker("key-bits", "speedup by bits of the key", sweeps::key_bits),
    maker("origin-bits", "speedup by the origin's share of the key", sweeps::split),
    maker("two-point-length", "speedup by the length that two-point assumes", sweeps::length),
    maker("table-fill", "fill of the length table over bounces and passes", tables::fill),
    maker("estimator-error", "errors of estimated ray lengths over bounces and passes", tables::errors),
    maker("lane-utilisation", "share of 32 lanes that work (a model)", models::lanes),
    maker("cache-misses", "cache lines not found in L1 and L2 (a model)", models::caches),
    maker("bandwidth", "achieved bandwidth per stage", bandwidth::bandwidth),
    maker("sort-throughput", "keys sorted a second, by number and bits", benches::sort),
    maker("trace-rate", "rays traced a second, by kernel, rays and order", benches::trace),
    maker("precision-error", "trace rate against errors of hits, by kernel and test", errors::precision),
    maker(
        "estimator-cost",
        "errors of estimated lengths by the table's size and by pass, and their cost",
        errors::estimator,
    ),
    maker("key-bits-cost", "speedup by bits of the key, in tracing and with key and sort", errors::key_bits),
    maker("image-error", "time of a picture by method, and its noise against time", errors::image),
    maker("shading", "frame time and speedup by what hits are sorted by before shading", shading::shading),
    maker("skipped", "what skipping saves, each thing on and off", errors::skipped),
    maker("pixel-cost", "the picture, and the work behind each pixel", picture::pixel_cost),
    maker("headline", "one view unsorted and sorted: capsule area, trace rate", headline::headline),
    maker("curve", "a grid in Morton's and in Hilbert's order, and its jumps", curve::curve),
];
