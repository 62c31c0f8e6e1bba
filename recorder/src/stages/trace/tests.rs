//! The tracers held against testing every triangle; the oracle judges them in the stress tests.

use std::sync::atomic::AtomicU32;

use clap::ValueEnum;
use fastrand::Rng;
use formats::intersect::{Shear, farthest, reciprocal};
use formats::metrics::lanes::{LaneUse, work_of};
use formats::ray::{Hit, Kind, Ray, Work};
use glam::Vec3;
use scenes::bvh::{BvhKind, build};
use scenes::{Material, Scene, Texture};

use super::cpu::CpuTracer;
use super::hits::Hits;
use super::mask::Masks;
use super::triangle::{LeafTriangle, TriangleBlock, TriangleRay};
use super::{Order, Precision, TraceKernel};
use crate::stages::compare::cpu::differences as differences_between;
use crate::stages::scatter::cpu::scatter;
use crate::stages::shade::surface::offset_origin;
use crate::stages::sort::cpu::permutation_of;

/// Each coordinate in [0, 1).
fn point(random: &mut Rng) -> [f32; 3] {
    std::array::from_fn(|_| random.f32())
}

fn direction(random: &mut Rng) -> [f32; 3] {
    loop {
        let v = point(random).map(|x| 2.0 * x - 1.0);
        let squared = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
        if squared > 0.01 && squared < 1.0 {
            return v.map(|x| x / squared.sqrt());
        }
    }
}

/// A scene of triangles that share no corners.
fn scene_of(triangles: Vec<[[f32; 3]; 3]>) -> Scene {
    let indices = (0..triangles.len() as u32).map(|index| [3 * index, 3 * index + 1, 3 * index + 2]);
    Scene::of_geometry("test".into(), triangles.concat(), indices.collect())
}

fn soup(count: usize, size: f32, seed: u64) -> Scene {
    let mut random = Rng::with_seed(seed);
    let mut triangle = || {
        let centre = point(&mut random);
        std::array::from_fn(|_| {
            let offset = point(&mut random);
            [0, 1, 2].map(|axis| centre[axis] + size * (offset[axis] - 0.5))
        })
    };
    scene_of((0..count).map(|_| triangle()).collect())
}

/// A closed sphere whose triangles share their corners, as a grid of longitudes and latitudes.
fn sphere(rings: u32, radius: f32, centre: [f32; 3]) -> Scene {
    let segments = 2 * rings;
    let point = |ring: u32, segment: u32| {
        let polar = std::f64::consts::PI * f64::from(ring) / f64::from(rings);
        let azimuth = std::f64::consts::TAU * f64::from(segment % segments) / f64::from(segments);
        let unit = [polar.sin() * azimuth.cos(), polar.cos(), polar.sin() * azimuth.sin()];
        [0, 1, 2].map(|axis| (f64::from(centre[axis]) + f64::from(radius) * unit[axis]) as f32)
    };
    let mut triangles = Vec::new();
    for ring in 0..rings {
        for segment in 0..segments {
            let [a, b] = [point(ring, segment), point(ring, segment + 1)];
            let [c, d] = [point(ring + 1, segment), point(ring + 1, segment + 1)];
            triangles.extend([[a, b, c], [b, d, c]]);
        }
    }
    scene_of(triangles)
}

fn ray(origin: [f32; 3], direction: [f32; 3]) -> Ray {
    Ray { origin, t_min: 0.0, direction, t_max: f32::INFINITY }
}

fn random_rays(count: usize, seed: u64) -> Vec<Ray> {
    let mut random = Rng::with_seed(seed);
    (0..count).map(|_| ray(point(&mut random).map(|x| 3.0 * x - 1.0), direction(&mut random))).collect()
}

/// Rays that start or run in the planes and along the edges of the unit grid.
fn aligned_rays(seed: u64) -> Vec<Ray> {
    let mut random = Rng::with_seed(seed);
    let mut rays = Vec::new();
    for index in 0..3000 {
        let snap = |x: f32| (x * 8.0).round() / 8.0;
        let origin = point(&mut random).map(|x| if index % 2 == 0 { snap(x) } else { x });
        let mut direction = direction(&mut random);
        let zero = if index % 5 < 3 { 0.0 } else { -0.0 };
        direction[index % 3] = zero;
        if index % 4 == 0 {
            direction[(index + 1) % 3] = zero;
            direction[(index + 2) % 3] = if index % 8 == 0 { 1.0 } else { -1.0 };
        }
        rays.push(ray(origin, direction));
    }
    rays
}

