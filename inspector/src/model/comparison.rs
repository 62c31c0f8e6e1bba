//! Two orders ray by ray: of the same rays, or of two recordings of one scene, whose rays belong together by
//! their paths.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use formats::traced::Results;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::order::Order;
use super::queue::Queue;
use crate::analysis::GroupWidth;

/// Rays that a thread takes at a time.
const RAYS_PER_TASK: usize = 8192;

/// What of a ray may differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Difference {
    /// Its place.
    Displacement,
    /// The capsule of its group.
    CapsuleArea,
    /// What it hit.
    Hit,
    /// How far away that is.
    Distance,
    /// Its key.
    Key,
}

impl Difference {
    /// All of them: name in lists and sessions, and what the colour bar says.
    pub const ALL: [(Self, &'static str, &'static str); 5] = [
        (Self::Displacement, "displacement", "places from A to B, part of all"),
        (Self::CapsuleArea, "capsule-area", "capsule area of the group, B over A"),
        (Self::Hit, "hit", "1 where another surface was hit"),
        (Self::Distance, "distance", "relative difference of the hit's distance"),
        (Self::Key, "key", "1 where the key is another"),
    ];

    /// Name in lists and sessions.
    pub fn name(self) -> &'static str {
        Self::ALL[self as usize].1
    }

    /// The base, where it is a logarithm.
    pub fn logarithm(self) -> Option<f32> {
        match self {
            Self::CapsuleArea => Some(2.0),
            Self::Distance => Some(10.0),
            Self::Displacement | Self::Hit | Self::Key => None,
        }
    }

    /// What the colour bar says.
    pub fn title(self) -> &'static str {
        Self::ALL[self as usize].2
    }
}

/// Of equal distances, in place of the logarithm of 0.
pub const LOWEST_DISTANCE: f32 = -8.0;

/// How many rays differ.
#[derive(Clone, Debug, PartialEq)]
pub struct Counts {
    /// Rays on the left and on the right.
    pub rays: [usize; 2],
    /// Rays whose path lives on both sides; those below are of these.
    pub matched: usize,
    /// Rays that hit something else; a shadow ray, whether it is occluded.
    pub hits: usize,
    /// Rays whose hit is at another distance.
    pub distances: usize,
    /// Rays with another key, or why keys cannot be compared.
    pub keys: Result<usize, String>,
    /// Rays at another place.
    pub places: usize,
}

/// A comparison with the numbers of its rays.
pub struct Compared {
    /// The comparison.
    pub comparison: Comparison,
    /// A number for each ray, left and right, if one was wanted.
    pub values: Option<[Arc<Vec<f32>>; 2]>,
    /// Differs from that of all others.
    pub id: u64,
}

impl Compared {
    /// Of a left and a right order, in groups of this width.
    pub fn of([left, right]: &[Arc<Order>; 2], width: GroupWidth, difference: Option<Difference>) -> Self {
        static MADE: AtomicU64 = AtomicU64::new(0);
        let comparison = Comparison::of(left, right, width);
        let values = difference.map(|difference| comparison.values(difference).map(Arc::new));
        Self { comparison, values, id: MADE.fetch_add(1, Ordering::Relaxed) }
    }
}

/// Two orders ray by ray.
#[derive(Debug)]
pub struct Comparison {
    /// How many rays differ.
    pub counts: Counts,
    /// Mean capsule areas, left and right.
    pub mean_areas: [f64; 2],
    orders: [Arc<Order>; 2],
    width: GroupWidth,
    /// Rays of the left and the right queue that are of one path, ascending on both sides.
    pairs: Vec<[u32; 2]>,
}

impl Comparison {
    /// Of a left and a right order, in groups of this width.
    pub fn of(left: &Arc<Order>, right: &Arc<Order>, width: GroupWidth) -> Self {
        let orders = [left.clone(), right.clone()];
        let pairs = pairs(&left.queue.path_ids, &right.queue.path_ids);
        let mut found = Self {
            counts: Counts {
                rays: [left.len(), right.len()],
                matched: pairs.len(),
                hits: 0,
                distances: 0,
                keys: comparable_keys(left, right).map(|()| 0),
                places: 0,
            },
            mean_areas: [left, right].map(|order| order.groups(width).mean_area()),
            orders,
            width,
            pairs,
        };
        let count = |difference| found.pair_values(difference).filter(|value| *value != 0.0).count();
        let [hits, places] = [Difference::Hit, Difference::Displacement].map(count);
        let distances =
            found.pair_values(Difference::Distance).filter(|value| *value > LOWEST_DISTANCE).count();
        let keys = found.counts.keys.clone().map(|_| count(Difference::Key));
        found.counts = Counts { hits, places, distances, keys, ..found.counts };
        found
    }

    /// The ray of the left queue that is of one path with a ray of the right one.
    pub fn left_of(&self, right: usize) -> Option<usize> {
        let at = self.pairs.binary_search_by_key(&right, |pair| pair[1] as usize).ok()?;
        Some(self.pairs[at][0] as usize)
    }

    /// The ray of the right queue that is of one path with a ray of the left one.
    pub fn right_of(&self, left: usize) -> Option<usize> {
        let at = self.pairs.binary_search_by_key(&left, |pair| pair[0] as usize).ok()?;
        Some(self.pairs[at][1] as usize)
    }

