//! What happens to eight paths at a surface each: the arithmetic that both backends follow.

use fearless_simd::prelude::*;
use fearless_simd::{f32x8, mask32x8, u32x8};
use formats::ray::{Hit, Ray};
use glam::Vec3;

use super::bsdf::Bsdf;
use super::light::{LightSample, sample_light, sky_radiance};
use super::surface::{HitSurface, hit_surface};
use super::tables::ShadeTables;
use crate::stages::eight::{LANES, Vec3x8, basis, dot3, luminance, normalize3};
use crate::stages::random::RandomX8;
use crate::stages::shared::{PathState, ShadeParams};

/// Bounces before Russian roulette starts.
pub const ROULETTE_FREE_BOUNCES: u32 = 2;

/// What paths come with.
pub struct Arriving<'a> {
    /// Their rays.
    pub rays: [&'a Ray; LANES],
    /// What those hit.
    pub hits: [Hit; LANES],
    /// What they carry.
    pub states: [&'a PathState; LANES],
}

/// What paths leave at their surfaces.
pub struct Outcome<S: Simd> {
    /// Light that the film gets at once: emission met by the ray.
    pub emitted: Vec3x8<S>,
    /// Where rays leave.
    pub origin: Vec3x8<S>,
    /// Rays to light samples and what they bring.
    pub shadow: Leaving<S>,
    /// Indices of the lights.
    pub lights: [u32; LANES],
    /// The paths' next rays.
    pub next: Leaving<S>,
}

/// Rays that leave surfaces.
#[derive(Clone, Copy)]
pub struct Leaving<S: Simd> {
    /// Whether there is one.
    pub is_there: mask32x8<S>,
    /// Unit vector.
    pub direction: Vec3x8<S>,
    /// How far it goes.
    pub t_max: f32x8<S>,
    /// [`PathState::color`].
    pub color: Vec3x8<S>,
    /// [`PathState::density`].
    pub density: f32x8<S>,
}

impl<S: Simd> Leaving<S> {
    #[inline(always)]
    fn nothing(simd: S) -> Self {
        let (zero, nowhere) = (f32x8::splat(simd, 0.0), Vec3x8::splat(simd, Vec3::ZERO));
        let is_there = mask32x8::splat(simd, false);
        Self { is_there, direction: nowhere, t_max: zero, color: nowhere, density: zero }
    }
}

/// Power heuristic with exponent 2 (Veach 1997, §9.2.4): the weight of a sample drawn with density `a`.
#[inline(always)]
fn power_heuristic<S: Simd>(a: f32x8<S>, b: f32x8<S>) -> f32x8<S> {
    let a2 = a * a;
    a2 / (a2 + b * b)
}

/// Shades the hits of eight paths.
#[inline(always)]
pub fn shade_paths<S: Simd>(
    tables: &ShadeTables,
    params: &ShadeParams,
    arriving: &Arriving<'_>,
    mut random: RandomX8<S>,
    simd: S,
) -> Outcome<S> {
    let Arriving { rays, hits, states } = arriving;
    let direction = Vec3x8::from_lanes(simd, |lane| rays[lane].direction);
    let throughput = Vec3x8::from_lanes(simd, |lane| states[lane].color);
    let density = f32x8::from_fn(simd, |lane| states[lane].density);
    let nothing = Leaving::nothing(simd);
    let mut outcome = Outcome {
        emitted: nothing.color,
        origin: nothing.direction,
        shadow: nothing,
        lights: [0; LANES],
        next: nothing,
    };
    let triangles = u32x8::from_fn(simd, |lane| hits[lane].triangle);
    let is_miss = triangles.simd_eq(Hit::NONE);
    if is_miss.any_true() && tables.sky_density > 0.0 {
        let weight = emission_weight(density, f32x8::splat(simd, tables.sky_density));
        let sky = throughput * sky_radiance(tables, direction) * weight;
        outcome.emitted = sky.where_or(is_miss, outcome.emitted);
    }
    if is_miss.all_true() {
        return outcome;
    }
    let u = f32x8::from_fn(simd, |lane| hits[lane].u);
    let v = f32x8::from_fn(simd, |lane| hits[lane].v);
    // A miss stands at the first triangle, which is there since something was hit.
    let triangles = is_miss.select(u32x8::splat(simd, 0), triangles);
    let surface = hit_surface(tables, direction, triangles, u, v);
    let emission = Vec3x8::from_lanes(simd, |lane| surface.materials[lane].emission);
    let brightness = luminance(emission);
    let is_bright = brightness.simd_gt(0.0) & !is_miss;
    if is_bright.any_true() {
        let cosine = -dot3(direction, surface.geometric_normal);
        let t = f32x8::from_fn(simd, |lane| hits[lane].t);
        let light_density = brightness * tables.emission_density * (t * t) / cosine.max(1e-6);
        let emitted = throughput * emission * emission_weight(density, light_density);
        outcome.emitted = emitted.where_or(is_bright, outcome.emitted);
    }
    let metallic = f32x8::from_fn(simd, |lane| surface.materials[lane].metallic);
    let roughness = f32x8::from_fn(simd, |lane| surface.materials[lane].roughness);
    let frame = ShadingFrame::new(surface.shading_normal);
    let vertex = Vertex {
        params,
        bsdf: Bsdf::new(surface.base_color, metallic, roughness),
        surface,
        out: frame.to_local(-direction),
        frame,
        throughput,
    };
    outcome.origin = vertex.surface.origin;
    if !tables.emitters.is_empty() {
        let (light, lights) = sample_light(tables, outcome.origin, &mut random);
        outcome.lights = lights;
        outcome.shadow = vertex.shadow_ray(&light);
        outcome.shadow.is_there &= !is_miss;
    }
    if params.is_last == 0 {
        outcome.next = vertex.next_ray(&mut random);
        outcome.next.is_there &= !is_miss;
    }
    outcome
}

/// Weight of emission that rays met which were drawn with `density` (0: camera or mirror).
#[inline(always)]
fn emission_weight<S: Simd>(density: f32x8<S>, light_density: f32x8<S>) -> f32x8<S> {
    let one = f32x8::splat(density.token(), 1.0);
    density.simd_gt(0.0).select(power_heuristic(density, light_density), one)
}

struct ShadingFrame<S: Simd> {
    tangent: Vec3x8<S>,
    bitangent: Vec3x8<S>,
    normal: Vec3x8<S>,
}

impl<S: Simd> ShadingFrame<S> {
    #[inline(always)]
    fn new(normal: Vec3x8<S>) -> Self {
        let (tangent, bitangent) = basis(normal);
        Self { tangent, bitangent, normal }
    }

    #[inline(always)]
    fn to_local(&self, v: Vec3x8<S>) -> Vec3x8<S> {
        Vec3x8::new(dot3(v, self.tangent), dot3(v, self.bitangent), dot3(v, self.normal))
    }

    #[inline(always)]
    fn to_world(&self, v: Vec3x8<S>) -> Vec3x8<S> {
        self.tangent * v.x + self.bitangent * v.y + self.normal * v.z
    }
}

/// Paths at their surfaces, as both of their rays leave them.
struct Vertex<'a, S: Simd> {
    params: &'a ShadeParams,
    surface: HitSurface<'a, S>,
    bsdf: Bsdf<S>,
    frame: ShadingFrame<S>,
    /// Where the paths came from, in the local frames.
    out: Vec3x8<S>,
    throughput: Vec3x8<S>,
}

