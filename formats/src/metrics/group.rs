//! How coherent one group of rays is.

use crate::metrics::capsule::{Capsule, Segment};
use crate::metrics::lanes::{LaneUse, work_of};
use crate::metrics::spread::direction_spread;
use crate::prefetch::prefetch_at;
use crate::ray::{Ray, Work};
use crate::traced::Traced;

/// One group: its capsule, direction spread and lane utilisation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Group {
    /// Rays, at least 1.
    pub rays: u32,
    /// Its capsule, unit space.
    pub capsule: Capsule,
    /// Area of the capsule.
    pub area: f64,
    /// Direction spread, 0 to 1.
    pub spread: f64,
    /// Lane utilisation if the group were traced together, 0 to 1; not known without work. A model.
    pub lanes: Option<f64>,
}

impl Group {
    /// Of these rays of a queue, by canonical index; `lengths` are the traced lengths of all of its rays, unit
    /// lengths. `None` for no rays.
    ///
    /// # Panics
    /// If there is no such ray.
    pub fn of(
        traced: &Traced,
        lengths: &[f32],
        work: Option<&[Work]>,
        indices: impl Iterator<Item = usize> + Clone,
    ) -> Option<Self> {
        // Asked for, then fetched, then computed with, so that the processor waits for many of them at once.
        for ray in indices.clone() {
            prefetch_at(traced.rays(), ray);
            prefetch_at(lengths, ray);
        }
        let rays: Vec<Ray> = indices.clone().map(|ray| traced.rays()[ray]).collect();
        let lengths: Vec<f32> = indices.clone().map(|ray| lengths[ray]).collect();
        let segment = |(ray, &length)| Segment::of(traced.unit(), ray, length);
        let segments: Vec<Segment> = rays.iter().zip(&lengths).map(segment).collect();
        let capsule = Capsule::around(&segments)?;
        let spread = direction_spread(rays.iter().map(|ray| ray.direction))?;
        let lanes = work.and_then(|work| {
            let mut lanes = LaneUse::new(segments.len());
            lanes.add(&indices.map(|ray| work_of(&work[ray])).collect::<Vec<_>>());
            lanes.utilisation()
        });
        Some(Self { rays: segments.len() as u32, capsule, area: capsule.area(), spread, lanes })
    }
}
