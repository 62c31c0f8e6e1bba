//! Whether the rays of a queue can be traced: asked of recorded and imported rays before any kernel
//! runs, since kernels trust indices and counts. `verify` asks the same of every ray.

use rayon::prelude::*;

use crate::manifest::{Header, QueueArray, QueueId, Source};
use crate::ray::{Kind, ORIGIN_LIMIT, Ray};
use crate::text::counted;

/// How far the length of a unit vector may be from 1.
const UNIT_TOLERANCE: f64 = 1e-4;
/// Rays that a thread checks at a time.
const RAYS_PER_TASK: usize = 8192;

/// The arrays of a queue that tracing needs, in canonical order.
#[derive(Clone, Copy, Debug)]
pub struct QueueRays<'a> {
    /// The rays, world space.
    pub rays: &'a [Ray],
    /// Path index of each.
    pub path_ids: &'a [u32],
    /// Light index of each shadow ray; empty for closest rays.
    pub lights: &'a [u32],
}

/// What is wrong with a queue.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[expect(missing_docs, reason = "each message says what it and its fields mean")]
pub enum QueueFault {
    #[error("{queue}/{}.npy has {found} entries, but the queue has {expected} rays", array.name())]
    Count { queue: QueueId, array: QueueArray, found: u64, expected: u64 },
    /// An entry that nothing can be traced or looked up with.
    #[error("{queue}/{}.npy: {problem}", array.name())]
    Entry { queue: QueueId, array: QueueArray, problem: String },
    #[error(
        "{queue}: the recording has {} and {}",
        counted((*passes).into(), "pass", "passes"),
        counted((*bounces).into(), "bounce", "bounces")
    )]
    Outside { queue: QueueId, passes: u32, bounces: u32 },
}

/// What the entries of a queue's arrays must be.
#[derive(Clone, Copy, Debug)]
pub struct QueueRules {
    queue: QueueId,
    /// Its pass lies below this.
    passes: u32,
    /// Its bounce lies below this.
    bounces: u32,
    /// Path indices lie below this.
    pixels: u64,
    /// Light indices lie below this.
    lights: usize,
    /// Whether every ray goes on for ever, as closest rays do that we traced ourselves.
    is_endless: bool,
}

impl QueueRules {
    /// The rules for a queue of a recording with this header.
    pub fn new(queue: QueueId, header: &Header) -> Self {
        Self {
            queue,
            passes: header.options.passes,
            bounces: header.options.bounces,
            pixels: u64::from(header.options.width) * u64::from(header.options.height),
            lights: header.lights.len(),
            is_endless: queue.kind == Kind::Closest && header.source == Source::Traced,
        }
    }

