//! What a recording has of each ray of a queue, side by side.

use formats::pages::room_on_huge_pages;
use formats::ray::{Ray, Work};
use formats::traced::Results;
use rayon::prelude::*;

use crate::model::Queue;

/// In place of an index: there is none.
pub(super) const NONE: u32 = u32::MAX;

/// All of one ray, in a cache line: orders read rays at random, and wait once for each and not once for each array.
#[derive(Clone, Copy)]
#[repr(align(64))]
pub(super) struct Found {
    /// The ray.
    pub(super) ray: Ray,
    /// Distance to what was hit, world units; not finite for none.
    pub(super) t: f32,
    /// Traced length, unit lengths.
    pub(super) length: f32,
    /// Triangle that was hit, or [`NONE`].
    pub(super) triangle: u32,
    /// Its material, or [`NONE`].
    pub(super) material: u32,
    /// Pixel.
    pub(super) path: u32,
    /// Light of a shadow ray; 0 for others.
    pub(super) light: u32,
    /// Nodes and triangles; 0 where not recorded.
    pub(super) work: Work,
}

/// All rays of a queue in canonical order, by all threads.
pub(super) fn all(queue: &Queue) -> Vec<Found> {
    let mut rays = room_on_huge_pages(queue.len());
    (0..queue.len()).into_par_iter().map(|ray| found(queue, ray)).collect_into_vec(&mut rays);
    rays
}

fn found(queue: &Queue, ray: usize) -> Found {
    let (t, triangle) = match queue.traced.results() {
        Results::Hits(hits) if hits[ray].is_hit() => (hits[ray].t, hits[ray].triangle),
        Results::Hits(_) => (f32::INFINITY, NONE),
        Results::Distances(distances) => (distances[ray], NONE),
    };
    let material = queue.materials.as_ref().ok().and_then(|materials| materials.get(triangle as usize));
    Found {
        ray: queue.traced.rays()[ray],
        t,
        length: queue.lengths[ray],
        triangle,
        material: material.copied().unwrap_or(NONE),
        path: queue.path_ids[ray],
        light: queue.lights.as_ref().map_or(0, |lights| lights[ray]),
        work: queue.work.as_ref().map_or(Work::default(), |work| work[ray]),
    }
}
