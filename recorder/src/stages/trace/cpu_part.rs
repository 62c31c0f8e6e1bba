//! The rays of a queue in parts that a thread takes at once.

use std::sync::atomic::AtomicU32;
use std::sync::atomic::Ordering::Relaxed;

use bytemuck::Zeroable;
use formats::prefetch::prefetch;
use formats::ray::Ray;
use rayon::prelude::*;

use super::Order;
use crate::stages::gather::cpu::gather_part;

/// Rays that a thread takes at once, and no more: in a sorted order whole stretches cost many times as much as
/// others, and what a thread has begun no other one can take over.
pub(super) const CHUNK: usize = 256;

/// How many rays ahead the place of a result is asked for.
const RESULTS_AHEAD: usize = 2;

/// Rays that one thread traces one after the other, and the places of their results.
pub(super) struct Part<'a, T> {
    pub rays: &'a [Ray],
    /// Where the results of the rays lie: as the rays do, or each at its index.
    pub order: Order<&'a [AtomicU32]>,
    /// All of a queue's where the order is indirect.
    pub results: &'a [T],
}

impl<'a, T> Part<'a, T> {
    #[inline(always)]
    pub(super) fn len(&self) -> usize {
        self.rays.len()
    }

    /// A ray and the place of its result, which is asked for ahead where it lies elsewhere.
    #[inline(always)]
    pub(super) fn get(&self, at: usize) -> (&'a Ray, &'a T) {
        let result = match self.order {
            Order::Stored => &self.results[at],
            Order::Indirect(places) => {
                if let Some(ahead) = places.get(at + RESULTS_AHEAD) {
                    prefetch(&self.results[ahead.load(Relaxed) as usize]);
                }
                &self.results[places[at].load(Relaxed) as usize]
            }
        };
        (&self.rays[at], result)
    }
}

/// Calls `trace` for each part of a queue, on all threads. Rays that lie elsewhere are brought into the cache of
/// the thread part by part: asked for long ahead, which tracing one after the other cannot do.
pub(super) fn for_each_part<T: Sync>(
    rays: &[Ray],
    order: Order<&[AtomicU32]>,
    results: &[T],
    trace: impl Fn(Part<'_, T>) + Sync,
) {
    assert_eq!(rays.len(), results.len(), "one result per ray");
    match order {
        Order::Stored => {
            let parts = rays.par_chunks(CHUNK).zip(results.par_chunks(CHUNK)).with_max_len(1);
            parts.for_each(|(rays, results)| trace(Part { rays, order, results }));
        }
        Order::Indirect(permutation) => {
            permutation.par_chunks(CHUNK).with_max_len(1).for_each(|places| {
                let mut gathered = [Ray::zeroed(); CHUNK];
                gather_part(rays, places, &mut gathered);
                let rays = &gathered[..places.len()];
                trace(Part { rays, order: Order::Indirect(places), results });
            });
        }
    }
}
