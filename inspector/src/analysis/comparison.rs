//! Two orders ray by ray: of the same rays, or of two recordings of one scene, whose rays belong together by
//! their paths.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use formats::metrics::quantity::OrderedRays;
use formats::traced::{Results, Traced};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

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

/// One of two orders of which the rays are compared.
#[derive(Clone, Copy)]
pub struct Side<'a> {
    /// What it is called.
    pub name: &'a str,
    /// Its rays, with its groups.
    pub rays: OrderedRays<'a>,
    /// The place of each ray.
    pub place_of_ray: &'a [u32],
    /// The layout of its keys as it was written, if there are any.
    pub layout: &'a str,
    /// Mean capsule area of its groups.
    pub mean_area: f64,
}

/// Two orders ray by ray.
#[derive(Debug)]
pub struct Comparison {
    /// How many rays differ.
    pub counts: Counts,
    /// Mean capsule areas, left and right.
    pub mean_areas: [f64; 2],
    /// A number for each ray of the left and of the right queue, if one was wanted; NaN for rays that only one of
    /// them has.
    pub values: Option<[Arc<Vec<f32>>; 2]>,
    /// Differs from that of all others.
    pub id: u64,
    /// Rays of the left and the right queue that are of one path, ascending on both sides.
    pairs: Vec<[u32; 2]>,
}

impl Comparison {
    /// Of a left and a right order, with the numbers of what differs if that is wanted.
    pub fn of(sides: &[Side<'_>; 2], difference: Option<Difference>) -> Self {
        static MADE: AtomicU64 = AtomicU64::new(0);
        let pairs = pairs(sides[0].rays.path_ids, sides[1].rays.path_ids);
        let differing = |difference, least: f32| {
            let values = pair_values(sides, &pairs, difference);
            values.into_iter().filter(|value| *value > least).count()
        };
        let counts = Counts {
            rays: sides.map(|side| side.place_of_ray.len()),
            matched: pairs.len(),
            hits: differing(Difference::Hit, 0.0),
            distances: differing(Difference::Distance, LOWEST_DISTANCE),
            keys: comparable_keys(sides).map(|()| differing(Difference::Key, 0.0)),
            places: differing(Difference::Displacement, 0.0),
        };
        let values = difference.map(|difference| {
            let of_pairs = pair_values(sides, &pairs, difference);
            [0, 1].map(|side| {
                let mut values = vec![f32::NAN; counts.rays[side]];
                for (pair, value) in pairs.iter().zip(&of_pairs) {
                    values[pair[side] as usize] = *value;
                }
                Arc::new(values)
            })
        });
        let id = MADE.fetch_add(1, Ordering::Relaxed);
        Self { counts, mean_areas: sides.map(|side| side.mean_area), values, id, pairs }
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
}

/// How far the rays of each pair differ; NaN where that is not known.
fn pair_values(sides: &[Side<'_>; 2], pairs: &[[u32; 2]], difference: Difference) -> Vec<f32> {
    let has_keys = comparable_keys(sides).is_ok();
    let longest = sides[0].place_of_ray.len().max(sides[1].place_of_ray.len()) as f64;
    let value = |pair: &[u32; 2]| {
        let rays = pair.map(|ray| ray as usize);
        let each = [0, 1].map(|side| (sides[side].rays, rays[side], sides[side].place_of_ray[rays[side]]));
        let differs = |is_so: bool| f32::from(u8::from(is_so));
        match difference {
            Difference::Displacement => {
                let [from, to] = each.map(|(.., place)| f64::from(place));
                ((to - from).abs() / longest) as f32
            }
            Difference::CapsuleArea => {
                let [left, right] =
                    each.map(|(of, _, place)| of.groups[place as usize / of.group_width].area.max(1e-12));
                (right / left).log2() as f32
            }
            Difference::Hit => {
                let [left, right] = each.map(|(of, ray, _)| found(of.traced, ray).0);
                differs(left != right)
            }
            Difference::Distance => {
                let [left, right] = each.map(|(of, ray, _)| found(of.traced, ray).1);
                relative(left, right)
            }
            Difference::Key if has_keys => {
                let [left, right] = each.map(|(of, ray, _)| of.keys.map(|(keys, _)| keys.at(ray)));
                differs(left != right)
            }
            Difference::Key => f32::NAN,
        }
    };
    pairs.par_iter().with_min_len(RAYS_PER_TASK).map(value).collect()
}

/// What a ray found, `u32::MAX` for nothing, and how far away, its own units.
fn found(traced: &Traced, ray: usize) -> (u32, f32) {
    match traced.results() {
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
fn comparable_keys(sides: &[Side<'_>; 2]) -> Result<(), String> {
    let [(_, left), (_, right)] = [sides[0].rays.keys?, sides[1].rays.keys?];
    let [first, second] = sides;
    if (first.layout, left) == (second.layout, right) {
        return Ok(());
    }
    Err(format!("keys of {} and {} are made in other ways", first.name, second.name))
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
