//! The table of emitters that next-event estimation picks from, by power.

use glam::Vec3;
use scenes::{Light, Scene};

use crate::stages::shared::Emitter;
use crate::stages::vector::{cross3, dot3, luminance};

/// Shape of a sphere light.
pub const EMITTER_SPHERE: u32 = 0;
/// Shape of a point without extent.
pub const EMITTER_POINT: u32 = 1;
/// Shape of a cone of light.
pub const EMITTER_SPOT: u32 = 2;
/// Shape of parallel light.
pub const EMITTER_DIRECTIONAL: u32 = 3;
/// Shape of one emissive triangle.
pub const EMITTER_TRIANGLE: u32 = 4;
/// Shape of the sky.
pub const EMITTER_SKY: u32 = 5;

/// Emitters of a scene, with their picking probabilities in proportion to power.
///
/// Returns the table, the total power and the sky's picking probability.
pub(super) fn build(scene: &Scene) -> (Vec<Emitter>, f64, f32) {
    let bounds = scene.bounds();
    let radius = f64::from(0.5 * Vec3::from(bounds.extent()).length());
    let disk = std::f64::consts::PI * radius * radius;
    let mut emitters = Vec::new();
    let mut powers: Vec<f64> = Vec::new();
    for (index, light) in scene.lights.iter().enumerate() {
        let mut add = |emitter: Emitter, power: f64| {
            if power > 0.0 {
                emitters.push(Emitter { light: index as u32, ..emitter });
                powers.push(power);
            }
        };
        add_light(scene, light, disk, &mut add);
    }
    cap_sky(&emitters, &mut powers);
    let total: f64 = powers.iter().sum();
    for (emitter, power) in emitters.iter_mut().zip(&powers) {
        emitter.probability = (power / total) as f32;
    }
    fill_aliases(&mut emitters, &powers, total);
    let sky = emitters.iter().find(|emitter| emitter.shape == EMITTER_SKY);
    let sky_probability = sky.map_or(0.0, |emitter| emitter.probability);
    (emitters, total, sky_probability)
}

/// Lets the sky be picked no more often than all other lights together: what of its power falls on the
/// scene's disk hardly gets indoors, where lamps would starve. Weights stay right whatever is picked.
fn cap_sky(emitters: &[Emitter], powers: &mut [f64]) {
    let Some(sky) = emitters.iter().position(|emitter| emitter.shape == EMITTER_SKY) else { return };
    let others = powers.iter().sum::<f64>() - powers[sky];
    if others > 0.0 {
        powers[sky] = powers[sky].min(others);
    }
}

/// Luminous power of an emissive triangle per area and luminance: both sides, a hemisphere each.
pub(super) const POWER_PER_AREA: f64 = 2.0 * std::f64::consts::PI;

fn add_light(scene: &Scene, light: &Light, disk: f64, add: &mut impl FnMut(Emitter, f64)) {
    let bright = |color: [f32; 3]| f64::from(luminance(Vec3::from(color)));
    let sphere = 4.0 * std::f64::consts::PI;
    let new = |shape, power| Emitter { shape, power, ..Emitter::default() };
    match *light {
        Light::Sphere { position, radius, intensity } => {
            add(
                Emitter { position, extent: radius, ..new(EMITTER_SPHERE, intensity) },
                bright(intensity) * sphere,
            );
        }
        Light::Point { position, intensity } => {
            add(Emitter { position, ..new(EMITTER_POINT, intensity) }, bright(intensity) * sphere);
        }
        Light::Spot { position, direction, intensity, inner_cone_cos, outer_cone_cos } => {
            // glTF KHR_lights_punctual, "Inner and Outer Cone Angles".
            let cone_scale = 1.0 / (inner_cone_cos - outer_cone_cos).max(0.001);
            let extent = -outer_cone_cos * cone_scale;
            let share = f64::from(1.0 - outer_cone_cos) * 0.5;
            add(
                Emitter { position, direction, cone_scale, extent, ..new(EMITTER_SPOT, intensity) },
                bright(intensity) * sphere * share,
            );
        }
        Light::Directional { direction, irradiance } => {
            add(Emitter { direction, ..new(EMITTER_DIRECTIONAL, irradiance) }, bright(irradiance) * disk);
        }
        Light::Emissive { first_triangle, triangle_count } => {
            for triangle in first_triangle..first_triangle + triangle_count {
                let material = &scene.materials[scene.triangle_materials[triangle as usize] as usize];
                let corners = scene.corners(triangle as usize);
                let [a, b, c] = corners.map(Vec3::from);
                let normal = cross3(b - a, c - a);
                let area = 0.5 * dot3(normal, normal).sqrt();
                let power = bright(material.emission) * f64::from(area) * POWER_PER_AREA;
                let [position, direction, third_corner] = corners;
                let lamp = new(EMITTER_TRIANGLE, material.emission);
                add(Emitter { position, direction, third_corner, extent: area, ..lamp }, power);
            }
        }
        Light::Environment(sky) => {
            let mean = [0, 1, 2].map(|channel| 0.5 * (sky.zenith[channel] + sky.nadir[channel]));
            add(new(EMITTER_SKY, mean), bright(mean) * sphere * disk);
        }
    }
}

/// Vose's construction of the alias table ("A Linear Algorithm for Generating Random Numbers with a
/// Given Distribution", 1991).
fn fill_aliases(emitters: &mut [Emitter], powers: &[f64], total: f64) {
    let mut shares: Vec<f64> = powers.iter().map(|power| power / total * powers.len() as f64).collect();
    let (mut small, mut large): (Vec<usize>, Vec<usize>) =
        (0..shares.len()).partition(|&slot| shares[slot] < 1.0);
    for (slot, emitter) in emitters.iter_mut().enumerate() {
        (emitter.keep, emitter.other) = (1.0, slot as u32);
    }
    while let (Some(&low), Some(&high)) = (small.last(), large.last()) {
        small.pop();
        (emitters[low].keep, emitters[low].other) = (shares[low] as f32, high as u32);
        shares[high] -= 1.0 - shares[low];
        if shares[high] < 1.0 {
            large.pop();
            small.push(high);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sky_leaves_room_for_lamps() {
        let shaped = |shape| Emitter { shape, ..Emitter::default() };
        let emitters = [shaped(EMITTER_SPHERE), shaped(EMITTER_SKY), shaped(EMITTER_TRIANGLE)];
        let mut powers = [3.0, 1e6, 1.0];
        cap_sky(&emitters, &mut powers);
        assert_eq!(powers, [3.0, 4.0, 1.0]);
        let mut alone = [1e6];
        cap_sky(&emitters[1..2], &mut alone);
        assert_eq!(alone, [1e6]);
    }

    #[test]
    fn aliases_give_every_emitter_its_share() {
        let powers = [5.0, 0.5, 3.0, 0.25, 1.25, 90.0];
        let total: f64 = powers.iter().sum();
        let mut emitters = vec![Emitter::default(); powers.len()];
        fill_aliases(&mut emitters, &powers, total);
        let mut shares = vec![0.0f64; powers.len()];
        for (slot, emitter) in emitters.iter().enumerate() {
            shares[slot] += f64::from(emitter.keep);
            shares[emitter.other as usize] += 1.0 - f64::from(emitter.keep);
        }
        for (share, power) in shares.iter().zip(powers) {
            assert!((share / powers.len() as f64 - power / total).abs() < 1e-6, "{shares:?}");
        }
    }
}
