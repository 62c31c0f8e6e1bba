//! Gather on threads.

use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use formats::ray::Ray;
use rayon::prelude::*;

use crate::stages::prefetch::{AHEAD, prefetch};

/// Rays that one task copies.
const CHUNK: usize = 1 << 12;

/// `gathered[i] = rays[permutation[i]]`.
///
/// # Panics
/// If there are not as many places as rays.
pub fn gather(rays: &[Ray], permutation: &[AtomicU32], gathered: &mut [Ray]) {
    assert!(rays.len() == permutation.len() && rays.len() == gathered.len(), "a place for each ray");
    let chunks = permutation.par_chunks(CHUNK).zip(gathered.par_chunks_mut(CHUNK));
    chunks.for_each(|(places, gathered)| {
        let ray = |at: usize| &rays[places[at].load(Relaxed) as usize];
        for (at, gathered) in gathered.iter_mut().enumerate() {
            if at + AHEAD < places.len() {
                prefetch(ray(at + AHEAD));
            }
            *gathered = *ray(at);
        }
    });
}