/// Axis-aligned walls on the unit grid: boxes without thickness, edges in the planes of boxes,
/// every diagonal shared.
fn walls() -> Scene {
    let mut triangles = Vec::new();
    for axis in 0..3 {
        for cell in 0..9 * 8 * 8 {
            let at = [cell / 64, cell / 8 % 8, cell % 8];
            if (at[0] * 7 + at[1] * 5 + at[2] * 3 + axis) % 4 == 0 {
                continue;
            }
            let corner = |i: usize, j: usize| {
                let mut point = [0.0; 3];
                point[axis] = at[0] as f32 / 8.0;
                point[(axis + 1) % 3] = (at[1] + i) as f32 / 8.0;
                point[(axis + 2) % 3] = (at[2] + j) as f32 / 8.0;
                point
            };
            triangles.push([corner(0, 0), corner(1, 0), corner(1, 1)]);
            triangles.push([corner(0, 0), corner(1, 1), corner(0, 1)]);
        }
    }
    scene_of(triangles)
}

fn tracers(scene: &Scene) -> Vec<(String, CpuTracer)> {
    let mut tracers = Vec::new();
    for &kernel in TraceKernel::value_variants() {
        let Some(kind) = kernel.bvh_kind() else { continue };
        let tracer = CpuTracer::new(scene, &build(scene, kind).unwrap()).with_kernel(kernel);
        let name = kernel.name();
        tracers.push((format!("{name}, portable"), tracer.clone().portable()));
        tracers.push((format!("{name}, best instructions"), tracer));
    }
    tracers
}

/// The nearest hit by the tracers' own triangle test, without a hierarchy.
fn every_triangle(scene: &Scene, ray: &Ray) -> Hit {
    let masks = Masks::new(scene);
    let shear = Shear::new(ray, ray.direction.map(reciprocal));
    let mut best = Hit { t: farthest(ray), ..Hit::MISS };
    for triangle in 0..scene.triangles.len() as u32 {
        let number = masks.number(triangle);
        let leaf = LeafTriangle::new(&scene.corners(triangle as usize), triangle, number);
        let Some(at) = shear.intersect(&leaf) else { continue };
        let is_hole = number != 0 && masks.is_hole(number, at.u, at.v);
        let is_nearer = at.t < best.t || (at.t == best.t && triangle < best.triangle);
        if at.t >= ray.t_min && is_nearer && !is_hole {
            best = Hit { t: at.t.abs(), triangle, u: at.u, v: at.v };
        }
    }
    if best.is_hit() { best } else { Hit::MISS }
}

fn bits(hit: &Hit) -> [u32; 4] {
    bytemuck::cast(*hit)
}

fn found(tracer: &CpuTracer, kind: Kind, rays: &[Ray], order: Order<&[AtomicU32]>) -> Hits {
    let hits = Hits::new(kind, rays.len());
    tracer.trace(rays, order, &hits);
    hits
}

fn closest(tracer: &CpuTracer, rays: &[Ray]) -> Vec<Hit> {
    let hits = found(tracer, Kind::Closest, rays, Order::Stored);
    (0..rays.len()).map(|index| hits.hit(index)).collect()
}

fn occlusion(tracer: &CpuTracer, rays: &[Ray]) -> Vec<f32> {
    let hits = found(tracer, Kind::Shadow, rays, Order::Stored);
    (0..rays.len()).map(|index| hits.distance(index)).collect()
}

