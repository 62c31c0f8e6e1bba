//! The triangles whose rays cost most.

use std::collections::HashMap;

use formats::metrics::lanes::work_of;
use formats::ray::{Hit, Work};

/// A triangle, and what the rays cost that end at it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CostlyTriangle {
    /// The triangle; `None` for the rays that meet none.
    pub triangle: Option<u32>,
    /// How many rays.
    pub rays: u64,
    /// Nodes visited and triangles tested by all of them.
    pub steps: u64,
    /// Canonical index of the ray that costs most.
    pub costliest_ray: usize,
}

/// The triangles whose rays cost most together, most first, of equal ones the lowest; and the steps of all rays.
pub fn costliest(hits: &[Hit], work: &[Work], most: usize) -> (Vec<CostlyTriangle>, u64) {
    let mut found: HashMap<u32, CostlyTriangle> = HashMap::new();
    for (ray, (hit, of_ray)) in hits.iter().zip(work).enumerate() {
        let triangle = Some(hit.triangle).filter(|_| hit.is_hit());
        let first = CostlyTriangle { triangle, rays: 0, steps: 0, costliest_ray: ray };
        let known = found.entry(hit.triangle).or_insert(first);
        known.rays += 1;
        known.steps += work_of(of_ray);
        if work_of(of_ray) > work_of(&work[known.costliest_ray]) {
            known.costliest_ray = ray;
        }
    }
    let all = found.values().map(|known| known.steps).sum();
    let mut found: Vec<CostlyTriangle> = found.into_values().collect();
    found.sort_by_key(|known| (std::cmp::Reverse(known.steps), known.triangle));
    found.truncate(most);
    (found, all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triangles_are_ranked_by_what_their_rays_cost_together() {
        let hit = |triangle| Hit { t: 1.0, triangle, u: 0.0, v: 0.0 };
        let hits = [hit(4), hit(2), Hit::MISS, hit(4), hit(7)];
        let work =
            [(3, 1), (9, 1), (1, 0), (5, 4), (6, 4)].map(|(nodes, triangles)| Work { nodes, triangles });
        let (found, all) = costliest(&hits, &work, 3);
        let costly =
            |triangle, rays, steps, costliest_ray| CostlyTriangle { triangle, rays, steps, costliest_ray };
        assert_eq!(found, [costly(Some(4), 2, 13, 3), costly(Some(2), 1, 10, 1), costly(Some(7), 1, 10, 4)]);
        assert_eq!(all, 34);
        assert_eq!(costliest(&hits, &work, 9).0[3], costly(None, 1, 1, 2));
    }
}
