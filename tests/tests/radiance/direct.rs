//! Light that comes straight: from a sphere, from a square, over mirrors.

use std::f64::consts::{PI, TAU};

use scenes::Light;

use crate::picture::{exactly, expect, mean_over_picture, pictures};
use crate::scene::{SceneOf, glowing, matt, mirror, parallelogram};

const REFLECTANCE: f32 = 0.5;

/// Where a ray meets the floor y = 0.
fn on_floor(eye: [f64; 3], direction: [f64; 3]) -> [f64; 3] {
    let t = -eye[1] / direction[1];
    [eye[0] + t * direction[0], 0.0, eye[2] + t * direction[2]]
}

/// A floor, and a camera that sees nothing else.
fn floor_from(eye: [f32; 3]) -> SceneOf {
    let floor = parallelogram([-50.0, 0.0, -50.0], [100.0, 0.0, 0.0], [0.0, 0.0, 100.0]);
    SceneOf::seen(eye, [0.3, 0.0, -0.2], 30.0).surface(&floor, matt(REFLECTANCE))
}

/// A sphere wholly above a plane lights it as a point would: I·cos θ / d².
#[test]
fn a_sphere_light_over_a_floor() {
    for (position, radius) in [([0.5, 1.5, 0.25], 0.05), ([0.0, 2.0, 0.0], 0.9)] {
        let intensity = [3.0; 3];
        let scene = floor_from([2.0, 3.0, 1.0]).light(Light::Sphere { position, radius, intensity }).scene();
        let known = mean_over_picture(&scene, |eye, direction| {
            let point = on_floor(eye, direction);
            let to = [0, 1, 2].map(|axis| f64::from(position[axis]) - point[axis]);
            let squared: f64 = to.iter().map(|x| x * x).sum();
            f64::from(REFLECTANCE) / PI * f64::from(intensity[0]) * to[1] / squared.powf(1.5)
        });
        for bounces in [1, 2] {
            expect(&format!("sphere light of {radius}, {bounces} bounces"), &scene, bounces, exactly(known));
        }
    }
}

/// Irradiance of a polygon of radiance 1 on a floor that faces up (Lambert's formula: half the sum over
/// edges of the angle that each subtends times the cosine between the floor's normal and that of the
/// edge's plane).
fn lambert(point: [f64; 3], corners: &[[f64; 3]; 4]) -> f64 {
    let unit = corners.map(|corner| {
        let v = [0, 1, 2].map(|axis| corner[axis] - point[axis]);
        let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
        v.map(|x| x / length)
    });
    let sum: f64 = (0..4)
        .map(|first| {
            let (a, b) = (unit[first], unit[(first + 1) % 4]);
            let normal = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
            let sine = normal.iter().map(|x| x * x).sum::<f64>().sqrt();
            let cosine: f64 = (0..3).map(|axis| a[axis] * b[axis]).sum();
            sine.atan2(cosine) * normal[1] / sine
        })
        .sum();
    (sum / 2.0).abs()
}

/// A square lamp over a floor, found by light samples alone (one bounce) and by both ways of sampling (two).
#[test]
fn a_square_light_over_a_floor() {
    let radiance = 4.0f32;
    let lamp = parallelogram([-0.5, 1.2, -0.4], [1.0, 0.0, 0.0], [0.0, 0.0, 1.3]);
    let scene = floor_from([2.2, 1.0, 2.0]).surface(&lamp, glowing(0.0, radiance)).scene();
    let corners = [[-0.5, 1.2, -0.4], [0.5, 1.2, -0.4], [0.5, 1.2, 0.9], [-0.5, 1.2, 0.9]];
    let known = mean_over_picture(&scene, |eye, direction| {
        f64::from(REFLECTANCE) / PI * f64::from(radiance) * lambert(on_floor(eye, direction), &corners)
    });
    for bounces in [1, 2] {
        expect(&format!("square light, {bounces} bounces"), &scene, bounces, exactly(known));
    }
}

/// A lamp seen over three mirrors has its own radiance, once per mirror times what that reflects at 45° by
/// Schlick's formula. Nothing is drawn at random, so every pixel is right.
#[test]
fn a_lamp_over_a_chain_of_mirrors() {
    let radiance = 2.5f32;
    for reflectance in [1.0f32, 0.4] {
        // The view runs along −z, is turned to +x, to +y and to +z again.
        let slanted = [
            parallelogram([-1.0, -1.0, -4.0], [2.0, 0.0, -2.0], [0.0, 2.0, 0.0]),
            parallelogram([4.0, -1.0, -6.0], [2.0, 2.0, 0.0], [0.0, 0.0, 2.0]),
            parallelogram([4.0, 4.0, -6.0], [2.0, 0.0, 0.0], [0.0, 2.0, 2.0]),
        ];
        let lamp = parallelogram([4.0, 4.0, 1.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]);
        let seen = SceneOf::seen([0.0; 3], [0.0, 0.0, -5.0], 0.5);
        let chain = slanted.iter().fold(seen, |scene, glass| scene.surface(glass, mirror(reflectance)));
        let scene = chain.surface(&lamp, glowing(0.0, radiance)).scene();
        let f0 = f64::from(reflectance);
        let schlick = f0 + (1.0 - f0) * (1.0 - (TAU / 8.0).cos()).powi(5);
        let known = f64::from(radiance) * schlick.powi(3);
        for (backend, pixels) in pictures(&scene, 4, false) {
            let worst = pixels.iter().map(|pixel| (pixel - known).abs() / known).fold(0.0, f64::max);
            println!("mirrors of {reflectance} {backend}: off by {worst:.1e} at most");
            // The angle varies by a quarter of a degree over the picture.
            let allowed = if reflectance == 1.0 { 1e-5 } else { 5e-3 };
            assert!(worst < allowed, "mirrors of {reflectance} on {backend}: off by {worst}");
        }
    }
}