/// All tracers find what testing every triangle finds, bit for bit. Returns how many rays hit.
fn check_against_every_triangle(what: &str, scene: &Scene, rays: &[Ray]) -> usize {
    let expected: Vec<Hit> = rays.iter().map(|ray| every_triangle(scene, ray)).collect();
    for (name, tracer) in tracers(scene) {
        let hits = closest(&tracer, rays);
        let distances = occlusion(&tracer, rays);
        for (index, expected) in expected.iter().enumerate() {
            let ray = &rays[index];
            assert_eq!(
                bits(&hits[index]),
                bits(expected),
                "{what}, {name}, ray {index} {ray:?}: {:?}, not {expected:?}",
                hits[index]
            );
            assert_eq!(
                distances[index].is_finite(),
                expected.is_hit(),
                "{what}, {name}, shadow ray {index} {ray:?}"
            );
            assert!(
                !expected.is_hit() || distances[index] >= expected.t,
                "{what}, {name}: an occluder before the nearest hit"
            );
        }
    }
    expected.iter().filter(|hit| hit.is_hit()).count()
}

#[test]
fn every_tracer_finds_what_testing_every_triangle_finds() {
    let cases = [
        ("a small soup", soup(7, 0.5, 1)),
        ("a soup", soup(1500, 0.1, 2)),
        ("slivers and needles", {
            let mut scene = soup(1000, 0.5, 3);
            for (index, corner) in scene.positions.iter_mut().enumerate() {
                if index % 3 == 0 {
                    corner[1] *= 1e-6;
                }
            }
            scene
        }),
        ("walls", walls()),
        ("one triangle", soup(1, 1.0, 4)),
    ];
    for (name, scene) in cases {
        let mut rays = random_rays(3000, 5);
        rays.extend(aligned_rays(6));
        let hits = check_against_every_triangle(name, &scene, &rays);
        assert!(hits > 30, "{name}: only {hits} rays hit anything");
    }
}

/// The variants that precision is measured against are what they are called: Möller and Trumbore's test lets
/// rays out, the watertight one does not where boxes are padded, and all agree but for few rays.
#[test]
fn plain_tests_lose_rays_and_careful_ones_do_not() {
    let scene = sphere(100, 2.0, [0.0; 3]);
    let mut random = Rng::with_seed(23);
    // From anywhere inside at points on edges.
    let rays: Vec<Ray> = (0..scene.triangles.len())
        .map(|triangle| {
            let [a, b, _] = scene.corners(triangle);
            let (origin, share) = (direction(&mut random).map(|x| 0.4 * x), random.f32());
            let to = [0, 1, 2].map(|axis| a[axis] + (b[axis] - a[axis]) * share - origin[axis]);
            let length = (to[0] * to[0] + to[1] * to[1] + to[2] * to[2]).sqrt();
            ray(origin, to.map(|x| x / length))
        })
        .collect();
    for (name, tracer) in tracers(&scene) {
        let [careful, _, plain_triangles, plain] = Precision::ALL.map(|precision| {
            let tracer = tracer.clone().with_precision(precision);
            closest(&tracer, &rays).iter().filter(|hit| !hit.is_hit()).count()
        });
        assert_eq!(careful, 0, "{name}");
        assert!(plain_triangles > 0 && plain >= plain_triangles, "{name}: {plain_triangles}, {plain}");
        assert!(plain < rays.len() / 2, "{name}: {plain}");
    }
}

#[test]
fn rays_through_edges_and_corners_hit() {
    // A square of four triangles around a corner: rays straight at its edges and its middle.
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let middle = [0.5, 0.5, 0.0];
    let scene = scene_of((0..4).map(|side| [corners[side], corners[(side + 1) % 4], middle]).collect());
    let mut rays = Vec::new();
    for (x, y) in [(0.5, 0.5), (0.25, 0.25), (0.75, 0.25), (0.0, 0.0), (1.0, 0.5), (0.5, 0.0), (1.0, 1.0)] {
        for (z, dz) in [(3.0, -1.0), (-3.0, 1.0)] {
            rays.push(ray([x, y, z], [0.0, -0.0, dz]));
        }
    }
    for (name, tracer) in tracers(&scene) {
        for (ray, hit) in rays.iter().zip(closest(&tracer, &rays)) {
            assert_eq!(hit.t, 3.0, "{name}: {ray:?} went through an edge");
        }
        // Edge-on, a triangle is not there.
        let edge_on = [ray([-1.0, 0.5, 0.0], [1.0, 0.0, 0.0])];
        assert_eq!(closest(&tracer, &edge_on)[0], Hit::MISS, "{name}");
    }
}

