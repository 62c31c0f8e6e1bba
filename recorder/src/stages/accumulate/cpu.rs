//! Accumulate on threads.

use formats::key::Encoder;
use formats::length_table::LengthTable;
use formats::ray::Ray;
use rayon::prelude::*;

/// Rays that one task adds.
const CHUNK: usize = 1 << 14;

/// Adds each ray's traced length to its cell. `length` gives it by canonical index, unit lengths.
pub fn accumulate(table: &LengthTable, cells: &Encoder, rays: &[Ray], length: impl Fn(usize) -> f32 + Sync) {
    rays.par_chunks(CHUNK).enumerate().for_each(|(number, rays)| {
        let first = number * CHUNK;
        cells.encode_all(rays, |_| 0.0, |_| 0, |at, cell| table.add(cell as u32, length(first + at)));
    });
}
