//! Accumulate: adds each ray's traced length to its cell of the length table.

pub mod gpu;

use formats::key::Encoder;
use formats::length_table::LengthTable;
use formats::ray::Ray;
use rayon::prelude::*;

/// Rays that one task adds.
const CHUNK: usize = 1 << 14;

/// On threads. `length` gives the traced length of a ray by canonical index, unit lengths.
pub fn on_threads(table: &LengthTable, cells: &Encoder, rays: &[Ray], length: impl Fn(usize) -> f32 + Sync) {
    rays.par_iter().enumerate().with_min_len(CHUNK).for_each(|(index, ray)| {
        table.add(cells.encode(ray, 0.0, 0) as u32, length(index));
    });
}
