//! The groups of an order: capsule, direction spread and lane utilisation of each.

use std::ops::Range;

use formats::metrics::group::Group;
use formats::metrics::order::Places;
use rayon::prelude::*;

use super::queue::Queue;

/// Groups that a thread takes at a time.
const GROUPS_PER_TASK: usize = 64;

/// The groups of an order.
#[derive(Debug)]
pub struct Groups {
    /// Rays of a group.
    pub width: usize,
    /// The groups, in order; the last may be shorter.
    pub groups: Vec<Group>,
    /// Mean capsule area, weighted by rays; 0 for no groups.
    pub mean_area: f64,
    rays: usize,
}

impl Groups {
    /// Of `width` consecutive rays of an order of a queue.
    pub(super) fn of(queue: &Queue, order: &Places, width: usize) -> Self {
        let rays = order.len();
        let of = |at: usize| group(queue, order, places_of(at, width, rays));
        let groups = (0..rays.div_ceil(width)).into_par_iter().with_min_len(GROUPS_PER_TASK);
        let groups: Vec<Group> = groups.filter_map(of).collect();
        let weighted = |group: &Group| group.area * f64::from(group.rays);
        let mean_area = groups.iter().map(weighted).sum::<f64>() / rays.max(1) as f64;
        Self { width, groups, mean_area, rays }
    }

    /// The places of a group.
    pub fn places(&self, group: usize) -> Range<usize> {
        places_of(group, self.width, self.rays)
    }

    /// The groups with the largest capsules, the worst first.
    pub fn worst(&self, wanted: usize) -> Vec<usize> {
        let worse =
            |&a: &usize, &b: &usize| self.groups[b].area.total_cmp(&self.groups[a].area).then(a.cmp(&b));
        let mut order: Vec<usize> = (0..self.groups.len()).collect();
        if wanted < order.len() {
            order.select_nth_unstable_by(wanted, worse);
            order.truncate(wanted);
        }
        order.sort_by(worse);
        order
    }
}

/// The places of a group of `width` rays.
pub(super) fn places_of(group: usize, width: usize, rays: usize) -> Range<usize> {
    let first = group.saturating_mul(width).min(rays);
    first..(first + width).min(rays)
}

/// The group at these places of an order; `None` for none.
pub(super) fn group(queue: &Queue, order: &Places, places: Range<usize>) -> Option<Group> {
    let work = queue.work.as_deref().ok();
    Group::of(&queue.traced, &queue.lengths, work, places.map(|place| order.ray(place)))
}