#[test]
fn both_ends_of_a_ray_count() {
    let scene = scene_of(vec![[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]]);
    let (below, above) = (2f32.next_down(), 2f32.next_up());
    let cases = [
        (0.0, f32::INFINITY, true),
        (2.0, f32::INFINITY, true),
        (above, f32::INFINITY, false),
        (0.0, 2.0, true),
        (0.0, below, false),
        (2.0, 2.0, true),
        (3.0, 1.0, false),
    ];
    for (name, tracer) in tracers(&scene) {
        for (t_min, t_max, is_hit) in cases {
            let ray = Ray { origin: [0.25, 0.5, 2.0], t_min, direction: [0.0, 0.0, -1.0], t_max };
            let hit = closest(&tracer, &[ray])[0];
            assert_eq!(hit.is_hit(), is_hit, "{name}: {t_min}..={t_max}");
            assert!(!is_hit || (hit.u, hit.v) == (0.25, 0.5), "{name}: {hit:?}");
            assert_eq!(occlusion(&tracer, &[ray])[0], if is_hit { 2.0 } else { f32::INFINITY }, "{name}");
            assert_eq!(bits(&hit), bits(&every_triangle(&scene, &ray)), "{name}");
        }
        // A ray does not find the surface that it starts on.
        for height in [0.0, -0.0] {
            let hit = closest(&tracer, &[ray([0.25, 0.25, height], [0.0, 0.0, -1.0])])[0];
            assert_eq!(hit, Hit::MISS, "{name}");
        }
    }
}

#[test]
fn the_nearest_hit_beyond_t_min_is_found() {
    let scene = soup(800, 0.3, 31);
    let rays: Vec<Ray> = random_rays(3000, 32)
        .into_iter()
        .zip(0u8..=255)
        .cycle()
        .take(3000)
        .map(|(ray, step)| Ray { t_min: f32::from(step % 16) / 16.0, t_max: f32::from(step) / 100.0, ..ray })
        .collect();
    check_against_every_triangle("a part of each ray", &scene, &rays);
}

/// Eight rays at a time that start and go close to each other, aimed at corners, edges and anything else.
fn neighbours(scene: &Scene, seed: u64) -> Vec<Ray> {
    let mut random = Rng::with_seed(seed);
    let mut rays = Vec::new();
    for group in 0..500 {
        let from = point(&mut random).map(|x| 3.0 * x - 1.0);
        let [a, b, c] = scene.corners(random.usize(0..scene.triangles.len()));
        let apart = [0.0, 1e-6, 1e-3, 0.03, 0.2][group % 5];
        for _ in 0..8 {
            let mut near = || point(&mut random).map(|x| apart * (x - 0.5));
            let (start, end) = (near(), near());
            let (u, v) = (random.f32(), if group % 2 == 0 { 0.0 } else { 0.3 });
            let origin = [0, 1, 2].map(|axis| from[axis] + start[axis]);
            let to = [0, 1, 2].map(|axis| {
                let target = a[axis] + (b[axis] - a[axis]) * u + (c[axis] - a[axis]) * v;
                target + if group % 3 == 0 { 0.0 } else { end[axis] } - origin[axis]
            });
            let length = to.map(|x| x * x).iter().sum::<f32>().sqrt();
            let t_max = if group % 4 == 0 { length * random.f32() } else { f32::INFINITY };
            rays.push(Ray { t_min: apart * random.f32(), t_max, ..ray(origin, to.map(|x| x / length)) });
        }
    }
    rays
}

