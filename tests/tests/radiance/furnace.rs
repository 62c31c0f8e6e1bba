//! Furnaces: surroundings of one radiance everywhere, in which a surface is as bright as it is white.

use scenes::Material;
use tests::shapes::{cube, sphere};

use crate::picture::{Estimate, exactly, expect, expect_with_roulette, pictures};
use crate::scene::{SceneOf, glowing, matt};

/// A sphere that reflects everything cannot be told from the white sky around it, one that reflects half
/// is half as bright. The picture shows the sphere alone.
#[test]
fn a_white_sphere_vanishes_in_a_white_sky() {
    for reflectance in [1.0, 0.5] {
        for bounces in [1, 2, 4] {
            let seen = SceneOf::seen([0.0, 0.3, 4.0], [0.0; 3], 20.0);
            let scene = seen.surface(&sphere(12), matt(reflectance)).white_sky().scene();
            let what = format!("sphere of {reflectance} under the sky, {bounces} bounces");
            expect(&what, &scene, bounces, exactly(reflectance.into()));
        }
    }
}

/// In a closed room whose walls all glow and reflect, light of the k-th reflection is ρ^k of the walls'
/// own; the last of n bounces looks for light once more, so k goes up to n. For more and more bounces the sum
/// becomes E / (1 − ρ).
#[test]
fn a_glowing_room_adds_up_its_reflections() {
    let (emission, reflectance) = (0.7, 0.6f32);
    let known = |bounces: i32| {
        exactly((0..=bounces).map(|k| f64::from(emission) * f64::from(reflectance).powi(k)).sum())
    };
    let room = |walls: &[_]| {
        SceneOf::seen([0.1, 0.05, 0.2], [0.4, 0.1, -1.0], 40.0).surface(walls, glowing(reflectance, emission))
    };
    let (round, square) = (room(&sphere(10)).scene(), room(&cube(1)).scene());
    for bounces in [1, 2, 5] {
        expect(&format!("glowing sphere, {bounces} bounces"), &round, bounces as u32, known(bounces));
        expect(&format!("glowing box, {bounces} bounces"), &square, bounces as u32, known(bounces));
    }
    let limit = exactly(f64::from(emission) / (1.0 - f64::from(reflectance)));
    expect_with_roulette("glowing sphere, 30 bounces", &round, 30, limit);
}

/// No material under a white sky is brighter than the sky, however its lobes are mixed.
#[test]
fn no_surface_gains_energy() {
    for (metallic, roughness) in
        [(0.0, 0.0), (0.0, 0.3), (0.0, 0.8), (0.5, 0.5), (1.0, 0.0), (1.0, 0.2), (1.0, 1.0)]
    {
        let material = Material { metallic, roughness, ..matt(1.0) };
        let seen = SceneOf::seen([0.0, 0.3, 4.0], [0.0; 3], 20.0);
        let scene = seen.surface(&sphere(12), material).white_sky().scene();
        for (backend, pixels) in pictures(&scene, 3, false) {
            let found = Estimate::of(pixels);
            println!(
                "metallic {metallic}, roughness {roughness} {backend:8} {:.4} ± {:.4}",
                found.mean, found.error
            );
            let what = format!("metallic {metallic}, roughness {roughness} on {backend}: {found:?}");
            assert!(found.mean <= 1.0 + 3.0 * found.error + 2e-6, "{what}");
            // What microfacets reflect onto each other is lost, most of it where they are roughest.
            assert!(found.mean > 0.3, "{what} is hardly there");
        }
    }
}
