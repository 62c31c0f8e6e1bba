//! Rooms without a formula, against a path tracer over the oracle.

use recorder::stages::random::Random;
use scenes::{Light, Scene};
use tests::shapes::{cube, placed, sphere};

use crate::path_tracer::Reference;
use crate::picture::{Estimate, expect};
use crate::scene::{SceneOf, glowing, matt, parallelogram};

/// Samples of the picture's mean, one per path, in f64.
fn reference(scene: &Scene, bounces: u32, paths: u32) -> Estimate {
    let reference = Reference::new(scene);
    let camera = &scene.cameras[0];
    let half = f64::from(0.5 * camera.yfov_radians).tan();
    Estimate::of((0..paths).map(|path| {
        let mut random = Random::new([99, 1], path, 0, 0);
        let mut draw = || f64::from(random.draw());
        let (x, y) = (half * (2.0 * draw() - 1.0), half * (2.0 * draw() - 1.0));
        let direction = [0, 1, 2].map(|axis| {
            f64::from(camera.forward[axis])
                + x * f64::from(camera.right[axis])
                + y * f64::from(camera.up[axis])
        });
        reference.radiance(camera.eye.map(f64::from), direction, bounces, &mut draw)[1]
    }))
}

/// A room with a lamp and a ball between them: shadows, colours of walls on each other.
#[test]
fn a_room_with_a_lamp_and_a_ball() {
    let lamp = parallelogram([-0.6, 0.98, -0.6], [1.2, 0.0, 0.0], [0.0, 0.0, 1.2]);
    let scene = SceneOf::seen([0.0, 0.2, 0.95], [0.0, -0.3, -1.0], 60.0)
        .surface(&cube(1), matt(0.7))
        .surface(&placed(&sphere(8), 0.35, [0.0; 3]), matt(0.4))
        .surface(&lamp, glowing(0.1, 3.0))
        .scene();
    for bounces in [1, 3] {
        let known = reference(&scene, bounces, 200_000);
        expect(&format!("room with a lamp, {bounces} bounces"), &scene, bounces, known);
    }
}

/// Open sky that is brighter above, and a sphere light, over a ball on a floor.
#[test]
fn a_ball_on_a_floor_under_sky_and_lamp() {
    let floor = parallelogram([-2.0, -0.5, -2.0], [4.0, 0.0, 0.0], [0.0, 0.0, 4.0]);
    let sky = scenes::Environment { zenith: [0.2, 0.8, 1.0], nadir: [0.4, 0.1, 0.3] };
    let scene = SceneOf::seen([0.0, 1.0, 3.0], [0.0, -0.2, 0.0], 40.0)
        .surface(&floor, matt(0.8))
        .surface(&placed(&sphere(8), 0.5, [0.0; 3]), matt(0.6))
        .light(Light::Sphere { position: [0.9, 0.9, 0.4], radius: 0.3, intensity: [0.5; 3] })
        .light(Light::Environment(sky))
        .scene();
    let known = reference(&scene, 3, 200_000);
    expect("ball under sky and lamp, 3 bounces", &scene, 3, known);
}