/// Fewer than eight rays are never traced together.
#[test]
fn rays_that_are_traced_together_find_what_each_finds_by_itself() {
    for (name, scene) in [
        ("a soup", soup(1500, 0.1, 51)),
        ("a crowd", soup(400, 1.0, 52)),
        ("walls", walls()),
        ("a sphere", sphere(60, 0.5, [0.5; 3])),
        ("masks", masked()),
    ] {
        let rays = neighbours(&scene, 53);
        for (kernel, tracer) in tracers(&scene).into_iter().filter(|(name, _)| name.starts_with("wide")) {
            let by_itself = |find: fn(&CpuTracer, &[Ray]) -> Vec<[u32; 4]>| {
                rays.chunks(7).flat_map(|rays| find(&tracer, rays)).collect::<Vec<_>>()
            };
            let nearest = |tracer: &CpuTracer, rays: &[Ray]| closest(tracer, rays).iter().map(bits).collect();
            let blocked = |tracer: &CpuTracer, rays: &[Ray]| {
                occlusion(tracer, rays).iter().map(|distance| [distance.to_bits(), 0, 0, 0]).collect()
            };
            assert!(nearest(&tracer, &rays) == by_itself(nearest), "{name}, {kernel}");
            assert!(blocked(&tracer, &rays) == by_itself(blocked), "{name}, {kernel}, shadow rays");
            for kind in Kind::ALL {
                let together =
                    rays.chunks(8).filter(|rays| tracer.traced_together(rays, kind) == rays.len()).count();
                assert!((50..450).contains(&together), "{name}, {kernel}, {kind}: {together} bundles of 500");
            }
        }
    }
}

/// A soup with two masked materials, one of them without a texture.
fn masked() -> Scene {
    let mut scene = soup(600, 0.4, 41);
    let mut random = Rng::with_seed(42);
    scene.uvs =
        scene.positions.iter().map(|_| [3.0 * random.f32() - 1.0, 3.0 * random.f32() - 1.0]).collect();
    scene.textures = vec![Texture {
        width: 5,
        height: 3,
        rgba: (0..15).map(|texel| [0, 0, 0, (texel * 17) as u8]).collect(),
    }];
    let leaf = Material { alpha_cutoff: Some(0.5), base_color_texture: Some(0), ..Material::default() };
    let glass = Material { alpha_cutoff: Some(0.5), alpha: 0.25, ..Material::default() };
    scene.materials.extend([leaf, glass]);
    scene.triangle_materials = (0..600).map(|triangle| triangle % 3).collect();
    scene
}

#[test]
fn holes_are_not_hit() {
    let scene = masked();
    let rays = random_rays(3000, 43);
    check_against_every_triangle("masks", &scene, &rays);
    let hits = closest(&tracers(&scene)[0].1, &rays);
    let of_material = |material| {
        hits.iter()
            .filter(|hit| hit.is_hit() && scene.triangle_materials[hit.triangle as usize] == material)
            .count()
    };
    assert!(of_material(0) > 100 && of_material(1) > 50, "{} and {}", of_material(0), of_material(1));
    assert_eq!(of_material(2), 0, "a quarter opaque is a hole everywhere at a cutoff of a half");
    for hit in hits.iter().filter(|hit| hit.is_hit() && scene.triangle_materials[hit.triangle as usize] == 1)
    {
        let [a, b, c] =
            scene.triangles[hit.triangle as usize].map(|vertex| scene.uvs[vertex as usize].map(f64::from));
        let (u, v) = (f64::from(hit.u), f64::from(hit.v));
        let texel = [(0, 5.0), (1, 3.0)].map(|(axis, size)| {
            (((1.0 - u - v) * a[axis] + u * b[axis] + v * c[axis]).rem_euclid(1.0)) * size
        });
        if texel.iter().any(|place| (place - place.round()).abs() < 1e-4) {
            continue; // Too near to a texel's edge to say which one it is.
        }
        let alpha = scene.textures[0].rgba[texel[1] as usize * 5 + texel[0] as usize][3];
        assert!(f64::from(alpha) / 255.0 >= 0.5, "a hole was hit: {hit:?}");
    }
}

