//! Rays along axes, with zeros of both signs, tiny and huge components, starting on surfaces, ending at
//! hits, and very long walks.

use formats::ray::{Kind, Ray};
use recorder::stages::trace::TraceKernel;
use recorder::stages::trace::cpu::CpuTracer;
use scenes::bvh::{BvhKind, build};

use crate::numbers::{Numbers, ray, towards};
use crate::runner::{Backend, Case, kernels, run, trace};
use crate::shapes::{Triangle, cube, on_a_grid, placed, scene_of, soup, sphere};

/// Directions along axes, and with components that are zero, tiny or huge.
fn odd_direction(numbers: &mut Numbers, number: usize) -> [f32; 3] {
    const ODD: [f32; 8] = [0.0, -0.0, 1e-45, -1e-45, 1e-38, -1e-30, 1e-25, -1e-12];
    let mut direction = numbers.direction();
    match number % 3 {
        0 => {
            let axis = numbers.below(3);
            direction = [0; 3].map(|_| ODD[numbers.below(2)]);
            direction[axis] = if number.is_multiple_of(2) { 1.0 } else { -1.0 };
        }
        1 => direction[numbers.below(3)] = ODD[numbers.below(ODD.len())],
        _ => {
            let axis = numbers.below(3);
            direction = [0; 3].map(|_| ODD[numbers.below(ODD.len())]);
            direction[axis] = if number.is_multiple_of(2) { 1.0 } else { -1.0 };
        }
    }
    direction
}

#[test]
fn axis_parallel_rays_and_components_of_any_size() {
    let mut numbers = Numbers::new(30);
    let closed = cube(8);
    let snap = |x: f32| (x * 8.0).round() / 8.0;
    let inside = (0..15_000).map(|number| {
        let at = numbers.point().map(|x| 1.9 * x - 0.95);
        let origin = if number % 2 == 0 { at.map(snap).map(|x| x.clamp(-0.875, 0.875)) } else { at };
        ray(origin, odd_direction(&mut numbers, number))
    });
    run(&Case::closed("odd directions in a box", scene_of("box", &closed), inside.collect()));
    let grid = on_a_grid(&mut numbers, 300);
    let around = (0..12_000).map(|number| {
        let at = numbers.point().map(|x| 1.5 * x - 0.25);
        let origin = if number % 2 == 0 { at.map(snap) } else { at };
        ray(origin, odd_direction(&mut numbers, number))
    });
    run(&Case::open("odd directions on a grid", scene_of("grid", &grid), around.collect()));
}

#[test]
fn directions_of_any_length() {
    let triangles = sphere(30);
    for exponent in [-20, -3, 3, 20] {
        let mut numbers = Numbers::new(31);
        let rays = (0..2000).map(|_| {
            let origin = numbers.point().map(|x| x - 0.5);
            ray(origin, numbers.direction().map(|x| x * 10f32.powi(exponent)))
        });
        let name = format!("directions of length 1e{exponent}");
        run(&Case::closed(&name, scene_of("sphere", &triangles), rays.collect()));
    }
}

#[test]
fn origins_on_surfaces_edges_and_corners() {
    for (name, triangles) in
        [("sphere", sphere(24)), ("box", cube(5)), ("soup", soup(&mut Numbers::new(32), 500, 0.4))]
    {
        let mut numbers = Numbers::new(33);
        let rays = (0..9_000).filter_map(|number| {
            let origin = match number % 3 {
                0 => numbers.surface_point(&triangles),
                1 => numbers.edge_point(&triangles),
                _ => numbers.corner(&triangles),
            };
            match number % 4 {
                0 => towards(origin, numbers.corner(&triangles)),
                1 => towards(origin, numbers.edge_point(&triangles)),
                _ => Some(ray(origin, numbers.direction())),
            }
        });
        run(&Case::open(format!("origins on a {name}"), scene_of(name, &triangles), rays.collect()));
    }
}

/// A ray cut at its own hit still hits, on either side; cut before or after, it does not.
#[test]
fn ends_at_the_hit_count() {
    let scene = scene_of("sphere", &placed(&sphere(24), 3.0, [1.0, -2.0, 0.5]));
    let mut numbers = Numbers::new(34);
    let rays: Vec<Ray> =
        (0..20_000).map(|_| ray(numbers.point().map(|x| x - 0.5), numbers.direction())).collect();
    for (backend, kernel) in kernels() {
        let plain = trace(backend, kernel, &scene, &rays);
        type Cut = fn(f32) -> (f32, f32);
        let cuts: [(Cut, bool); 4] = [
            (|t| (0.0, t), true),
            (|t| (t, f32::INFINITY), true),
            (|t| (0.0, t.next_down()), false),
            (|t| (t.next_up(), f32::INFINITY), false),
        ];
        for (number, (cut, is_found)) in cuts.into_iter().enumerate() {
            let cut_rays: Vec<Ray> = rays
                .iter()
                .zip(&plain.hits)
                .map(|(ray, hit)| {
                    let (t_min, t_max) = cut(if hit.is_hit() { hit.t } else { 1.0 });
                    Ray { t_min, t_max, ..*ray }
                })
                .collect();
            let found = trace(backend, kernel, &scene, &cut_rays);
            let both = plain.hits.iter().zip(&found.hits).filter(|(plain, _)| plain.is_hit());
            let wrong = both.filter(|(plain, found)| (plain == found) != is_found).count();
            println!("{}, cut {number}: {wrong} of {} rays differ", plain.name, rays.len());
            assert!(kernel == TraceKernel::RayQuery || wrong == 0, "{}, cut {number}: {wrong}", plain.name);
        }
    }
}

/// Rays that test more than 65,535 triangles and as many nodes before they find their hit, beyond which
/// some drivers end loops.
#[test]
fn loops_of_a_hundred_thousand() {
    // Large triangles beside the rays in boxes around the rays, and one behind them all.
    let mut triangles: Vec<Triangle> = (0..120_000)
        .map(|number| {
            let z = 1.0 + number as f32 * 1e-5;
            [[-1.0, 1.0, z], [1.0, -1.0, z + 0.01], [1.0, 1.0, z]]
        })
        .collect();
    triangles.push([[-9.0, -9.0, 5.0], [9.0, -9.0, 5.0], [0.0, 9.0, 5.0]]);
    let mut numbers = Numbers::new(35);
    let rays: Vec<Ray> = (0..64)
        .map(|_| ray([-0.05 - 0.1 * numbers.unit(), -0.05 - 0.1 * numbers.unit(), 0.0], [0.0, 0.0, 1.0]))
        .collect();
    let scene = scene_of("deep", &triangles);
    let tracer = CpuTracer::new(&scene, &build(&scene, BvhKind::Bvh2).unwrap());
    let work = tracer.work(&rays, Kind::Closest);
    assert!(work.iter().all(|work| work.triangles > 100_000), "{:?}", work[0]);
    run(&Case::closed("loops of a hundred thousand", scene, rays));
    assert!(kernels().iter().any(|(backend, _)| *backend == Backend::Gpu));
}
