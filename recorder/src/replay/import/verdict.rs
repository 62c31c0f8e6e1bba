//! Hits that came with imported rays, judged by the oracle.

use std::fmt;

use formats::manifest::{Check, IMPORTED_HITS, QueueId};
use formats::ray::{Hit, Ray};
use rayon::prelude::*;
use scenes::Scene;

use super::queues::{Queue, Results};
use crate::oracle::{Judgement, Oracle, Verdict};

/// Most rays of a queue that are judged, spread evenly over it: the oracle takes microseconds for each.
const JUDGED_MAX: usize = 1 << 16;

/// How many rays were judged, and how.
#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    judged: usize,
    wrong_triangle: usize,
    missed: usize,
    false_hit: usize,
    /// The right triangle or occluder, but farther off than single precision explains.
    off: usize,
    /// Most that a distance is off, in units in the last place of the largest coordinate.
    most_ulps: f64,
    /// The first queue with a wrong one, and which ray that is.
    first_wrong: Option<(QueueId, usize)>,
}

impl Tally {
    fn of(queue: QueueId, ray: usize, judgement: Judgement) -> Self {
        let is = |verdict| usize::from(judgement.verdict == verdict);
        let off = judgement.t.filter(|t| t.ulps > t.tolerance_ulps);
        let tally = Self {
            judged: 1,
            wrong_triangle: is(Verdict::WrongTriangle),
            missed: is(Verdict::Missed),
            false_hit: is(Verdict::FalseHit),
            off: usize::from(off.is_some()),
            most_ulps: judgement.t.map_or(0.0, |t| t.ulps),
            first_wrong: None,
        };
        Self { first_wrong: (tally.wrong() > 0).then_some((queue, ray)), ..tally }
    }

    fn plus(self, other: Self) -> Self {
        Self {
            judged: self.judged + other.judged,
            wrong_triangle: self.wrong_triangle + other.wrong_triangle,
            missed: self.missed + other.missed,
            false_hit: self.false_hit + other.false_hit,
            off: self.off + other.off,
            most_ulps: self.most_ulps.max(other.most_ulps),
            first_wrong: [self.first_wrong, other.first_wrong].into_iter().flatten().min(),
        }
    }

    fn wrong(&self) -> usize {
        self.wrong_triangle + self.missed + self.false_hit + self.off
    }
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} of {} judged are right", self.judged - self.wrong(), self.judged)?;
        for (count, what) in [
            (self.missed, "missed what is in the way"),
            (self.false_hit, "hit what is not there"),
            (self.wrong_triangle, "hit another triangle than the first"),
            (self.off, "are at another distance"),
        ] {
            if count > 0 {
                write!(f, ", {count} {what}")?;
            }
        }
        if let Some((QueueId { bounce, kind, .. }, ray)) = self.first_wrong {
            write!(f, "; the first wrong one that was judged is ray {ray} of bounce {bounce}, {kind}")?;
        }
        write!(f, "; distances are off by up to {:.1} ulps of the largest coordinate", self.most_ulps)
    }
}

/// What the oracle finds of all hits that came; nothing if none came.
pub(super) fn judge(scene: &Scene, queues: &[Queue]) -> Option<Check> {
    let with_results: Vec<(&Queue, &Results)> =
        queues.iter().filter_map(|queue| Some((queue, queue.results.as_ref()?))).collect();
    if with_results.is_empty() {
        return None;
    }
    let oracle = Oracle::new(scene);
    let triangles = scene.triangles.len();
    let mut tally = Tally::default();
    let mut rays = 0;
    for (queue, results) in with_results {
        let (count, judged) = (queue.rays.len(), queue.rays.len().min(JUDGED_MAX));
        let judgements = (0..judged).into_par_iter().map(|number| {
            let at = (number as u64 * count as u64 / judged as u64) as usize;
            let judgement = match results {
                Results::Hits(hits) => judge_hit(&oracle, &queue.rays[at], &hits[at], triangles),
                Results::Distances(distances) => judge_distance(&oracle, &queue.rays[at], distances[at]),
            };
            Tally::of(queue.id, at, judgement)
        });
        tally = tally.plus(judgements.reduce(Tally::default, Tally::plus));
        rays += count;
    }
    let sampled = if tally.judged < rays { format!(" (spread over {rays} rays)") } else { String::new() };
    let outcome = if tally.wrong() == 0 { "passed" } else { "failed" };
    Some(Check {
        name: IMPORTED_HITS.to_owned(),
        outcome: outcome.to_owned(),
        detail: format!("{tally}{sampled}"),
    })
}

const NOTHING_THERE: Judgement = Judgement { verdict: Verdict::FalseHit, t: None };

fn judge_hit(oracle: &Oracle, ray: &Ray, hit: &Hit, triangles: usize) -> Judgement {
    let is_there = !hit.is_hit() || ((hit.triangle as usize) < triangles && hit.t.is_finite());
    if is_there { oracle.judge(ray, hit) } else { NOTHING_THERE }
}

fn judge_distance(oracle: &Oracle, ray: &Ray, distance: f32) -> Judgement {
    if distance.is_nan() { NOTHING_THERE } else { oracle.judge_occlusion(ray, distance) }
}