#[test]
fn threads_and_orders_do_not_change_results() {
    let scene = soup(2000, 0.1, 51);
    let rays = random_rays(5000, 52);
    let mut random = Rng::with_seed(53);
    let mut permutation: Vec<u32> = (0..rays.len() as u32).collect();
    permutation.sort_by_cached_key(|_| (random.f32() * 1e6) as u32);
    let gathered: Vec<Ray> = permutation.iter().map(|&place| rays[place as usize]).collect();
    for (name, tracer) in tracers(&scene) {
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let works = Kind::ALL.map(|kind| tracer.work(&rays, kind));
                (closest(&tracer, &rays), occlusion(&tracer, &rays), works)
            })
        };
        let (hits, distances, works) = on(1);
        assert_eq!((hits.clone(), distances.clone(), works.clone()), on(3), "{name}");
        let nodes = |works: &[Work]| works.iter().map(|work| work.nodes).sum::<u32>();
        assert!(nodes(&works[1]) < nodes(&works[0]), "{name}: any hit is found sooner than the nearest");
        for (all, hit) in works[0].iter().zip(&hits) {
            assert!(!hit.is_hit() || (all.nodes > 0 && all.triangles > 0), "{name}");
        }

        let places = permutation_of(&permutation);
        let home = |kind| {
            let home = Hits::new(kind, rays.len());
            scatter(&found(&tracer, kind, &gathered, Order::Stored), &places, &home);
            home
        };
        let through_indices = |kind| found(&tracer, kind, &rays, Order::Indirect(&places));
        for traced in [&home as &dyn Fn(Kind) -> Hits, &through_indices] {
            let scattered = traced(Kind::Closest);
            let differences = |hits: &[Hit]| {
                differences_between(&scattered, &Hits::from_bytes(Kind::Closest, bytemuck::cast_slice(hits)))
            };
            assert_eq!(differences(&hits), 0, "{name}");
            let mut other = hits.clone();
            other[77].v += 1.0;
            other[4999].triangle ^= 1;
            assert_eq!(differences(&other), 2, "{name}");

            let scattered = traced(Kind::Shadow);
            let differences = |hits: &[f32]| {
                differences_between(&scattered, &Hits::from_bytes(Kind::Shadow, bytemuck::cast_slice(hits)))
            };
            assert_eq!(differences(&distances), 0, "{name}");
            let nearer: Vec<f32> = distances.iter().map(|distance| 0.5 * distance).collect();
            assert_eq!(differences(&nearer), 0, "{name}: blocked all the same");
            let free = distances.iter().filter(|distance| distance.is_infinite()).count() as u64;
            assert!(free > 0);
            assert_eq!(differences(&vec![1.0; rays.len()]), free, "{name}");
        }
    }
}

#[test]
fn work_is_the_same_whatever_the_instructions() {
    let scene = soup(2000, 0.1, 61);
    let rays = random_rays(2000, 62);
    for pair in tracers(&scene).chunks(2) {
        for kind in Kind::ALL {
            assert_eq!(
                pair[0].1.work(&rays, kind),
                pair[1].1.work(&rays, kind),
                "{} and {}",
                pair[0].0,
                pair[1].0
            );
        }
    }
}

/// Results are those of each ray by itself, and the lanes do what `bvh2` does ray by ray.
#[test]
fn neighbours_do_not_change_results() {
    for scene in [soup(2000, 0.1, 71), masked()] {
        let rays = random_rays(300, 72);
        let all = tracers(&scene);
        let of = |kernel: TraceKernel| {
            let named = |(name, _): &&(String, CpuTracer)| name.starts_with(kernel.name());
            all.iter().filter(named).map(|(_, tracer)| tracer).collect::<Vec<_>>()
        };
        for (name, tracer) in &all {
            let (hits, distances) = (closest(tracer, &rays), occlusion(tracer, &rays));
            let works = Kind::ALL.map(|kind| tracer.work(&rays, kind));
            for (index, ray) in rays.iter().enumerate() {
                let alone = std::slice::from_ref(ray);
                assert_eq!(bits(&closest(tracer, alone)[0]), bits(&hits[index]), "{name}, ray {index}");
                assert_eq!(occlusion(tracer, alone)[0], distances[index], "{name}, shadow ray {index}");
                let work = Kind::ALL.map(|kind| tracer.work(alone, kind)[0]);
                assert_eq!(work, [works[0][index], works[1][index]], "{name}, work of ray {index}");
            }
        }
        for (alone, lanes) in of(TraceKernel::Bvh2).into_iter().zip(of(TraceKernel::Lanes)) {
            assert_eq!(occlusion(alone, &rays), occlusion(lanes, &rays));
            for kind in Kind::ALL {
                assert_eq!(alone.work(&rays, kind), lanes.work(&rays, kind));
            }
        }
    }
}