    /// What is wrong with a ray by itself, if anything.
    pub fn ray_problem(&self, ray: &Ray) -> Option<&'static str> {
        let squared: f64 = ray.direction.iter().map(|&along| f64::from(along) * f64::from(along)).sum();
        let is_unit = (squared.sqrt() - 1.0).abs() < UNIT_TOLERANCE;
        if !ray.origin.iter().all(|along| along.abs() <= ORIGIN_LIMIT) {
            Some("has an origin with a coordinate that is no number, or beyond 2^60")
        } else if !is_unit {
            Some("has a direction that is no unit vector")
        } else if !(ray.t_min >= 0.0 && ray.t_min.is_finite()) {
            Some("has a t_min that is negative or not finite")
        } else if ray.t_max.is_nan() || ray.t_max < ray.t_min {
            Some("has a t_max that is below its t_min, or no distance")
        } else if self.is_endless && ray.t_max != f32::INFINITY {
            Some("is a closest ray with a t_max other than infinity")
        } else {
            None
        }
    }

    /// What is wrong with a ray of the queue's array, with its place.
    pub fn ray_fault(&self, rays: &[Ray], at: usize) -> Option<String> {
        self.ray_problem(&rays[at]).map(|problem| format!("ray {at} {problem}: {:?}", rays[at]))
    }

    /// What is wrong with an entry of `path_ids`: they ascend, and name pixels.
    pub fn path_id_fault(&self, path_ids: &[u32], at: usize) -> Option<String> {
        let before = at.checked_sub(1).map(|before| path_ids[before]);
        let is_right =
            u64::from(path_ids[at]) < self.pixels && before.is_none_or(|before| before < path_ids[at]);
        (!is_right).then(|| {
            let after = before.map_or("nothing".to_owned(), |before| before.to_string());
            format!(
                "entry {at} is {} after {after}; expected ascending indices below {}",
                path_ids[at], self.pixels
            )
        })
    }

    /// What is wrong with an entry of `lights`.
    pub fn light_fault(&self, lights: &[u32], at: usize) -> Option<String> {
        (lights[at] as usize >= self.lights)
            .then(|| format!("ray {at} goes to light {} of {}", lights[at], self.lights))
    }

    /// What is wrong with an entry of `throughput`: no light is negative, and a camera ray's path lost none yet.
    pub fn throughput_fault(&self, throughput: &[[f32; 3]], at: usize) -> Option<String> {
        let found = throughput[at];
        let is_first = self.queue.bounce == 0;
        let is_right = found.iter().all(|part| part.is_finite() && *part >= 0.0);
        let expected = if is_first { "1, 1, 1 of a camera ray" } else { "finite numbers of at least 0" };
        (!is_right || is_first && found != [1.0; 3])
            .then(|| format!("ray {at} carries {found:?}, expected {expected}"))
    }

    /// Checks all of a queue that has `expected` rays. That path indices ascend below the number of
    /// pixels also holds the rays to what was made room for.
    ///
    /// # Errors
    /// That the recording has no such queue; or the first fault of each array's length, then of each array's entries.
    pub fn check(&self, queue: QueueRays<'_>, expected: u64) -> Result<(), QueueFault> {
        let &Self { queue: id, passes, bounces, .. } = self;
        if id.pass >= passes || id.bounce >= bounces {
            return Err(QueueFault::Outside { queue: id, passes, bounces });
        }
        let QueueRays { rays, path_ids, lights } = queue;
        let mut counts = vec![(QueueArray::Rays, rays.len()), (QueueArray::PathIds, path_ids.len())];
        if self.queue.kind == Kind::Shadow {
            counts.push((QueueArray::Lights, lights.len()));
        }
        for (array, found) in counts {
            self.check_count(array, found as u64, expected)?;
        }
        self.first(QueueArray::Rays, rays.len(), |at| self.ray_fault(rays, at))?;
        self.first(QueueArray::PathIds, path_ids.len(), |at| self.path_id_fault(path_ids, at))?;
        self.first(QueueArray::Lights, lights.len(), |at| self.light_fault(lights, at))
    }

    /// Checks that an array has one entry per ray.
    ///
    /// # Errors
    /// If it has not.
    pub fn check_count(&self, array: QueueArray, found: u64, expected: u64) -> Result<(), QueueFault> {
        if found == expected {
            return Ok(());
        }
        Err(QueueFault::Count { queue: self.queue, array, found, expected })
    }

    fn first(
        &self,
        array: QueueArray,
        entries: usize,
        fault: impl Fn(usize) -> Option<String> + Sync,
    ) -> Result<(), QueueFault> {
        let found = (0..entries).into_par_iter().with_min_len(RAYS_PER_TASK).find_map_first(&fault);
        found.map_or(Ok(()), |problem| Err(QueueFault::Entry { queue: self.queue, array, problem }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RULES: QueueRules = QueueRules {
        queue: QueueId { pass: 0, bounce: 1, kind: Kind::Shadow },
        passes: 1,
        bounces: 2,
        pixels: 4,
        lights: 2,
        is_endless: false,
    };
    const ENDLESS: QueueRules = QueueRules { is_endless: true, ..RULES };
    const RAY: Ray = Ray { origin: [1.0; 3], t_min: 0.5, direction: [0.6, 0.0, -0.8], t_max: f32::INFINITY };

    #[test]
    fn each_fault_of_a_ray_is_found() {
        assert_eq!(ENDLESS.ray_problem(&RAY), None);
        assert_eq!(RULES.ray_problem(&Ray { t_max: 0.5, ..RAY }), None);
        assert_eq!(RULES.ray_problem(&Ray { origin: [ORIGIN_LIMIT; 3], ..RAY }), None);
        for (bad, rules, part) in [
            (Ray { origin: [0.0, f32::NAN, 0.0], ..RAY }, RULES, "origin"),
            (Ray { origin: [0.0, -1.01 * ORIGIN_LIMIT, 0.0], ..RAY }, RULES, "origin"),
            (Ray { direction: [0.6, 0.0, -0.81], ..RAY }, RULES, "unit"),
            (Ray { direction: [f32::NAN; 3], ..RAY }, RULES, "unit"),
            (Ray { direction: [0.0; 3], ..RAY }, RULES, "unit"),
            (Ray { t_min: -1.0, ..RAY }, RULES, "t_min"),
            (Ray { t_min: f32::INFINITY, ..RAY }, RULES, "t_min"),
            (Ray { t_max: 2.0, ..RAY }, ENDLESS, "t_max"),
            (Ray { t_max: f32::NAN, ..RAY }, RULES, "t_max"),
            (Ray { t_max: 0.25, ..RAY }, RULES, "t_max"),
        ] {
            assert!(rules.ray_problem(&bad).is_some_and(|problem| problem.contains(part)), "{bad:?}");
        }
    }

    #[test]
    fn a_queue_is_refused_for_each_of_its_arrays() {
        let good = QueueRays { rays: &[RAY; 2], path_ids: &[1, 3], lights: &[1, 0] };
        assert_eq!(RULES.check(good, 2), Ok(()));
        for (bad, part) in [
            (QueueRays { rays: &[RAY], ..good }, "rays.npy has 1 entries, but the queue has 2"),
            (QueueRays { path_ids: &[1, 3, 4], ..good }, "path_ids.npy has 3"),
            (QueueRays { lights: &[], ..good }, "lights.npy has 0"),
            (QueueRays { path_ids: &[3, 1], ..good }, "entry 1 is 1 after 3"),
            (QueueRays { path_ids: &[1, 4], ..good }, "below 4"),
            (QueueRays { lights: &[0, u32::MAX], ..good }, "ray 1 goes to light 4294967295 of 2"),
        ] {
            let message = RULES.check(bad, 2).unwrap_err().to_string();
            assert!(message.contains(part) && message.starts_with("pass-000/bounce-01/shadow/"), "{message}");
        }
    }
}
