//! Next-event estimation: a light is picked from the table of emitters, and a direction to it, for eight surfaces at
//! once.

use std::array::from_fn;
use std::f32::consts::PI;
use std::hint::select_unpredictable;

use fearless_simd::prelude::*;
use fearless_simd::{f32x8, i32x8, mask32x8, u32x8};
use glam::Vec3;

use super::emitters::{
    EMITTER_DIRECTIONAL, EMITTER_POINT, EMITTER_SKY, EMITTER_SPHERE, EMITTER_SPOT, EMITTER_TRIANGLE,
};
use super::surface::offset_origins;
use super::tables::ShadeTables;
use crate::stages::eight::{LANES, Vec3x8, basis, cross3, dot3, normalize3};
use crate::stages::random::{RandomX8, sine_cosine};
use crate::stages::shared::Emitter;

/// Shadow rays to a triangle end this share of the way before it, so that it does not block them.
pub const SHORT_OF_TRIANGLE: f32 = 0.9999;

/// Directions towards lights.
#[derive(Clone, Copy, Debug)]
pub struct LightSample<S: Simd> {
    /// Whether the pick brings anything.
    pub is_there: mask32x8<S>,
    /// Unit vector from the surface.
    pub direction: Vec3x8<S>,
    /// How far the shadow ray goes.
    pub t_max: f32x8<S>,
    /// Radiance (or irradiance of a light without extent) over the density of picking it.
    pub weight: Vec3x8<S>,
    /// Density over solid angle if reflection could find the same light, else 0.
    pub density: f32x8<S>,
}

/// Radiance of the sky in directions.
#[inline(always)]
pub fn sky_radiance<S: Simd>(tables: &ShadeTables, direction: Vec3x8<S>) -> Vec3x8<S> {
    let simd = direction.x.token();
    let up = Vec3x8::splat(simd, tables.zenith - tables.nadir);
    Vec3x8::splat(simd, tables.nadir) + up * (0.5 * direction.y + 0.5)
}

/// Numbers that picking a light and a direction to it uses.
pub const LIGHT_DRAWS: u32 = 4;

/// The emitters that were picked, and a point on the unit square for each.
struct Picked<'a, S: Simd> {
    simd: S,
    emitters: [&'a Emitter; LANES],
    a: f32x8<S>,
    b: f32x8<S>,
}

/// Picks lights and directions to them from each point, and says which of the scene's lights they are. Uses
/// [`LIGHT_DRAWS`] numbers.
#[inline(always)]
pub fn sample_light<S: Simd>(
    tables: &ShadeTables,
    point: Vec3x8<S>,
    random: &mut RandomX8<S>,
) -> (LightSample<S>, [u32; LANES]) {
    let simd = point.x.token();
    let count = tables.emitters.len() as u32;
    let (slot, choice, a, b) = (random.draw(), random.draw(), random.draw(), random.draw());
    let slots: u32x8<S> = (slot * count as f32).to_int::<i32x8<S>>().bitcast();
    let slots = slots.min(count - 1);
    let emitters: [&Emitter; LANES] = from_fn(|lane| {
        let drawn = &tables.emitters[slots[lane] as usize];
        // Without a branch: which of the two it is cannot be guessed.
        let kept = select_unpredictable(choice[lane] < drawn.keep, slots[lane], drawn.other);
        &tables.emitters[kept as usize]
    });
    let picked = Picked { simd, emitters, a, b };
    let shapes = u32x8::from_fn(simd, |lane| emitters[lane].shape);
    let is_shape = |shape: u32| shapes.simd_eq(shape);
    let mut sample = picked.nothing();
    let is_sphere = is_shape(EMITTER_SPHERE);
    if is_sphere.any_true() {
        sample = picked.sphere(point).where_or(is_sphere, sample);
    }
    let is_spot = is_shape(EMITTER_SPOT);
    let is_punctual = is_shape(EMITTER_POINT) | is_spot;
    if is_punctual.any_true() {
        sample = picked.point(point, is_spot).where_or(is_punctual, sample);
    }
    let is_directional = is_shape(EMITTER_DIRECTIONAL);
    if is_directional.any_true() {
        sample = picked.directional().where_or(is_directional, sample);
    }
    let is_triangle = is_shape(EMITTER_TRIANGLE);
    if is_triangle.any_true() {
        sample = picked.triangle(point).where_or(is_triangle, sample);
    }
    let is_sky = is_shape(EMITTER_SKY);
    if is_sky.any_true() {
        sample = picked.sky(tables).where_or(is_sky, sample);
    }
    sample.weight = sample.weight * (1.0 / picked.number(|emitter| emitter.probability));
    (sample, from_fn(|lane| emitters[lane].light))
}

impl<S: Simd> LightSample<S> {
    /// Of each lane that of `self` where `mask` is set, else `other`'s.
    #[inline(always)]
    fn where_or(self, mask: mask32x8<S>, other: Self) -> Self {
        Self {
            is_there: self.is_there & mask | other.is_there & !mask,
            direction: self.direction.where_or(mask, other.direction),
            t_max: mask.select(self.t_max, other.t_max),
            weight: self.weight.where_or(mask, other.weight),
            density: mask.select(self.density, other.density),
        }
    }
}

