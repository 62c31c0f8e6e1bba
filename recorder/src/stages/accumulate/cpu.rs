//! Accumulate on threads.

use formats::key::{Encoder, NO_FACTS};
use formats::length_table::LengthTable;
use formats::prefetch::prefetch_cell;
use formats::ray::Ray;
use rayon::prelude::*;

/// Rays that one task adds: few enough that the cells asked for are still there when they are added to.
const CHUNK: usize = 1 << 10;

/// Adds each ray's traced length to its cell. `length` gives it by canonical index, unit lengths.
pub fn accumulate(table: &LengthTable, cells: &Encoder, rays: &[Ray], length: impl Fn(usize) -> f32 + Sync) {
    rays.par_chunks(CHUNK).enumerate().for_each(|(number, rays)| {
        let first = number * CHUNK;
        let mut cell_of = [0; CHUNK];
        cells.encode_all(rays, &NO_FACTS, |at, cell| {
            cell_of[at] = cell as u32;
            prefetch_cell(table, cell as u32);
        });
        (0..rays.len()).for_each(|at| table.add(cell_of[at], length(first + at)));
    });
}
