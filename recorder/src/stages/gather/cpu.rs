//! Gather on threads.

use formats::ray::Ray;
use rayon::prelude::*;

/// Rays that one task copies.
const CHUNK: usize = 1 << 14;

/// `result[i] = rays[permutation[i]]`.
pub fn gather(rays: &[Ray], permutation: &[u32]) -> Vec<Ray> {
    permutation.par_iter().with_min_len(CHUNK).map(|&index| rays[index as usize]).collect()
}
