//! How coherent one group of rays is.

use crate::metrics::capsule::{Capsule, Segment};
use crate::metrics::lanes::{LaneUse, work_of};
use crate::metrics::spread::direction_spread;
use crate::prefetch::prefetch_at;
use crate::ray::{Ray, Work};
use crate::traced::Traced;
use crate::unit_space::UnitSpace;

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
        let rays: Vec<(Ray, f32)> = indices.clone().map(|ray| (traced.rays()[ray], lengths[ray])).collect();
        let group = Self::around(traced.unit(), rays.iter().map(|(ray, length)| (ray, *length)))?;
        let lanes = work.and_then(|work| {
            let mut lanes = LaneUse::new(rays.len());
            lanes.add(&indices.map(|ray| work_of(&work[ray])).collect::<Vec<_>>());
            lanes.utilisation()
        });
        Some(Self { lanes, ..group })
    }

    /// Of these rays with their traced lengths, unit lengths; without lanes. `None` for no rays.
    pub fn around<'r>(unit: &UnitSpace, rays: impl Iterator<Item = (&'r Ray, f32)> + Clone) -> Option<Self> {
        let segments: Vec<Segment> =
            rays.clone().map(|(ray, length)| Segment::of(unit, ray, length)).collect();
        let capsule = Capsule::around(&segments)?;
        let spread = direction_spread(rays.map(|(ray, _)| ray.direction))?;
        Some(Self { rays: segments.len() as u32, capsule, area: capsule.area(), spread, lanes: None })
    }
}
