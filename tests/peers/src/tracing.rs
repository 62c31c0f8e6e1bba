//! Our kernels beside Embree and obvhs on the rays of a recording.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, AtomicU64, AtomicUsize, Ordering::Relaxed};

use anyhow::{Context, Result};
use clap::ValueEnum;
use formats::ray::{Hit, Kind, Ray};
use recorder::stages::trace::cpu::CpuTracer;
use recorder::stages::trace::hits::Hits;
use recorder::stages::trace::{Order, TraceKernel};
use scenes::Scene;

use crate::contest::{Contest, Row, Side};
use crate::embree::{Embree, Library};
use crate::obvhs_tracer;
use crate::rays::{self, Queue};

/// Traces rays on the threads of the current pool, the nearest hit of each or any, as its results ask.
pub type Trace = Box<dyn Fn(&[Ray], &Hits) + Send + Sync>;

/// Rays that a thread takes at once, as in our tracer where a queue is long.
const CHUNK: usize = 256;

/// Traces the wanted queues of a recording with every tracer.
///
/// # Errors
/// If the recording cannot be read, a hierarchy not be built or no Embree be found.
pub fn compare(
    recording: &Path,
    wanted_rays: &[String],
    libraries: &[PathBuf],
    is_wanted: &dyn Fn(&str) -> bool,
    rounds: usize,
) -> Result<Vec<Row>> {
    let (scene, queues) = rays::read(recording, wanted_rays)?;
    let mut tracers = our_tracers(&scene)?;
    for library in Library::open_all(libraries)? {
        for is_robust in [true, false] {
            let (name, trace) = Embree::new(&library, &scene, is_robust)?.into_tracer();
            tracers.push((name, Side::Peer, trace));
        }
    }
    tracers.push(("obvhs bvh2".to_owned(), Side::Peer, obvhs_tracer::binary(&scene)));
    tracers.push(("obvhs cwbvh".to_owned(), Side::Peer, obvhs_tracer::wide(&scene)));
    tracers.retain(|(name, ..)| is_wanted(name));
    Ok(queues.iter().flat_map(|queue| compare_on(&scene.name, queue, &tracers, rounds)).collect())
}

fn compare_on(scene: &str, queue: &Queue, tracers: &[(String, Side, Trace)], rounds: usize) -> Vec<Row> {
    let hits = Hits::new(queue.kind, queue.rays.len());
    let distances = || (0..hits.len()).map(|at| hits.distance(at)).collect::<Vec<f32>>();
    let mut expected: Option<Vec<f32>> = None;
    let differing = tracers.iter().map(|(_, _, trace)| {
        trace(&queue.rays, &hits);
        let found = distances();
        let expected = expected.get_or_insert_with(|| found.clone());
        found.iter().zip(expected).filter(|(found, expected)| differ(queue.kind, **found, **expected)).count()
    });
    let contest = Contest {
        subject: scene,
        task: queue.name.to_owned(),
        items: queue.rays.len(),
        differing: differing.collect(),
        contestants: tracers.iter().map(|(name, side, _)| (name.clone(), *side)).collect(),
    };
    contest.rows(rounds, |at, clock| clock.time(|| tracers[at].2(&queue.rays, &hits)))
}

/// Whether one hits and the other does not, or the nearest hits are farther apart than rounding explains.
fn differ(kind: Kind, found: f32, expected: f32) -> bool {
    match (found.is_finite(), expected.is_finite()) {
        (true, true) => kind == Kind::Closest && (found - expected).abs() > 1e-3 * found.min(expected),
        (found, expected) => found != expected,
    }
}

/// Every kernel that threads have.
fn our_tracers(scene: &Scene) -> Result<Vec<(String, Side, Trace)>> {
    let mut tracers: Vec<(String, Side, Trace)> = Vec::new();
    for kernel in TraceKernel::value_variants() {
        let hierarchy = kernel.hierarchy(scene).with_context(|| format!("building for {}", kernel.name()))?;
        let Some((hierarchy, _)) = hierarchy else { continue };
        let tracer = CpuTracer::new(scene, &hierarchy).with_kernel(*kernel);
        let trace: Trace = Box::new(move |rays, hits| tracer.trace(rays, Order::Stored, hits));
        tracers.push((kernel.name().to_owned(), Side::Ours, trace));
    }
    Ok(tracers)
}

/// Calls one of two functions for each ray, by the kind of the results, and stores what it says as our tracer
/// does. Threads take chunks of rays from a common counter.
pub fn for_each_ray(
    rays: &[Ray],
    hits: &Hits,
    nearest: impl Fn(&Ray) -> Hit + Sync,
    is_blocked: impl Fn(&Ray) -> bool + Sync,
) {
    match hits {
        Hits::Closest(places) => in_chunks(rays, places, |ray, place: &[AtomicU64; 2]| {
            let halves: [u64; 2] = bytemuck::cast(nearest(ray));
            place[0].store(halves[0], Relaxed);
            place[1].store(halves[1], Relaxed);
        }),
        Hits::Shadow(places) => in_chunks(rays, places, |ray, place: &AtomicU32| {
            let distance = if is_blocked(ray) { 0.0 } else { f32::INFINITY };
            place.store(distance.to_bits(), Relaxed);
        }),
    }
}

fn in_chunks<T: Sync>(rays: &[Ray], places: &[T], trace: impl Fn(&Ray, &T) + Sync) {
    let next = AtomicUsize::new(0);
    rayon::broadcast(|_| {
        loop {
            let first = next.fetch_add(CHUNK, Relaxed);
            if first >= rays.len() {
                break;
            }
            let end = rays.len().min(first + CHUNK);
            rays[first..end].iter().zip(&places[first..end]).for_each(|(ray, place)| trace(ray, place));
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hits_differ_from_misses_and_nearest_hits_from_those_elsewhere() {
        let none = f32::INFINITY;
        assert!(differ(Kind::Closest, 1.0, none) && differ(Kind::Shadow, none, 0.0));
        assert!(!differ(Kind::Closest, none, none) && !differ(Kind::Shadow, 0.0, 5.0));
        assert!(differ(Kind::Closest, 1.0, 1.01) && !differ(Kind::Closest, 1.0, 1.0001));
    }

    /// More rays than a multiple of a chunk, on more threads than one.
    #[test]
    fn every_ray_is_traced_to_its_own_place() {
        let ray = |at: usize| Ray { origin: [at as f32; 3], t_min: 0.0, direction: [0.0; 3], t_max: 1.0 };
        let rays: Vec<Ray> = (0..3 * CHUNK + 7).map(ray).collect();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
        for kind in Kind::ALL {
            let hits = Hits::new(kind, rays.len());
            let nearest = |ray: &Ray| Hit { t: ray.origin[0], triangle: 0, u: 0.0, v: 0.0 };
            pool.install(|| for_each_ray(&rays, &hits, nearest, |ray| ray.origin[0] as usize % 2 == 1));
            let expected = |at: usize| match (kind, at % 2) {
                (Kind::Closest, _) => at as f32,
                (Kind::Shadow, 0) => f32::INFINITY,
                (Kind::Shadow, _) => 0.0,
            };
            assert!((0..rays.len()).all(|at| hits.distance(at) == expected(at)), "{kind}");
        }
    }
}