    /// A number for each ray of the left and of the right queue; NaN for rays that only one of them has.
    pub fn values(&self, difference: Difference) -> [Vec<f32>; 2] {
        let of_pairs: Vec<f32> = self.pair_values(difference).collect();
        [0, 1].map(|side| {
            let mut values = vec![f32::NAN; self.orders[side].len()];
            for (pair, value) in self.pairs.iter().zip(&of_pairs) {
                values[pair[side] as usize] = *value;
            }
            values
        })
    }

    fn pair_values(&self, difference: Difference) -> impl Iterator<Item = f32> + use<> {
        let value = |pair: &[u32; 2]| self.value(difference, pair.map(|ray| ray as usize));
        let values: Vec<f32> = self.pairs.par_iter().with_min_len(RAYS_PER_TASK).map(value).collect();
        values.into_iter()
    }

    fn value(&self, difference: Difference, rays: [usize; 2]) -> f32 {
        let [left, right] = &self.orders;
        let places = || [left.place_of_ray()[rays[0]] as f64, right.place_of_ray()[rays[1]] as f64];
        match difference {
            Difference::Displacement => {
                let [from, to] = places();
                ((to - from).abs() / left.len().max(right.len()) as f64) as f32
            }
            Difference::CapsuleArea => {
                let area = |order: &Order, ray: usize| {
                    let groups = order.groups(self.width);
                    groups.groups[order.place_of_ray()[ray] as usize / groups.width].area.max(1e-12)
                };
                (area(right, rays[1]) / area(left, rays[0])).log2() as f32
            }
            Difference::Hit => {
                let [left, right] = [found(&left.queue, rays[0]), found(&right.queue, rays[1])];
                f32::from(u8::from(left.0 != right.0))
            }
            Difference::Distance => {
                let [left, right] = [found(&left.queue, rays[0]).1, found(&right.queue, rays[1]).1];
                relative(left, right)
            }
            Difference::Key => match (&left.keys, &right.keys, &self.counts.keys) {
                (Ok((left, _)), Ok((right, _)), Ok(_)) => {
                    f32::from(u8::from(left.at(rays[0]) != right.at(rays[1])))
                }
                _ => f32::NAN,
            },
        }
    }
}

/// What a ray found, `u32::MAX` for nothing, and how far away, its own units.
fn found(queue: &Queue, ray: usize) -> (u32, f32) {
    match queue.traced.results() {
        Results::Hits(hits) if hits[ray].is_hit() => (hits[ray].triangle, hits[ray].t),
        Results::Hits(_) => (u32::MAX, f32::INFINITY),
        Results::Distances(distances) if distances[ray].is_finite() => (0, distances[ray]),
        Results::Distances(_) => (u32::MAX, f32::INFINITY),
    }
}

/// Logarithm of the difference of two lengths over the larger one.
fn relative(left: f32, right: f32) -> f32 {
    if left == right {
        return LOWEST_DISTANCE;
    }
    if !left.is_finite() || !right.is_finite() {
        return 0.0;
    }
    let part = (left - right).abs() / left.abs().max(right.abs());
    // Above that of equal ones, however small the difference.
    part.log10().clamp(LOWEST_DISTANCE + 0.1, 0.0)
}

/// Keys say the same only if they are made in the same way.
fn comparable_keys(left: &Order, right: &Order) -> Result<(), String> {
    let (_, first) = left.keys.as_ref().map_err(String::clone)?;
    let (_, second) = right.keys.as_ref().map_err(String::clone)?;
    if (&first.text, first.key_bits) == (&second.text, second.key_bits) {
        return Ok(());
    }
    Err(format!("keys of {} and {} are made in other ways", left.method, right.method))
}

fn pairs(left: &[u32], right: &[u32]) -> Vec<[u32; 2]> {
    let (mut found, mut at) = (Vec::with_capacity(left.len().min(right.len())), 0);
    for (ray, path) in left.iter().enumerate() {
        while right.get(at).is_some_and(|other| other < path) {
            at += 1;
        }
        if right.get(at) == Some(path) {
            found.push([ray as u32, at as u32]);
            at += 1;
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_that_live_on_both_sides_are_found() {
        assert_eq!(pairs(&[1, 3, 4, 9], &[0, 3, 5, 9, 11]), [[1, 1], [3, 3]]);
        assert_eq!(pairs(&[], &[1]), Vec::<[u32; 2]>::new());
        let all: Vec<u32> = (0..100).collect();
        assert!(pairs(&all, &all).iter().all(|[left, right]| left == right));
    }

    #[test]
    fn the_smallest_difference_of_distances_is_one() {
        assert_eq!(relative(2.0, 2.0), LOWEST_DISTANCE);
        assert!(relative(1.0, 1.0f32.next_up()) > LOWEST_DISTANCE);
        assert_eq!(
            (relative(1.0, f32::INFINITY), relative(f32::INFINITY, f32::INFINITY)),
            (0.0, LOWEST_DISTANCE)
        );
        assert!((relative(1.0, 0.9) + 1.0).abs() < 1e-3);
    }
}
