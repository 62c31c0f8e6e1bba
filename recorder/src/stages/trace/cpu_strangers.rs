//! Rays of no queue, traced so that a processor does not know a short queue by heart.
//!
//! A queue that is traced again and again teaches a processor where each of its rays branches, in some orders better
//! than in others, unless it has more rays than what guesses branches can keep. A renderer traces it once.

use formats::ray::{Kind, Ray};

use super::Order;
use super::cpu::CpuTracer;
use super::hits::Hits;

/// Rays from which on a queue is not learnt by heart.
const MANY: usize = 1 << 16;
/// Strangers that are traced in between.
const COUNT: usize = 1 << 15;

/// Strangers, and memory for what they find.
#[derive(Debug, Default)]
pub struct Strangers {
    rays: Vec<Ray>,
    hits: Hits,
    /// How often they were traced, so that they are others each time.
    turn: usize,
}

impl Strangers {
    /// Traces rays that start where those of a short queue do and go where others of them go; none for a longer one.
    pub fn trace(&mut self, tracer: &CpuTracer, queue: &[Ray], kind: Kind) {
        if queue.is_empty() || queue.len() >= MANY {
            return;
        }
        let Self { rays, hits, turn } = self;
        *turn += 1;
        rays.clear();
        rays.extend((0..COUNT).map(|at| {
            let other = &queue[(at + at / queue.len() + *turn) % queue.len()];
            Ray { origin: queue[at % queue.len()].origin, ..*other }
        }));
        hits.make_room(kind, COUNT);
        tracer.trace(rays, Order::Stored, hits);
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use scenes::bvh::{self, BvhKind};

    use super::*;

    #[test]
    fn strangers_start_where_rays_do_and_are_others_each_time() {
        let scene = scenes::load("builtin:cornell").unwrap();
        let tracer = CpuTracer::new(&scene, &bvh::build(&scene, BvhKind::Wide).unwrap());
        let numbered = |at: usize| Ray {
            origin: [at as f32, 0.0, 0.0],
            t_min: 0.0,
            direction: [0.0, 0.6, 0.8],
            t_max: 1.0 + at as f32,
        };
        let queue: Vec<Ray> = (0..700).map(numbered).collect();
        let mut strangers = Strangers::default();
        let mut met = BTreeSet::new();
        for _ in 0..3 {
            strangers.trace(&tracer, &queue, Kind::Closest);
            let pairs = || strangers.rays.iter().map(|ray| (ray.origin[0] as usize, ray.t_max as usize - 1));
            assert_eq!(strangers.rays.len(), COUNT);
            assert!(pairs().all(|(origin, other)| origin < queue.len() && other < queue.len()));
            let own = pairs().filter(|(origin, other)| origin == other).count();
            assert!(own <= queue.len(), "{own} are rays of the queue");
            let new: Vec<_> = pairs().filter(|pair| !met.contains(pair)).collect();
            assert!(new.len() >= queue.len() / 2, "{}", new.len());
            met.extend(new);
        }
        strangers.rays.clear();
        strangers.trace(&tracer, &vec![numbered(0); MANY], Kind::Closest);
        strangers.trace(&tracer, &[], Kind::Closest);
        assert!(strangers.rays.is_empty(), "long queues have no strangers");
    }
}
