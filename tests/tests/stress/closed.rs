//! Closed surfaces: no ray leaves them, wherever they are, however small, large, thin or spiky.

use crate::numbers::{Numbers, rays_from_inside, towards};
use crate::runner::{Case, run};
use crate::shapes::{FAR_AWAY, cube, placed, scene_of, sliver_box, sphere, spiky_sphere, turned_sliver_box};

/// Rays that the GPU traces and the oracle judges of millions.
const SAMPLE: usize = 30_000;

/// Of 159,200 triangles; far away, a triangle is two units in the last place wide, if it has an area at all.
#[test]
fn two_million_rays_stay_in_spheres() {
    for (name, centre) in [("sphere", [0.0; 3]), ("sphere far away", FAR_AWAY)] {
        let triangles = placed(&sphere(200), 2.0, centre);
        let rays = rays_from_inside(&mut Numbers::new(1), &triangles, centre, 1.5, 2_000_000);
        run(&Case::closed(name, scene_of(name, &triangles), rays).sample(SAMPLE));
    }
}

#[test]
fn two_million_rays_stay_in_boxes() {
    for (name, centre) in [("box", [0.0; 3]), ("box far away", FAR_AWAY)] {
        let triangles = placed(&cube(40), 100.0, centre);
        let rays = rays_from_inside(&mut Numbers::new(2), &triangles, centre, 99.0, 2_000_000);
        run(&Case::closed(name, scene_of(name, &triangles), rays).sample(SAMPLE));
    }
}

#[test]
fn scales_from_a_millionth_to_a_million() {
    for exponent in [-6, -3, 3, 6] {
        let name = format!("sphere of 1e{exponent}");
        let size = 10f32.powi(exponent);
        let triangles = placed(&sphere(40), size, [0.0; 3]);
        let rays = rays_from_inside(&mut Numbers::new(3), &triangles, [0.0; 3], 0.9 * size, 12_000);
        run(&Case::closed(&name, scene_of(&name, &triangles), rays));
    }
}

#[test]
fn a_hundred_thousand_rays_at_the_corners_of_a_spiky_sphere() {
    let triangles = spiky_sphere(16, 16);
    let mut numbers = Numbers::new(4);
    let rays = (0..100_000).filter_map(|_| {
        let (offset, part) = (numbers.direction(), 0.4 * numbers.unit());
        towards(offset.map(|x| part * x), numbers.corner(&triangles))
    });
    run(&Case::closed("spiky sphere", scene_of("spiky", &triangles), rays.collect()).sample(SAMPLE));
}

#[test]
fn strips_of_aspect_1e7_close_a_box() {
    for (name, triangles) in [("sliver box", sliver_box()), ("turned sliver box", turned_sliver_box())] {
        let rays = rays_from_inside(&mut Numbers::new(5), &triangles, [0.0; 3], 0.9, 24_000);
        run(&Case::closed(name, scene_of(name, &triangles), rays));
    }
}
