//! The rays of a queue in parts that a thread takes at once.

use std::sync::atomic::AtomicU32;
use std::sync::atomic::Ordering::Relaxed;

use formats::ray::Ray;
use rayon::prelude::*;

use super::Order;
use crate::stages::prefetch::prefetch;

/// Rays that a thread takes at once, and no more: in a sorted order whole stretches cost many times as much as
/// others, and what a thread has begun no other one can take over.
pub(super) const CHUNK: usize = 256;

/// How many rays ahead a ray is asked for that lies elsewhere: one takes about as long as a miss.
const RAYS_AHEAD: usize = 2;

/// Rays that one thread traces one after the other, and the places of their results.
pub(super) struct Part<'a, T> {
    /// All of a queue where the order is indirect, so are the results.
    pub rays: &'a [Ray],
    pub order: Order<&'a [AtomicU32]>,
    pub results: &'a [T],
}

impl<'a, T> Part<'a, T> {
    #[inline(always)]
    pub(super) fn len(&self) -> usize {
        match self.order {
            Order::Stored => self.rays.len(),
            Order::Indirect(places) => places.len(),
        }
    }

    /// The ray at a place of the order, and the place of its result. What lies elsewhere is asked for ahead: the
    /// ray, and the result's place before its ray is traced.
    #[inline(always)]
    pub(super) fn get(&self, at: usize) -> (&'a Ray, &'a T) {
        let place = match self.order {
            Order::Stored => at,
            Order::Indirect(places) => {
                if let Some(ahead) = places.get(at + RAYS_AHEAD) {
                    prefetch(&self.rays[ahead.load(Relaxed) as usize]);
                }
                let place = places[at].load(Relaxed) as usize;
                prefetch(&self.results[place]);
                place
            }
        };
        (&self.rays[place], &self.results[place])
    }
}

/// Calls `trace` for each part of a queue, on all threads.
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
        Order::Indirect(permutation) => permutation
            .par_chunks(CHUNK)
            .with_max_len(1)
            .for_each(|places| trace(Part { rays, order: Order::Indirect(places), results })),
    }
}