impl<S: Simd> Vertex<'_, S> {
    #[inline(always)]
    fn shadow_ray(&self, light: &LightSample<S>) -> Leaving<S> {
        let simd = light.t_max.token();
        let is_seen = dot3(light.direction, self.surface.geometric_normal).simd_gt(0.0);
        let incident = self.frame.to_local(light.direction);
        let (value, density) = self.bsdf.evaluate(self.out, incident);
        let mut weight = f32x8::splat(simd, 1.0);
        // After the last bounce no ray is left that could find the light by reflection.
        if self.params.is_last == 0 {
            let is_found = light.density.simd_gt(0.0);
            weight = is_found.select(power_heuristic(light.density, density), weight);
        }
        let color = self.throughput * value * light.weight * weight;
        Leaving {
            is_there: light.is_there & is_seen & light.t_max.simd_gt(0.0) & brings_something(color),
            direction: light.direction,
            t_max: light.t_max,
            color,
            density: f32x8::splat(simd, 0.0),
        }
    }

    #[inline(always)]
    fn next_ray(&self, random: &mut RandomX8<S>) -> Leaving<S> {
        let sample = self.bsdf.sample(self.out, random);
        let simd = sample.density.token();
        let direction = normalize3(self.frame.to_world(sample.direction));
        let mut is_there = sample.is_there & dot3(direction, self.surface.geometric_normal).simd_gt(0.0);
        let mut color = self.throughput * sample.weight;
        if self.params.roulette != 0 && self.params.bounce >= ROULETTE_FREE_BOUNCES {
            let survival = color.x.max(color.y).max(color.z).max(0.05).min(1.0);
            is_there &= random.draw().simd_lt(survival);
            color = color * (1.0 / survival);
        }
        Leaving {
            is_there: is_there & brings_something(color),
            direction,
            t_max: f32x8::splat(simd, f32::INFINITY),
            color,
            density: sample.density,
        }
    }
}

/// Whether a ray that carries this colour brings something, and is not out of range.
#[inline(always)]
fn brings_something<S: Simd>(color: Vec3x8<S>) -> mask32x8<S> {
    let brightness = luminance(color);
    brightness.simd_gt(0.0) & brightness.simd_lt(f32::MAX)
}
