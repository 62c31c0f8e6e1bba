//! The table of emitters that next-event estimation picks from, by power, and how each is sampled.

use std::f32::consts::PI;

use glam::Vec3;
use scenes::{Light, Scene};

use super::surface::offset_origin;
use super::tables::ShadeTables;
use crate::stages::random::{Random, sine_cosine};
use crate::stages::shared::Emitter;
use crate::stages::vector::{basis, cross3, dot3, luminance, normalize3};

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

/// Shadow rays to a triangle end this share of the way before it, so that it does not block them.
pub const SHORT_OF_TRIANGLE: f32 = 0.9999;

/// A direction towards a light.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// Unit vector from the surface.
    pub direction: Vec3,
    /// How far the shadow ray goes.
    pub t_max: f32,
    /// Radiance (or irradiance of a light without extent) over the density of picking it.
    pub weight: Vec3,
    /// Density over solid angle if reflection could find the same light, else 0.
    pub density: f32,
    /// Index of the scene's light.
    pub light: u32,
}

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

/// Radiance of the sky in a direction.
pub fn sky_radiance(zenith: Vec3, nadir: Vec3, direction: Vec3) -> Vec3 {
    nadir + (zenith - nadir) * (0.5 * direction.y + 0.5)
}

/// Numbers that picking a light and a direction to it uses.
pub const LIGHT_DRAWS: u32 = 4;

/// Picks a light and a direction to it from `point`. Uses [`LIGHT_DRAWS`] numbers; `None` where the pick
/// brings nothing.
pub fn sample_light(tables: &ShadeTables, point: Vec3, random: &mut Random) -> Option<LightSample> {
    let count = tables.emitters.len() as u32;
    let (slot, choice, a, b) = (random.draw(), random.draw(), random.draw(), random.draw());
    let slot = ((slot * count as f32) as u32).min(count - 1);
    let drawn = &tables.emitters[slot as usize];
    let emitter = if choice < drawn.keep { drawn } else { &tables.emitters[drawn.other as usize] };
    let sample = match emitter.shape {
        EMITTER_SPHERE => sample_sphere(emitter, point, a, b)?,
        EMITTER_POINT | EMITTER_SPOT => sample_point(emitter, point)?,
        EMITTER_DIRECTIONAL => LightSample::new(
            emitter,
            -Vec3::from(emitter.direction),
            f32::INFINITY,
            Vec3::from(emitter.power),
            0.0,
        ),
        EMITTER_TRIANGLE => sample_triangle(emitter, point, a, b)?,
        _ => sample_sky(tables, emitter, a, b),
    };
    Some(LightSample { weight: sample.weight * (1.0 / emitter.probability), ..sample })
}

impl LightSample {
    fn new(emitter: &Emitter, direction: Vec3, t_max: f32, weight: Vec3, density: f32) -> Self {
        Self { direction, t_max, weight, density, light: emitter.light }
    }
}

/// Uniform over the cone of directions that meet the sphere.
fn sample_sphere(emitter: &Emitter, point: Vec3, a: f32, b: f32) -> Option<LightSample> {
    let to_centre = Vec3::from(emitter.position) - point;
    let distance2 = dot3(to_centre, to_centre);
    let radius2 = emitter.extent * emitter.extent;
    if distance2 <= radius2 {
        return None;
    }
    let distance = distance2.sqrt();
    let sine2_max = radius2 / distance2;
    let one_minus_cosine_max = sine2_max / (1.0 + (1.0 - sine2_max).sqrt());
    let one_minus_cosine = a * one_minus_cosine_max;
    let cosine = 1.0 - one_minus_cosine;
    let sine2 = one_minus_cosine * (2.0 - one_minus_cosine);
    let sine = sine2.sqrt();
    let turn = sine_cosine(b);
    let axis = to_centre * (1.0 / distance);
    let (tangent, bitangent) = basis(axis);
    let direction = normalize3(tangent * (sine * turn.1) + bitangent * (sine * turn.0) + axis * cosine);
    let t_max = distance * cosine - (radius2 - distance2 * sine2).max(0.0).sqrt();
    // Radiance is intensity over πr², the cone's solid angle 2π(1 − cos).
    let weight = Vec3::from(emitter.power) * (2.0 * one_minus_cosine_max / radius2);
    Some(LightSample::new(emitter, direction, t_max, weight, 0.0))
}

fn sample_point(emitter: &Emitter, point: Vec3) -> Option<LightSample> {
    let to_light = Vec3::from(emitter.position) - point;
    let distance2 = dot3(to_light, to_light);
    if distance2 <= 0.0 {
        return None;
    }
    let distance = distance2.sqrt();
    let direction = to_light * (1.0 / distance);
    let mut falloff = 1.0;
    if emitter.shape == EMITTER_SPOT {
        let cosine = -dot3(direction, Vec3::from(emitter.direction));
        let linear = (cosine * emitter.cone_scale + emitter.extent).clamp(0.0, 1.0);
        falloff = linear * linear;
    }
    let weight = Vec3::from(emitter.power) * (falloff / distance2);
    (falloff > 0.0).then(|| LightSample::new(emitter, direction, distance, weight, 0.0))
}

/// Uniform over the triangle's area.
fn sample_triangle(emitter: &Emitter, point: Vec3, a: f32, b: f32) -> Option<LightSample> {
    let [p, q, r] = [emitter.position, emitter.direction, emitter.third_corner].map(Vec3::from);
    let root = a.sqrt();
    let (u, v) = (root * (1.0 - b), root * b);
    let normal = normalize3(cross3(q - p, r - p));
    let on_light = p + (q - p) * u + (r - p) * v;
    let facing = if dot3(normal, point - on_light) < 0.0 { -normal } else { normal };
    let to_light = offset_origin(on_light, facing, q - p, r - p) - point;
    let distance2 = dot3(to_light, to_light);
    let distance = distance2.sqrt();
    let direction = to_light * (1.0 / distance);
    let cosine = -dot3(direction, facing);
    let is_seen = cosine > 1e-6 && distance > 0.0;
    if !is_seen {
        return None;
    }
    let density_over_area = 1.0 / emitter.extent;
    let density = density_over_area * distance2 / cosine;
    let light_density = density * emitter.probability;
    let weight = Vec3::from(emitter.power) * (1.0 / density);
    Some(LightSample::new(emitter, direction, distance * SHORT_OF_TRIANGLE, weight, light_density))
}

/// Uniform over all directions.
fn sample_sky(tables: &ShadeTables, emitter: &Emitter, a: f32, b: f32) -> LightSample {
    let z = 1.0 - 2.0 * a;
    let radius = (1.0 - z * z).max(0.0).sqrt();
    let turn = sine_cosine(b);
    let direction = Vec3::new(radius * turn.1, radius * turn.0, z);
    let radiance = sky_radiance(tables.zenith, tables.nadir, direction);
    LightSample::new(emitter, direction, f32::INFINITY, radiance * (4.0 * PI), tables.sky_density)
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
