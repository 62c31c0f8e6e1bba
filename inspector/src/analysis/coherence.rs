//! Capsules, direction spread and lane utilisation of an order (KEYS, "Coherence of an order").
//!
//! Streamed: places of the order are taken in chunks whose boundaries are fixed, so that sums are added
//! in the same order whatever the number of threads.

use formats::metrics::capsule::{Capsule, Segment};
use formats::metrics::lanes::{LaneUse, WIDTHS, work_of};
use formats::metrics::spread::direction_spread;
use formats::permutation::check_bijection;
use formats::ray::Work;
use formats::reader::Mapped;
use formats::traced::Traced;
use rayon::prelude::*;
use serde::Serialize;

/// Places that a thread takes at a time: a multiple of every group width and of every lane width.
const CHUNK: usize = 8192;
/// Steps of [`Coherence::area_quantiles`].
const QUANTILE_STEPS: usize = 100;

/// How coherent the groups of an order are.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Coherence {
    /// Groups; the last one may be shorter.
    pub groups: u64,
    /// Mean capsule area, weighted by rays, in unit space.
    pub mean_capsule_area: f64,
    /// Capsule areas below which 0 %, 1 %, … 100 % of the rays are.
    pub area_quantiles: Vec<f64>,
    /// Mean direction spread, weighted by rays, 0 to 1.
    pub mean_direction_spread: f64,
}

/// Lane utilisation for a width. A model.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LaneUtilisation {
    /// Lanes that wait for each other.
    pub width: usize,
    /// Share of their time in which they work, 0 to 1.
    pub utilisation: f64,
}

/// The places of an order, whose indices are all in range.
#[derive(Debug)]
pub enum Places {
    /// Canonical order of this many rays.
    Canonical(usize),
    /// A method's order.
    Sorted(Mapped<u32>),
    /// An order that was made here.
    Made(Vec<u32>),
}

impl Places {
    /// Of a permutation of `rays` rays.
    ///
    /// # Errors
    /// If it does not hold each ray once.
    pub fn sorted(permutation: Mapped<u32>, rays: usize) -> Result<Self, String> {
        check_bijection(&permutation, rays)
            .map_err(|error| format!("{error}; `inspector verify` says what is wrong"))?;
        Ok(Self::Sorted(permutation))
    }

    /// Rays of the order.
    pub fn len(&self) -> usize {
        match self {
            Self::Canonical(rays) => *rays,
            Self::Sorted(permutation) => permutation.len(),
            Self::Made(permutation) => permutation.len(),
        }
    }

    /// Whether it has no rays.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Canonical index of the ray at a place.
    ///
    /// # Panics
    /// If there is no such place.
    pub fn ray(&self, place: usize) -> usize {
        match self {
            Self::Canonical(rays) => {
                assert!(place < *rays, "place {place} of {rays}");
                place
            }
            Self::Sorted(permutation) => permutation[place] as usize,
            Self::Made(permutation) => permutation[place] as usize,
        }
    }

    /// What `of` makes of each chunk of places, given the canonical indices there, in order.
    fn chunks<T: Send>(&self, of: impl Fn(&[u32]) -> T + Sync) -> Vec<T> {
        let chunk = |at: usize| {
            let (first, end) = (at * CHUNK, self.len().min((at + 1) * CHUNK));
            match self {
                Self::Canonical(_) => of(&(first as u32..end as u32).collect::<Vec<_>>()),
                Self::Sorted(permutation) => of(&permutation[first..end]),
                Self::Made(permutation) => of(&permutation[first..end]),
            }
        };
        (0..self.len().div_ceil(CHUNK)).into_par_iter().map(chunk).collect()
    }
}

/// One group's capsule area and direction spread, and its rays.
struct Group {
    area: f64,
    spread: f64,
    rays: u32,
}

