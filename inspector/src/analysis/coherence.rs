//! Capsules, direction spread and lane utilisation of an order (docs/keys.md, "Coherence of an order").
//!
//! Streamed: places of the order are taken in chunks whose boundaries are fixed, so that sums are added
//! in the same order for any number of threads.

use formats::metrics::group::Group;
use formats::metrics::lanes::{LaneUse, WIDTHS, work_of};
use formats::metrics::order::Places;
use formats::ray::Work;
use formats::traced::Traced;
use serde::{Deserialize, Serialize};

/// Steps of [`Coherence::area_quantiles`].
const QUANTILE_STEPS: usize = 100;

/// How coherent the groups of an order are.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LaneUtilisation {
    /// Lanes that wait for each other.
    pub width: usize,
    /// Share of their time in which they work, 0 to 1.
    pub utilisation: f64,
}

/// Lanes of a warp: those that wait for each other on most GPUs.
pub const WARP: usize = 32;

/// The utilisation of a warp's lanes, 0 to 1; `None` if no ray did any work.
pub fn of_warp(lanes: &[LaneUtilisation]) -> Option<f64> {
    lanes.iter().find(|lanes| lanes.width == WARP).map(|lanes| lanes.utilisation)
}

/// The coherence of an order in groups of `width` rays; `lengths` are the traced lengths of all rays in
/// canonical order. `None` for no rays.
pub fn coherence(traced: &Traced, lengths: &[f32], places: &Places, width: usize) -> Option<Coherence> {
    let of_group =
        |group: &[u32]| Group::of(traced, lengths, None, group.iter().map(|&index| index as usize));
    let of_chunk = |indices: &[u32]| -> Vec<Group> { indices.chunks(width).filter_map(of_group).collect() };
    Coherence::of(places.chunks(of_chunk).into_iter().flatten().collect())
}

impl Coherence {
    /// Of all groups of an order, in order; `None` if there are none.
    pub fn of(mut groups: Vec<Group>) -> Option<Self> {
        if groups.is_empty() {
            return None;
        }
        let rays: usize = groups.iter().map(|group| group.rays as usize).sum();
        let mean = |of: fn(&Group) -> f64| {
            groups.iter().map(|group| of(group) * f64::from(group.rays)).sum::<f64>() / rays as f64
        };
        let mean_capsule_area = mean(|group| group.area);
        let mean_direction_spread = mean(|group| group.spread);
        groups.sort_by(|a, b| a.area.total_cmp(&b.area));
        Some(Self {
            groups: groups.len() as u64,
            mean_capsule_area,
            area_quantiles: quantiles(&groups, rays),
            mean_direction_spread,
        })
    }
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
        let mut lanes = Lanes::default();
        lanes.add(indices.iter().map(|&index| &work[index as usize]));
        lanes
    };
    let mut lanes = Lanes::default();
    places.chunks(of_chunk).iter().for_each(|chunk| lanes.merge(chunk));
    lanes.utilisation()
}

/// Lane use for every width.
#[derive(Debug)]
pub struct Lanes([LaneUse; WIDTHS.len()]);

impl Default for Lanes {
    fn default() -> Self {
        Self(WIDTHS.map(LaneUse::new))
    }
}

impl Lanes {
    /// Adds consecutive rays of an order: whole groups of every width, unless they are the last.
    pub fn add<'w>(&mut self, work: impl Iterator<Item = &'w Work>) {
        let works: Vec<u64> = work.map(work_of).collect();
        self.0.iter_mut().for_each(|lanes| lanes.add(&works));
    }

    fn merge(&mut self, other: &Self) {
        self.0.iter_mut().zip(&other.0).for_each(|(lanes, other)| lanes.merge(other));
    }

    /// The utilisation for every width; none if no ray did any work.
    pub fn utilisation(&self) -> Vec<LaneUtilisation> {
        let of =
            |lanes: &LaneUse| Some(LaneUtilisation { width: lanes.width, utilisation: lanes.utilisation()? });
        self.0.iter().filter_map(of).collect()
    }
}

#[cfg(test)]
mod tests {
    use formats::metrics::capsule::Capsule;

    use super::*;

    #[test]
    fn quantiles_are_weighted_by_rays() {
        let capsule =
            Capsule { origin_centre: [0.0; 3], origin_radius: 0.0, end_centre: [0.0; 3], end_radius: 0.0 };
        let group = |area, rays| Group { rays, capsule, area, spread: 0.0, lanes: None };
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
