//! How coherent one group of rays is.

use crate::metrics::capsule::{Capsule, Segment};
use crate::metrics::lanes::{LaneUse, work_of};
use crate::metrics::spread::direction_spread;
use crate::ray::Work;
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
        let rays = traced.rays();
        let segment = |ray: usize| Segment::of(traced.unit(), &rays[ray], lengths[ray]);
        let segments: Vec<Segment> = indices.clone().map(segment).collect();
        let capsule = Capsule::around(&segments)?;
        let spread = direction_spread(indices.clone().map(|ray| rays[ray].direction))?;
        let lanes = work.and_then(|work| {
            let mut lanes = LaneUse::new(segments.len());
            lanes.add(&indices.map(|ray| work_of(&work[ray])).collect::<Vec<_>>());
            lanes.utilisation()
        });
        Some(Self { rays: segments.len() as u32, capsule, area: capsule.area(), spread, lanes })
    }
}
