//! The rays of a queue in parts that a thread takes at once.

use std::sync::atomic::AtomicU32;
use std::sync::atomic::Ordering::Relaxed;

use formats::prefetch::{prefetch, prefetch_to_write};
use formats::ray::Ray;
use rayon::prelude::*;

use super::Order;
use super::cpu_packet::PacketTree;

/// Rays that a thread takes at once, and no more: in a sorted order whole stretches cost many times as much as
/// others, and what a thread has begun no other one can take over.
pub(super) const CHUNK: usize = 256;

/// Fewest rays of a part: less would take longer to hand out than it saves.
const FEWEST: usize = 64;

/// Parts that each thread takes of a short queue, so that none waits long for the others at the end.
const PARTS: usize = 8;

/// How many rays ahead a ray and the place of its result are asked for: as many as the widest kernel takes at once.
const AHEAD: usize = PacketTree::WIDTH;

/// Rays that one thread traces one after the other, and the places of their results.
pub(super) struct Part<'a, T> {
    /// Those of the part as they lie, or through indices all of the queue.
    rays: &'a [Ray],
    /// Through indices: those of the part, and after them those of the parts that follow.
    order: Order<&'a [AtomicU32]>,
    /// Of the same rays.
    results: &'a [T],
    len: usize,
}

impl<T> Clone for Part<'_, T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for Part<'_, T> {}

impl<'a, T> Part<'a, T> {
    /// Rays that are traced as they lie, and as many results.
    pub(super) fn new(rays: &'a [Ray], results: &'a [T]) -> Self {
        Self { rays, order: Order::Stored, results, len: rays.len() }
    }

    #[inline(always)]
    pub(super) fn len(&self) -> usize {
        self.len
    }

    /// So many of its rays, and those after them.
    pub(super) fn split_at(self, count: usize) -> (Self, Self) {
        let count = count.min(self.len);
        let rest = match self.order {
            Order::Stored => Self { rays: &self.rays[count..], results: &self.results[count..], ..self },
            Order::Indirect(places) => Self { order: Order::Indirect(&places[count..]), ..self },
        };
        (Self { len: count, ..self }, Self { len: self.len - count, ..rest })
    }

    /// A ray.
    #[inline(always)]
    pub(super) fn ray(&self, at: usize) -> &'a Ray {
        &self.rays[self.index(at)]
    }

    /// The place of a ray's result.
    #[inline(always)]
    pub(super) fn place(&self, at: usize) -> &'a T {
        &self.results[self.index(at)]
    }

    #[inline(always)]
    fn index(&self, at: usize) -> usize {
        match self.order {
            Order::Stored => at,
            Order::Indirect(places) => places[at].load(Relaxed) as usize,
        }
    }

    /// A ray and the place of its result; what lies elsewhere is asked for ahead.
    #[inline(always)]
    pub(super) fn get(&self, at: usize) -> (&'a Ray, &'a T) {
        let index = match self.order {
            Order::Stored => at,
            Order::Indirect(places) => {
                // Beyond the part, too: most often the thread takes the next one.
                if let Some(ahead) = places.get(at + AHEAD) {
                    let ahead = ahead.load(Relaxed) as usize;
                    prefetch(&self.rays[ahead]);
                    prefetch_to_write(self.results, ahead);
                }
                places[at].load(Relaxed) as usize
            }
        };
        (&self.rays[index], &self.results[index])
    }
}

/// Rays of a part of a queue, where rays are traced one by one.
pub(super) fn part_of(rays: usize) -> usize {
    (rays / (PARTS * rayon::current_num_threads())).clamp(FEWEST, CHUNK)
}

/// Calls `trace` for each part of a queue, `chunk` rays each, on all threads.
///
/// # Panics
/// If there are not as many results or places as rays.
pub(super) fn for_each_part<T: Sync>(
    rays: &[Ray],
    order: Order<&[AtomicU32]>,
    results: &[T],
    chunk: usize,
    trace: impl Fn(Part<'_, T>) + Sync,
) {
    assert_eq!(rays.len(), results.len(), "one result per ray");
    let starts = (0..rays.len().div_ceil(chunk)).into_par_iter().with_max_len(1).map(|part| part * chunk);
    let end = |first: usize| rays.len().min(first + chunk);
    match order {
        Order::Stored => {
            starts.for_each(|first| trace(Part::new(&rays[first..end(first)], &results[first..end(first)])))
        }
        Order::Indirect(places) => {
            assert_eq!(rays.len(), places.len(), "one place per ray");
            starts.for_each(|first| {
                let order = Order::Indirect(&places[first..]);
                trace(Part { rays, order, results, len: end(first) - first });
            });
        }
    }
}
