//! Queues in main memory, and samples of them.

use anyhow::Result;
use formats::length_table::LengthCell;
use formats::manifest::QueueId;
use formats::ray::{Kind, Ray};

use crate::backends::{Array, Backend, Queue, RecordedRays, collected};

/// A queue in main memory.
pub(super) struct Copied {
    pub(super) id: QueueId,
    pub(super) rays: Vec<Ray>,
    path_ids: Vec<u32>,
    lights: Vec<u32>,
}

impl Copied {
    pub(super) fn of<B: Backend>(backend: &mut B, queue: &B::Rays) -> Result<Self> {
        let lights = match queue.id().kind {
            Kind::Closest => Vec::new(),
            Kind::Shadow => collected(backend, Array::Lights(queue))?,
        };
        let rays = collected(backend, Array::Rays(queue))?;
        let path_ids = collected(backend, Array::PathIds(queue))?;
        Ok(Self { id: queue.id(), rays, path_ids, lights })
    }

    /// The same queue with a length table, for another backend.
    pub(super) fn queue<'a>(&'a self, lengths: Option<&'a [LengthCell]>) -> RecordedRays<'a> {
        let Self { id, rays, path_ids, lights } = self;
        RecordedRays { id: *id, rays, path_ids, lights, lengths }
    }
}

/// `wanted` indices below `count`, one from each of as many equal strata; all of them if there are fewer.
pub(super) fn strata(count: usize, wanted: usize) -> impl Iterator<Item = usize> {
    let taken = wanted.min(count);
    (0..taken).map(move |at| (at as u64 * count as u64 / taken as u64) as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strata_are_spread_over_all_and_hold_each_index_at_most_once() {
        assert_eq!(strata(3, 10).collect::<Vec<_>>(), [0, 1, 2]);
        assert_eq!(strata(0, 10).count(), 0);
        let taken: Vec<usize> = strata(1000, 7).collect();
        assert_eq!(taken.len(), 7);
        assert!(taken.windows(2).all(|pair| (142..=143).contains(&(pair[1] - pair[0]))), "{taken:?}");
    }
}