#[test]
fn lanes_are_all_busy_with_equal_rays_and_one_is_with_one_ray() {
    let scene = soup(2000, 0.1, 81);
    let rays = random_rays(1000, 82);
    let bvh = build(&scene, BvhKind::Bvh2).unwrap();
    for (kernel, width) in [(TraceKernel::Lanes, 8), (TraceKernel::Packet, 16)] {
        let tracer = CpuTracer::new(&scene, &bvh).with_kernel(kernel);
        for kind in Kind::ALL {
            let busy = |rays: &[Ray]| tracer.lane_use(rays, kind).unwrap().utilisation().unwrap();
            assert_eq!(busy(&rays[..1]), 1.0 / f64::from(width), "{kernel:?}, {kind}");
            assert_eq!(busy(&[rays[0]; 64]), 1.0, "{kernel:?}, {kind}");
            assert!(busy(&rays) < 0.9, "{kernel:?}, {kind}");
        }
    }
    // Lanes wait for others to do something else, which the model knows nothing of.
    let tracer = CpuTracer::new(&scene, &bvh).with_kernel(TraceKernel::Lanes);
    let measured = tracer.lane_use(&rays, Kind::Closest).unwrap();
    let mut model = LaneUse::new(8);
    model.add(&tracer.work(&rays, Kind::Closest).iter().map(work_of).collect::<Vec<_>>());
    assert_eq!(measured.work, model.work);
    assert!(measured.capacity > model.capacity, "{measured:?}, {model:?}");
    assert_eq!(CpuTracer::new(&scene, &bvh).lane_use(&rays, Kind::Closest), None);
}

#[test]
fn a_block_lets_through_what_is_hit_and_seldom_the_triangle_that_a_ray_leaves() {
    let mut random = Rng::with_seed(7);
    let (mut left, mut let_through) = (0, 0);
    for round in 0..40_000 {
        let centre = Vec3::from(point(&mut random)) * 10.0;
        let mut corner = || centre + Vec3::from(point(&mut random));
        let triangles: [[Vec3; 3]; 4] = std::array::from_fn(|_| {
            let [a, b, c] = [corner(), corner(), corner()];
            // Half of them are slivers.
            [a, b, if round % 2 == 0 { c } else { a.lerp(b, 0.3) + (c - a) * 1e-4 }]
        });
        let [a, b, c] = triangles[0];
        let (u, v) = (0.5 * random.f32(), 0.5 * random.f32());
        let normal = (b - a).cross(c - a).normalize();
        let on_it = a + u * (b - a) + v * (c - a);
        let off_it = offset_origin(on_it, normal, b - a, c - a);
        // At a distance at which it is sure to be left, and at those at which it is not.
        let part = [1.0, 1.0, 0.1, 0.01, 0.0, -0.1, -1.0][round % 7];
        // Exact, down to where products of three coordinates are no longer numbers of full precision.
        let size = (random.i32(-40..=40) as f32).exp2();
        let origin = size * (on_it + part * (off_it - on_it));
        let ray = ray(origin.to_array(), direction(&mut random));
        let shear = Shear::new(&ray, ray.direction.map(reciprocal));
        let leaves = triangles
            .map(|corners| LeafTriangle::new(&corners.map(|corner| (size * corner).to_array()), 0, 0));
        let candidates = shear.candidates(&TriangleBlock::new(leaves), f32::MAX);
        for (lane, leaf) in leaves.iter().enumerate() {
            let is_hit = shear.intersect(leaf).is_some();
            assert!(!is_hit || candidates >> lane & 1 == 1, "lane {lane} of {triangles:?}, {ray:?}");
        }
        if size > 1e-6 && round % 2 == 0 && part == 1.0 && normal.dot(Vec3::from(ray.direction)) > 0.1 {
            left += 1;
            let_through += candidates & 1;
        }
    }
    assert!(left > 1_500 && 20 * let_through < left, "{let_through} of {left}");
}
