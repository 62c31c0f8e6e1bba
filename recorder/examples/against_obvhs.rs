//! Our CPU kernels beside obvhs's own traversal and triangle test, on the rays of a recording.
//!
//! `cargo run --release --example against_obvhs -- X.raydump [BOUNCE] [ROUNDS]`: closest rays of the
//! measured pass, in canonical order and shuffled, on 1 and on 2 threads, in alternation. Shows the
//! best rate of each in Mrays/s and how many rays the two found at different distances.

use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result};
use formats::manifest::{Place, QueueArray, QueueId, SceneArray};
use formats::ray::{Kind, Ray};
use formats::reader::Dump;
use glam::Vec3A;
use obvhs::bvh2::{Bvh2, builder::build_bvh2_from_tris};
use obvhs::cwbvh::{CwBvh, builder::build_cwbvh_from_tris};
use obvhs::ray::RayHit;
use obvhs::triangle::Triangle;
use obvhs::{BvhBuildParams, ray::Ray as ObvhsRay};
use rayon::prelude::*;
use recorder::stages::trace::Order;
use recorder::stages::trace::cpu::CpuTracer;
use recorder::stages::trace::hits::Hits;
use scenes::Scene;
use scenes::bvh::BvhKind;

const CHUNK: usize = 256;

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let path = arguments.first().context("expected a recording")?;
    let number = |at: usize, default: u32| arguments.get(at).map_or(Ok(default), |text| text.parse());
    let (bounce, rounds) = (number(1, 2)?, number(2, 5)?);
    let dump = Dump::open(Path::new(path))?;
    let (scene, rays) = read(&dump, bounce)?;
    let bvh2 = CpuTracer::new(&scene, &scenes::bvh::build(&scene, BvhKind::Bvh2)?);
    let cwbvh = CpuTracer::new(&scene, &scenes::bvh::build(&scene, BvhKind::Cwbvh)?);
    let theirs = Theirs::new(&scene);
    let shuffled = shuffle(&rays);
    println!("{}: {} closest rays of bounce {bounce}", scene.name, rays.len());
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
        for (order, rays) in [("canonical", &rays), ("shuffled", &shuffled)] {
            let hits = Hits::new(Kind::Closest, rays.len());
            let mut distances = vec![0.0; rays.len()];
            let mut best = [f64::INFINITY; 4];
            let mut differing = [0; 4];
            for _ in 0..rounds {
                for tracer in 0..4 {
                    let start = Instant::now();
                    pool.install(|| match tracer {
                        0 => bvh2.trace(rays, Order::Stored, &hits),
                        1 => theirs.binary(rays, &mut distances),
                        2 => cwbvh.trace(rays, Order::Stored, &hits),
                        _ => theirs.wide(rays, &mut distances),
                    });
                    best[tracer] = best[tracer].min(start.elapsed().as_secs_f64());
                    let differs = |&(at, t): &(usize, &f32)| {
                        let found = hits.distance(at);
                        (found - t).abs() > 1e-3 * found.min(*t)
                    };
                    if tracer % 2 == 1 {
                        differing[tracer] = distances.iter().enumerate().filter(differs).count();
                    }
                }
            }
            let rate = |tracer: usize| rays.len() as f64 / best[tracer] / 1e6;
            println!(
                "{threads} threads, {order}: bvh2 {:.2}, obvhs {:.2} ({} differ); cwbvh {:.2}, obvhs {:.2} ({} differ)",
                rate(0),
                rate(1),
                differing[1],
                rate(2),
                rate(3),
                differing[3]
            );
        }
    }
    Ok(())
}

/// The scene's triangles and a queue of the measured pass.
fn read(dump: &Dump, bounce: u32) -> Result<(Scene, Vec<Ray>)> {
    let positions = dump.array::<[f32; 3]>(&Place::Scene(SceneArray::Positions))?.to_vec();
    let triangles = dump.array::<[u32; 3]>(&Place::Scene(SceneArray::Triangles))?.to_vec();
    let name = dump.manifest().header.scene.name.clone();
    let pass = dump.manifest().header.options.passes - 1;
    let queue = QueueId { pass, bounce, kind: Kind::Closest };
    let rays = dump.array::<Ray>(&Place::Queue(queue, QueueArray::Rays))?.to_vec();
    Ok((Scene::of_geometry(name, positions, triangles), rays))
}

fn shuffle(rays: &[Ray]) -> Vec<Ray> {
    let mut shuffled = rays.to_vec();
    fastrand::Rng::with_seed(1).shuffle(&mut shuffled);
    shuffled
}

/// obvhs with its own everything, triangles in leaf order as its examples do it.
struct Theirs {
    binary: Bvh2,
    binary_triangles: Vec<Triangle>,
    wide: CwBvh,
    wide_triangles: Vec<Triangle>,
}

impl Theirs {
    fn new(scene: &Scene) -> Self {
        let corner = |index: u32| Vec3A::from_array(scene.positions[index as usize]);
        let triangle = |corners: &[u32; 3]| {
            let [v0, v1, v2] = corners.map(corner);
            Triangle { v0, v1, v2 }
        };
        let triangles: Vec<Triangle> = scene.triangles.iter().map(triangle).collect();
        let parameters = BvhBuildParams::medium_build();
        let mut time = std::time::Duration::default();
        let binary = build_bvh2_from_tris(&triangles, parameters, &mut time);
        let wide = build_cwbvh_from_tris(&triangles, parameters, &mut time);
        let sorted = |order: &[u32]| order.iter().map(|&index| triangles[index as usize]).collect();
        Self {
            binary_triangles: sorted(&binary.primitive_indices),
            wide_triangles: sorted(&wide.primitive_indices),
            binary,
            wide,
        }
    }

    fn binary(&self, rays: &[Ray], distances: &mut [f32]) {
        each(rays, distances, |ray, hit| {
            self.binary.ray_traverse(ray, hit, |ray, slot| self.binary_triangles[slot].intersect(ray));
        });
    }

    fn wide(&self, rays: &[Ray], distances: &mut [f32]) {
        each(rays, distances, |ray, hit| {
            self.wide.ray_traverse(ray, hit, |ray, slot| self.wide_triangles[slot].intersect(ray));
        });
    }
}

fn each(rays: &[Ray], distances: &mut [f32], trace: impl Fn(ObvhsRay, &mut RayHit) + Sync) {
    rays.par_chunks(CHUNK).zip(distances.par_chunks_mut(CHUNK)).for_each(|(rays, distances)| {
        for (ray, distance) in rays.iter().zip(distances) {
            let mut hit = RayHit::none();
            trace(ObvhsRay::new(ray.origin.into(), ray.direction.into(), ray.t_min, ray.t_max), &mut hit);
            *distance = hit.t;
        }
    });
}
