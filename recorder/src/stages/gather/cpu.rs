//! Gather on threads.

use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use formats::prefetch::{AHEAD, prefetch};
use formats::ray::Ray;
use rayon::prelude::*;

use crate::stages::compact::cpu::Paths;

/// Rays or paths that one task copies.
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

/// The same with all that paths carry.
///
/// # Panics
/// If there are not as many places as paths.
pub fn gather_paths(paths: &Paths, permutation: &[AtomicU32], gathered: &mut Paths) {
    let counts = [paths.ids.len(), gathered.ids.len()];
    assert!(counts == [permutation.len(); 2], "a place for each path");
    let chunks = permutation.par_chunks(CHUNK).zip(gathered.parts().chunks(CHUNK));
    chunks.for_each(|(places, mut gathered)| {
        let index = |at: usize| places[at].load(Relaxed) as usize;
        for at in 0..places.len() {
            if at + AHEAD < places.len() {
                let ahead = index(at + AHEAD);
                prefetch(&paths.rays[ahead]);
                prefetch(&paths.ids[ahead]);
                prefetch(&paths.states[ahead]);
                prefetch(&paths.lights[ahead]);
            }
            let from = index(at);
            let ray = (paths.rays[from], paths.states[from]);
            gathered.put(at, paths.ids[from], ray, paths.lights[from]);
        }
    });
}
