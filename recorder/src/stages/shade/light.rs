//! Next-event estimation: a light is picked from the table of emitters, and a direction to it.

use std::f32::consts::PI;

use glam::Vec3;

use super::emitters::{EMITTER_DIRECTIONAL, EMITTER_POINT, EMITTER_SPHERE, EMITTER_SPOT, EMITTER_TRIANGLE};
use super::surface::offset_origin;
use super::tables::ShadeTables;
use crate::stages::random::{Random, sine_cosine};
use crate::stages::shared::Emitter;
use crate::stages::vector::{basis, cross3, dot3, normalize3};

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

/// Radiance of the sky in a direction.
#[inline(always)]
pub fn sky_radiance(zenith: Vec3, nadir: Vec3, direction: Vec3) -> Vec3 {
    nadir + (zenith - nadir) * (0.5 * direction.y + 0.5)
}

/// Numbers that picking a light and a direction to it uses.
pub const LIGHT_DRAWS: u32 = 4;

/// Picks a light and a direction to it from `point`. Uses [`LIGHT_DRAWS`] numbers; `None` where the pick
/// brings nothing.
#[inline(always)]
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
    #[inline(always)]
    fn new(emitter: &Emitter, direction: Vec3, t_max: f32, weight: Vec3, density: f32) -> Self {
        Self { direction, t_max, weight, density, light: emitter.light }
    }
}

/// Uniform over the cone of directions that meet the sphere.
#[inline(always)]
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

#[inline(always)]
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
#[inline(always)]
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
#[inline(always)]
fn sample_sky(tables: &ShadeTables, emitter: &Emitter, a: f32, b: f32) -> LightSample {
    let z = 1.0 - 2.0 * a;
    let radius = (1.0 - z * z).max(0.0).sqrt();
    let turn = sine_cosine(b);
    let direction = Vec3::new(radius * turn.1, radius * turn.0, z);
    let radiance = sky_radiance(tables.zenith, tables.nadir, direction);
    LightSample::new(emitter, direction, f32::INFINITY, radiance * (4.0 * PI), tables.sky_density)
}
