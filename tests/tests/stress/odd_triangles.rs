//! Triangles that are thin, degenerate, doubled, overlapping or all the same, and scenes of hardly any.

use formats::ray::{Hit, Ray};
use scenes::bvh::{BvhError, BvhKind, build};

use crate::numbers::{Numbers, ray, rays_around, towards};
use crate::runner::{Case, kernels, run, trace};
use crate::shapes::{Triangle, on_a_grid, scene_of, slivers, soup, unclean};

/// Rays at corners, edges and surfaces of triangles and past them, from the unit cube.
fn aimed(numbers: &mut Numbers, triangles: &[Triangle], count: usize) -> Vec<Ray> {
    let rays = (0..count).filter_map(|number| {
        let origin = numbers.point().map(|x| 2.0 * x - 0.5);
        match number % 4 {
            0 => towards(origin, numbers.corner(triangles)),
            1 => towards(origin, numbers.edge_point(triangles)),
            2 => towards(origin, numbers.surface_point(triangles)),
            _ => Some(ray(origin, numbers.direction())),
        }
    });
    rays.collect()
}

fn check(name: &str, seed: u32, triangles: &[Triangle]) {
    let rays = aimed(&mut Numbers::new(seed), triangles, 3_000);
    run(&Case::open(name, scene_of(name, triangles), rays));
}

#[test]
fn soups() {
    check("soup of large triangles", 10, &soup(&mut Numbers::new(10), 200, 1.0));
    check("soup of small triangles", 11, &soup(&mut Numbers::new(11), 5000, 0.02));
}

#[test]
fn slivers_of_aspect_1e7() {
    check("loose slivers", 12, &slivers(&mut Numbers::new(12), 1000));
}

#[test]
fn degenerate_doubled_coplanar_and_overlapping_triangles() {
    check("unclean", 13, &unclean(&mut Numbers::new(13)));
    check("on a grid", 14, &on_a_grid(&mut Numbers::new(14), 500));
}

#[test]
fn of_identical_triangles_the_first_is_hit() {
    let triangle = [[0.0, 0.0, 0.25], [1.0, 0.0, 0.5], [0.0, 1.0, 0.125]];
    let elsewhere = |number: usize| triangle.map(|corner| corner.map(|x| x + 0.01 * number as f32));
    let triangles: Vec<Triangle> = (0..10_000)
        .map(|number| if number % 7 == 3 { triangle } else { elsewhere(1 + number % 5) })
        .collect();
    let scene = scene_of("copies", &triangles);
    let rays: Vec<Ray> = aimed(&mut Numbers::new(15), &[triangle], 500)
        .into_iter()
        .map(|ray| Ray { origin: [ray.origin[0], ray.origin[1], -1.0], direction: [0.0, 0.0, 1.0], ..ray })
        .collect();
    let expected = trace_all(&scene_of("one", &[triangle]), &rays);
    for (backend, kernel) in kernels() {
        let answers = trace(backend, kernel, &scene, &rays);
        if kernel == recorder::stages::trace::TraceKernel::RayQuery {
            continue; // Which of equal triangles it finds is the driver's affair.
        }
        let mut compared = 0;
        for (hit, alone) in answers.hits.iter().zip(&expected).filter(|(_, alone)| alone.is_hit()) {
            assert_eq!((hit.t, hit.triangle), (alone.t, 3), "{}", answers.name);
            compared += 1;
        }
        assert!(compared > 50, "only {compared} rays hit the copies");
    }
    run(&Case::open("all identical", scene_of("identical", &vec![triangle; 1_000]), rays));
}

fn trace_all(scene: &scenes::Scene, rays: &[Ray]) -> Vec<Hit> {
    let (backend, kernel) = kernels()[0];
    trace(backend, kernel, scene, rays).hits
}

#[test]
fn scenes_of_none_one_and_two_triangles() {
    for kind in BvhKind::ALL {
        let refused = build(&scene_of("empty", &[]), kind);
        assert!(matches!(refused, Err(BvhError::NoTriangles { .. })), "{kind}: {refused:?}");
    }
    let two = soup(&mut Numbers::new(16), 2, 1.0);
    check("one triangle", 16, &two[..1]);
    check("two triangles", 17, &two);
}

#[test]
fn boxes_without_extent_in_one_two_and_three_axes() {
    let mut numbers = Numbers::new(18);
    for axis in 0..3 {
        let mut flat = soup(&mut numbers, 500, 0.3);
        flat.as_flattened_mut().iter_mut().for_each(|corner| corner[axis] = 0.375);
        check(&format!("flat along axis {axis}"), 18, &flat);
        let mut line = flat.clone();
        line.as_flattened_mut().iter_mut().for_each(|corner| corner[(axis + 1) % 3] = 0.5);
        check(&format!("a line along axis {}", (axis + 2) % 3), 19, &line);
    }
    check("a point", 20, &vec![[[0.25, 0.5, 0.75]; 3]; 100]);
    // One flat face of a closed box is not more than the others: rays in its plane and through it.
    let square: Vec<Triangle> = crate::shapes::cut_box([&[0.0, 1.0], &[0.0, 0.5, 1.0], &[0.5, 0.5]]);
    let mut rays = rays_around(&mut numbers, 2000);
    rays.iter_mut().step_by(2).for_each(|ray| ray.origin[2] = 0.5);
    run(&Case::open("a box without height", scene_of("flat box", &square), rays));
}
