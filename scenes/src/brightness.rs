//! About how bright a scene's lights make it, so that nobody waits for a black picture unwarned.

use glam::DVec3;
use rayon::prelude::*;

use crate::automatic;
use crate::bounds::Bounds;
use crate::{Camera, Light, Scene};

/// Mean radiance below which a picture looks black: three of 255 steps in sRGB.
const MIN_RADIANCE: f64 = 1e-3;
/// What surfaces reflect, about.
const REFLECTANCE: f64 = 0.5;

/// Whether the lights of a scene leave what `camera` sees nearly black: their power, spread over all
/// surfaces, is a generous estimate, since much of it misses them.
pub(crate) fn is_dark(scene: &Scene, camera: &Camera) -> bool {
    let bounds = scene.bounds();
    let area: f64 = (0..scene.triangles.len()).into_par_iter().map(|triangle| area(scene, triangle)).sum();
    if !(area > 0.0 && area.is_finite()) {
        return false;
    }
    let is_bright = |irradiance: f64| REFLECTANCE * irradiance / std::f64::consts::PI >= MIN_RADIANCE;
    let inside: f64 = scene.lights.iter().map(|light| irradiance_inside(scene, light, &bounds, area)).sum();
    if is_bright(inside) {
        return false;
    }
    let outside: f64 = scene.lights.iter().map(irradiance_outside).sum();
    !is_bright(inside + outside) || automatic::is_closed(scene, camera)
}

/// What arrives of a light that is somewhere: its power over the area of all surfaces, or what arrives at the
/// scene's box from a light beyond it.
fn irradiance_inside(scene: &Scene, light: &Light, bounds: &Bounds, area: f64) -> f64 {
    match *light {
        Light::Sphere { position, intensity, .. }
        | Light::Point { position, intensity }
        | Light::Spot { position, intensity, .. } => {
            let beyond = DVec3::from_array([0, 1, 2].map(|axis| {
                f64::from((bounds.min[axis] - position[axis]).max(position[axis] - bounds.max[axis]).max(0.0))
            }));
            let inside = 4.0 * std::f64::consts::PI / area;
            mean(intensity) * (1.0 / beyond.length_squared()).min(inside)
        }
        Light::Emissive { first_triangle, triangle_count } => {
            let triangles = first_triangle as usize..(first_triangle + triangle_count) as usize;
            let power = |triangle: usize| {
                let material = &scene.materials[scene.triangle_materials[triangle] as usize];
                std::f64::consts::PI * mean(material.emission) * self::area(scene, triangle)
            };
            triangles.map(power).sum::<f64>() / area
        }
        Light::Directional { .. } | Light::Environment(_) => 0.0,
    }
}

/// What arrives of a light at infinity where nothing is in its way.
fn irradiance_outside(light: &Light) -> f64 {
    match light {
        Light::Directional { irradiance, .. } => mean(*irradiance),
        Light::Environment(sky) => std::f64::consts::PI * 0.5 * (mean(sky.zenith) + mean(sky.nadir)),
        _ => 0.0,
    }
}

fn mean(color: [f32; 3]) -> f64 {
    color.iter().map(|&channel| f64::from(channel)).sum::<f64>() / 3.0
}

/// Square world units.
fn area(scene: &Scene, triangle: usize) -> f64 {
    let [a, b, c] = scene.corners(triangle).map(|corner| DVec3::from_array(corner.map(f64::from)));
    0.5 * (b - a).cross(c - a).length()
}
