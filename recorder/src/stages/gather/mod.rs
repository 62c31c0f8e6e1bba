//! Gather: copies rays into a sorted order, so that neighbours in the order are neighbours in memory.

pub mod gpu;

use formats::ray::Ray;
use rayon::prelude::*;

/// Rays that one task copies.
const CHUNK: usize = 1 << 14;

/// On threads: `result[i] = rays[order[i]]`.
pub fn on_threads(rays: &[Ray], order: &[u32]) -> Vec<Ray> {
    order.par_iter().with_min_len(CHUNK).map(|&index| rays[index as usize]).collect()
}