/// The coherence of an order in groups of `width` rays; `lengths` are the traced lengths of all rays in
/// canonical order. `None` for no rays.
pub fn coherence(traced: &Traced, lengths: &[f32], places: &Places, width: usize) -> Option<Coherence> {
    let (unit, rays) = (traced.unit(), traced.rays());
    let of_chunk = |indices: &[u32]| -> Vec<Group> {
        let mut segments = Vec::with_capacity(width);
        let of_group = |group: &[u32]| {
            let indices = group.iter().map(|&index| index as usize);
            segments.clear();
            segments.extend(indices.clone().map(|index| Segment::of(unit, &rays[index], lengths[index])));
            let area = Capsule::around(&segments)?.area();
            let spread = direction_spread(indices.map(|index| rays[index].direction))?;
            Some(Group { area, spread, rays: group.len() as u32 })
        };
        indices.chunks(width).filter_map(of_group).collect()
    };
    let mut groups: Vec<Group> = places.chunks(of_chunk).into_iter().flatten().collect();
    if groups.is_empty() {
        return None;
    }
    let mean = |of: fn(&Group) -> f64| {
        groups.iter().map(|group| of(group) * f64::from(group.rays)).sum::<f64>() / places.len() as f64
    };
    let (mean_capsule_area, mean_direction_spread) = (mean(|group| group.area), mean(|group| group.spread));
    groups.sort_by(|a, b| a.area.total_cmp(&b.area));
    Some(Coherence {
        groups: groups.len() as u64,
        mean_capsule_area,
        area_quantiles: quantiles(&groups, places.len()),
        mean_direction_spread,
    })
}

/// The smallest area that so many hundredths of the rays do not exceed; `groups` ascend.
fn quantiles(groups: &[Group], rays: usize) -> Vec<f64> {
    let mut quantiles = Vec::with_capacity(QUANTILE_STEPS + 1);
    let mut reached = 0u64;
    for group in groups {
        reached += u64::from(group.rays);
        while quantiles.len() <= QUANTILE_STEPS
            && reached * QUANTILE_STEPS as u64 >= quantiles.len() as u64 * rays as u64
        {
            quantiles.push(group.area);
        }
    }
    quantiles
}

/// Lane utilisation of an order for every width; none if no ray did any work.
pub fn lanes(work: &[Work], places: &Places) -> Vec<LaneUtilisation> {
    let of_chunk = |indices: &[u32]| {
        let works: Vec<u64> = indices.iter().map(|&index| work_of(&work[index as usize])).collect();
        WIDTHS.map(|width| {
            let mut lanes = LaneUse::new(width);
            lanes.add(&works);
            lanes
        })
    };
    let mut lanes = WIDTHS.map(LaneUse::new);
    for chunk in places.chunks(of_chunk) {
        lanes.iter_mut().zip(&chunk).for_each(|(lanes, chunk)| lanes.merge(chunk));
    }
    let utilisation =
        |lanes: &LaneUse| Some(LaneUtilisation { width: lanes.width, utilisation: lanes.utilisation()? });
    lanes.iter().filter_map(utilisation).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chunks_are_whole_groups() {
        for width in WIDTHS.into_iter().chain([32, 64, 128]) {
            assert_eq!(CHUNK % width, 0);
        }
        let places = Places::Canonical(2 * CHUNK + 5);
        let lengths = places.chunks(<[u32]>::len);
        assert_eq!(lengths, [CHUNK, CHUNK, 5]);
        assert_eq!(places.chunks(|indices| indices[0]), [0, CHUNK as u32, 2 * CHUNK as u32]);
    }

    #[test]
    fn quantiles_are_weighted_by_rays() {
        let group = |area, rays| Group { area, spread: 0.0, rays };
        let found = quantiles(&[group(1.0, 50), group(2.0, 25), group(9.0, 25)], 100);
        assert_eq!(found.len(), 101);
        assert_eq!(
            [found[0], found[50], found[51], found[75], found[76], found[100]],
            [1.0, 1.0, 2.0, 2.0, 9.0, 9.0]
        );
    }

    #[test]
    fn lanes_follow_the_order() {
        let work = |nodes| Work { nodes, triangles: 0 };
        let works: Vec<Work> = (0..16).map(|i| work(if i % 2 == 0 { 4 } else { 2 })).collect();
        let found = lanes(&works, &Places::Canonical(16));
        assert_eq!(found[0], LaneUtilisation { width: 8, utilisation: 0.75 });
        assert_eq!(found[1], LaneUtilisation { width: 32, utilisation: 48.0 / 128.0 });
        assert_eq!(lanes(&[work(0)], &Places::Canonical(1)), []);
    }
}