impl<S: Simd> Picked<'_, S> {
    #[inline(always)]
    fn number(&self, of: impl Fn(&Emitter) -> f32) -> f32x8<S> {
        f32x8::from_fn(self.simd, |lane| of(self.emitters[lane]))
    }

    #[inline(always)]
    fn vector(&self, of: impl Fn(&Emitter) -> [f32; 3]) -> Vec3x8<S> {
        Vec3x8::from_lanes(self.simd, |lane| of(self.emitters[lane]))
    }

    #[inline(always)]
    fn zero(&self) -> f32x8<S> {
        f32x8::splat(self.simd, 0.0)
    }

    #[inline(always)]
    fn nothing(&self) -> LightSample<S> {
        let nowhere = Vec3x8::splat(self.simd, Vec3::ZERO);
        LightSample {
            is_there: mask32x8::splat(self.simd, false),
            direction: nowhere,
            t_max: self.zero(),
            weight: nowhere,
            density: self.zero(),
        }
    }

    /// Uniform over the cone of directions that meet the sphere.
    #[inline(always)]
    fn sphere(&self, point: Vec3x8<S>) -> LightSample<S> {
        let to_centre = self.vector(|emitter| emitter.position) - point;
        let distance2 = dot3(to_centre, to_centre);
        let radius = self.number(|emitter| emitter.extent);
        let radius2 = radius * radius;
        let distance = distance2.sqrt();
        let sine2_max = radius2 / distance2;
        let one_minus_cosine_max = sine2_max / (1.0 + (1.0 - sine2_max).sqrt());
        let one_minus_cosine = self.a * one_minus_cosine_max;
        let cosine = 1.0 - one_minus_cosine;
        let sine2 = one_minus_cosine * (2.0 - one_minus_cosine);
        let sine = sine2.sqrt();
        let turn = sine_cosine(self.b);
        let axis = to_centre * (1.0 / distance);
        let (tangent, bitangent) = basis(axis);
        let direction = normalize3(tangent * (sine * turn.1) + bitangent * (sine * turn.0) + axis * cosine);
        LightSample {
            is_there: distance2.simd_gt(radius2),
            direction,
            t_max: distance * cosine - (radius2 - distance2 * sine2).max(0.0).sqrt(),
            // Radiance is intensity over πr², the cone's solid angle 2π(1 − cos).
            weight: self.vector(|emitter| emitter.power) * (2.0 * one_minus_cosine_max / radius2),
            density: self.zero(),
        }
    }

    /// The only direction; a spot light shines less and less the farther that is from its axis.
    #[inline(always)]
    fn point(&self, point: Vec3x8<S>, is_spot: mask32x8<S>) -> LightSample<S> {
        let to_light = self.vector(|emitter| emitter.position) - point;
        let distance2 = dot3(to_light, to_light);
        let distance = distance2.sqrt();
        let direction = to_light * (1.0 / distance);
        let mut falloff = f32x8::splat(self.simd, 1.0);
        if is_spot.any_true() {
            let cosine = -dot3(direction, self.vector(|emitter| emitter.direction));
            let scale = self.number(|emitter| emitter.cone_scale);
            let offset = self.number(|emitter| emitter.extent);
            let linear = (cosine * scale + offset).max(0.0).min(1.0);
            falloff = is_spot.select(linear * linear, falloff);
        }
        LightSample {
            is_there: distance2.simd_gt(0.0) & falloff.simd_gt(0.0),
            direction,
            t_max: distance,
            weight: self.vector(|emitter| emitter.power) * (falloff / distance2),
            density: self.zero(),
        }
    }

    #[inline(always)]
    fn directional(&self) -> LightSample<S> {
        LightSample {
            is_there: mask32x8::splat(self.simd, true),
            direction: -self.vector(|emitter| emitter.direction),
            t_max: f32x8::splat(self.simd, f32::INFINITY),
            weight: self.vector(|emitter| emitter.power),
            density: self.zero(),
        }
    }

    /// Uniform over the triangle's area.
    #[inline(always)]
    fn triangle(&self, point: Vec3x8<S>) -> LightSample<S> {
        let p = self.vector(|emitter| emitter.position);
        let pq = self.vector(|emitter| emitter.direction) - p;
        let pr = self.vector(|emitter| emitter.third_corner) - p;
        let root = self.a.sqrt();
        let (u, v) = (root * (1.0 - self.b), root * self.b);
        let normal = normalize3(cross3(pq, pr));
        let on_light = p + pq * u + pr * v;
        let facing = normal.negated_where(dot3(normal, point - on_light).simd_lt(0.0));
        let to_light = offset_origins(on_light, facing, pq, pr) - point;
        let distance2 = dot3(to_light, to_light);
        let distance = distance2.sqrt();
        let direction = to_light * (1.0 / distance);
        let cosine = -dot3(direction, facing);
        let density_over_area = 1.0 / self.number(|emitter| emitter.extent);
        let density = density_over_area * distance2 / cosine;
        LightSample {
            is_there: cosine.simd_gt(1e-6) & distance.simd_gt(0.0),
            direction,
            t_max: distance * SHORT_OF_TRIANGLE,
            weight: self.vector(|emitter| emitter.power) * (1.0 / density),
            density: density * self.number(|emitter| emitter.probability),
        }
    }

    /// Uniform over all directions.
    #[inline(always)]
    fn sky(&self, tables: &ShadeTables) -> LightSample<S> {
        let z = 1.0 - 2.0 * self.a;
        let radius = (1.0 - z * z).max(0.0).sqrt();
        let turn = sine_cosine(self.b);
        let direction = Vec3x8::new(radius * turn.1, radius * turn.0, z);
        LightSample {
            is_there: mask32x8::splat(self.simd, true),
            direction,
            t_max: f32x8::splat(self.simd, f32::INFINITY),
            weight: sky_radiance(tables, direction) * f32x8::splat(self.simd, 4.0 * PI),
            density: f32x8::splat(self.simd, tables.sky_density),
        }
    }
}
