//! What happens to one path at one surface: the arithmetic that both backends follow.

use formats::ray::{Hit, Ray};
use glam::Vec3;

use super::bsdf::Bsdf;
use super::light::{LightSample, sample_light, sky_radiance};
use super::surface::{HitSurface, hit_surface};
use super::tables::ShadeTables;
use crate::stages::compact::cpu::RayState;
use crate::stages::random::Random;
use crate::stages::shared::ShadeParams;
use crate::stages::vector::{basis, dot3, luminance, normalize3};

/// Bounces before Russian roulette starts.
pub const ROULETTE_FREE_BOUNCES: u32 = 2;

/// What a path leaves at a surface.
#[derive(Clone, Copy, Debug, Default)]
pub struct Outcome {
    /// Light that the film gets at once: emission met by the ray.
    pub emitted: Vec3,
    /// A ray to a light sample and what it brings, and the index of the light.
    pub shadow: Option<((Ray, RayState), u32)>,
    /// The path's next ray.
    pub next: Option<(Ray, RayState)>,
}

/// Power heuristic with exponent 2 (Veach 1997, §9.2.4): the weight of a sample drawn with density `a`.
#[inline(always)]
fn power_heuristic(a: f32, b: f32) -> f32 {
    let a2 = a * a;
    a2 / (a2 + b * b)
}

/// Shades the hit of one path.
#[inline(always)]
pub fn shade_path<const TEXTURES: bool, const NORMALS: bool, const GLOSSY: bool>(
    tables: &ShadeTables,
    params: &ShadeParams,
    ray: &Ray,
    hit: &Hit,
    state: &RayState,
    mut random: Random,
) -> Outcome {
    let direction = Vec3::from(ray.direction);
    let throughput = Vec3::from(state.color);
    let mut outcome = Outcome::default();
    if !hit.is_hit() {
        if tables.sky_density > 0.0 {
            let weight = emission_weight(state.density, tables.sky_density);
            outcome.emitted = throughput * sky_radiance(tables.zenith, tables.nadir, direction) * weight;
        }
        return outcome;
    }
    let surface = hit_surface::<TEXTURES, NORMALS>(tables, direction, hit.triangle, hit.u, hit.v);
    outcome.emitted = emitted(tables, ray, hit, state, &surface);
    let frame = ShadingFrame::new(surface.shading_normal);
    let vertex = Vertex {
        params,
        bsdf: Bsdf::new(surface.base_color, surface.material.metallic, surface.material.roughness),
        surface,
        out: frame.to_local(-direction),
        frame,
        throughput,
    };
    let is_lit = !tables.emitters.is_empty();
    let light = if is_lit { sample_light(tables, vertex.surface.origin, &mut random) } else { None };
    // Before the light is asked whether it lies above the surface, which is as often so as not: what is begun by
    // then is not begun again.
    if params.is_last == 0 {
        outcome.next = vertex.next_ray::<GLOSSY>(&mut random);
    }
    outcome.shadow = light.and_then(|light| vertex.shadow_ray::<GLOSSY>(&light));
    outcome
}

/// Weight of emission that a ray met which was drawn with `density` (0: camera or mirror).
#[inline(always)]
fn emission_weight(density: f32, light_density: f32) -> f32 {
    if density > 0.0 { power_heuristic(density, light_density) } else { 1.0 }
}

#[inline(always)]
fn emitted(tables: &ShadeTables, ray: &Ray, hit: &Hit, state: &RayState, surface: &HitSurface) -> Vec3 {
    let radiance = Vec3::from(surface.material.emission);
    let brightness = luminance(radiance);
    if brightness <= 0.0 {
        return Vec3::ZERO;
    }
    let cosine = -dot3(Vec3::from(ray.direction), surface.geometric_normal);
    let light_density = brightness * tables.emission_density * (hit.t * hit.t) / cosine.max(1e-6);
    Vec3::from(state.color) * radiance * emission_weight(state.density, light_density)
}

struct ShadingFrame {
    tangent: Vec3,
    bitangent: Vec3,
    normal: Vec3,
}

impl ShadingFrame {
    #[inline(always)]
    fn new(normal: Vec3) -> Self {
        let (tangent, bitangent) = basis(normal);
        Self { tangent, bitangent, normal }
    }

    #[inline(always)]
    fn to_local(&self, v: Vec3) -> Vec3 {
        Vec3::new(dot3(v, self.tangent), dot3(v, self.bitangent), dot3(v, self.normal))
    }

    #[inline(always)]
    fn to_world(&self, v: Vec3) -> Vec3 {
        self.tangent * v.x + self.bitangent * v.y + self.normal * v.z
    }
}

/// A path at a surface, as both of its rays leave it.
struct Vertex<'a> {
    params: &'a ShadeParams,
    surface: HitSurface,
    bsdf: Bsdf,
    frame: ShadingFrame,
    /// Where the path came from, in the local frame.
    out: Vec3,
    throughput: Vec3,
}

impl Vertex<'_> {
    #[inline(always)]
    fn shadow_ray<const GLOSSY: bool>(&self, light: &LightSample) -> Option<((Ray, RayState), u32)> {
        if dot3(light.direction, self.surface.geometric_normal) <= 0.0 || light.t_max <= 0.0 {
            return None;
        }
        let incident = self.frame.to_local(light.direction);
        let (value, density) = self.bsdf.evaluate::<GLOSSY>(self.out, incident);
        // After the last bounce no ray is left that could find the light by reflection.
        let weight = if light.density > 0.0 && self.params.is_last == 0 {
            power_heuristic(light.density, density)
        } else {
            1.0
        };
        let state = state(self.throughput * value * light.weight * weight)?;
        Some(((self.ray(light.direction, light.t_max), state), light.light))
    }

    #[inline(always)]
    fn next_ray<const GLOSSY: bool>(&self, random: &mut Random) -> Option<(Ray, RayState)> {
        let sample = self.bsdf.sample::<GLOSSY>(self.out, random)?;
        let direction = normalize3(self.frame.to_world(sample.direction));
        if dot3(direction, self.surface.geometric_normal) <= 0.0 {
            return None;
        }
        let mut color = self.throughput * sample.weight;
        if self.params.roulette != 0 && self.params.bounce >= ROULETTE_FREE_BOUNCES {
            let survival = color.x.max(color.y).max(color.z).clamp(0.05, 1.0);
            if random.draw() >= survival {
                return None;
            }
            color *= 1.0 / survival;
        }
        let state = RayState { density: sample.density, ..state(color)? };
        Some((self.ray(direction, f32::INFINITY), state))
    }

    #[inline(always)]
    fn ray(&self, direction: Vec3, t_max: f32) -> Ray {
        let (origin, direction) = (self.surface.origin.to_array(), direction.to_array());
        Ray { origin, t_min: 0.0, direction, t_max }
    }
}

/// A ray that carries this colour; none for what brings nothing or is out of range.
#[inline(always)]
fn state(color: Vec3) -> Option<RayState> {
    let brightness = luminance(color);
    (brightness > 0.0 && brightness < f32::MAX)
        .then(|| RayState { color: color.to_array(), ..RayState::default() })
}
