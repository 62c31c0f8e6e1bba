//! Diffuse and GGX metallic-roughness reflection (glTF 2.0 Appendix B), sampled by visible normals, at eight
//! surfaces at once.
//!
//! Deviation: Appendix B weakens the diffuse lobe by the Fresnel term of the half vector and so
//! reflects more than it gets at grazing angles; here it is weakened by what the surface reflects
//! on the way in and on the way out.
//!
//! All vectors are in the local frame of the shading normal, z up, and point away from the surface.

use std::f32::consts::FRAC_1_PI;

use fearless_simd::prelude::*;
use fearless_simd::{f32x8, mask32x8};
use glam::Vec3;

use crate::stages::eight::{Vec3x8, dot3, luminance, normalize3};
use crate::stages::random::{RandomX8, cosine_hemisphere, sine_cosine};

/// Reflectance of dielectrics at normal incidence.
pub const DIELECTRIC_F0: f32 = 0.04;
/// Surfaces with α below this reflect like a mirror: their lobe cannot be sampled by light.
pub const MIRROR_ALPHA: f32 = 1.0 / 1024.0;

/// Reflection properties of surface points.
#[derive(Clone, Copy, Debug)]
pub struct Bsdf<S: Simd> {
    /// Diffuse albedo.
    pub diffuse: Vec3x8<S>,
    /// Specular reflectance at normal incidence.
    pub f0: Vec3x8<S>,
    /// GGX α; below [`MIRROR_ALPHA`] a mirror.
    pub alpha: f32x8<S>,
    /// Whether there is a specular lobe at all.
    pub is_glossy: mask32x8<S>,
}

/// Sampled directions.
#[derive(Clone, Copy, Debug)]
pub struct BsdfSample<S: Simd> {
    /// Whether there is one: none falls below the horizon.
    pub is_there: mask32x8<S>,
    /// Incident direction.
    pub direction: Vec3x8<S>,
    /// Reflectance times cosine over density.
    pub weight: Vec3x8<S>,
    /// Density over solid angle; 0 for a mirror reflection.
    pub density: f32x8<S>,
}

impl<S: Simd> Bsdf<S> {
    /// From base colour, metallic and roughness. Metallic 0 with roughness 1 is purely diffuse.
    #[inline(always)]
    pub fn new(base_color: Vec3x8<S>, metallic: f32x8<S>, roughness: f32x8<S>) -> Self {
        let dielectric = Vec3x8::splat(metallic.token(), Vec3::splat(DIELECTRIC_F0));
        Self {
            diffuse: base_color * (1.0 - metallic),
            f0: dielectric * (1.0 - metallic) + base_color * metallic,
            alpha: roughness * roughness,
            is_glossy: metallic.simd_gt(0.0) | roughness.simd_lt(1.0),
        }
    }

    #[inline(always)]
    fn is_mirror(&self) -> mask32x8<S> {
        self.alpha.simd_lt(MIRROR_ALPHA)
    }

    /// Probability of sampling the specular lobe for an exitant direction.
    #[inline(always)]
    fn specular_probability(&self, cos_out: f32x8<S>) -> f32x8<S> {
        let specular = luminance(fresnel(self.f0, cos_out));
        let diffuse = luminance(self.diffuse);
        specular / (specular + diffuse).max(1e-8)
    }

    /// Reflectance times cosine, and the density with which [`Bsdf::sample`] finds `incident`.
    /// Zero below the horizon. A mirror's lobe is not part of it.
    #[inline(always)]
    pub fn evaluate(&self, out: Vec3x8<S>, incident: Vec3x8<S>) -> (Vec3x8<S>, f32x8<S>) {
        let simd = out.z.token();
        let diffuse_density = incident.z * FRAC_1_PI;
        let (mut value, mut density) = (self.diffuse * diffuse_density, diffuse_density);
        if self.is_glossy.any_true() {
            let (glossy_value, glossy_density) = self.evaluate_glossy(out, incident);
            value = glossy_value.where_or(self.is_glossy, value);
            density = self.is_glossy.select(glossy_density, density);
        }
        let is_above = out.z.simd_gt(0.0) & incident.z.simd_gt(0.0);
        let zero = f32x8::splat(simd, 0.0);
        (value.where_or(is_above, Vec3x8::splat(simd, Vec3::ZERO)), is_above.select(density, zero))
    }

    #[inline(always)]
    fn evaluate_glossy(&self, out: Vec3x8<S>, incident: Vec3x8<S>) -> (Vec3x8<S>, f32x8<S>) {
        let one = Vec3x8::splat(out.z.token(), Vec3::ONE);
        let specular_probability = self.specular_probability(out.z);
        let diffuse = self.diffuse
            * (incident.z * FRAC_1_PI)
            * (one - fresnel(self.f0, out.z))
            * (one - fresnel(self.f0, incident.z));
        let diffuse_density = incident.z * FRAC_1_PI * (1.0 - specular_probability);
        let half = normalize3(out + incident);
        let reflected = fresnel(self.f0, dot3(out, half));
        let distribution = ggx_distribution(self.alpha, half.z);
        let shadowing_out = smith_lambda(self.alpha, out.z);
        let shadowing = 1.0 / (1.0 + shadowing_out + smith_lambda(self.alpha, incident.z));
        let specular = reflected * (distribution * shadowing / (4.0 * out.z));
        let specular_density = distribution / ((1.0 + shadowing_out) * 4.0 * out.z);
        let is_mirror = self.is_mirror();
        (
            diffuse.where_or(is_mirror, specular + diffuse),
            is_mirror.select(diffuse_density, specular_density * specular_probability + diffuse_density),
        )
    }

    /// Draws an incident direction. Uses three numbers.
    #[inline(always)]
    pub fn sample(&self, out: Vec3x8<S>, random: &mut RandomX8<S>) -> BsdfSample<S> {
        let (choice, a, b) = (random.draw(), random.draw(), random.draw());
        let direction = cosine_hemisphere(a, b);
        let mut sample = BsdfSample {
            is_there: direction.z.simd_gt(0.0),
            direction,
            weight: self.diffuse,
            density: direction.z * FRAC_1_PI,
        };
        if self.is_glossy.any_true() {
            sample = self.sample_glossy(out, choice, a, b, direction).where_or(self.is_glossy, sample);
        }
        BsdfSample { is_there: sample.is_there & out.z.simd_gt(0.0), ..sample }
    }

    /// The specular lobe where `choice` says so, else the direction of the diffuse one.
    #[inline(always)]
    fn sample_glossy(
        &self,
        out: Vec3x8<S>,
        choice: f32x8<S>,
        a: f32x8<S>,
        b: f32x8<S>,
        diffuse: Vec3x8<S>,
    ) -> BsdfSample<S> {
        let specular_probability = self.specular_probability(out.z);
        let is_specular = choice.simd_lt(specular_probability);
        let half = visible_normal(self.alpha, out, a, b);
        let reflected = half * (2.0 * dot3(out, half)) - out;
        let direction = reflected.where_or(is_specular, diffuse);
        let (value, density) = self.evaluate(out, direction);
        let sample = BsdfSample {
            is_there: direction.z.simd_gt(0.0) & density.simd_gt(1e-12),
            direction,
            weight: value * (1.0 / density),
            density,
        };
        let mirrored = BsdfSample {
            is_there: is_specular,
            direction: Vec3x8::new(-out.x, -out.y, out.z),
            weight: fresnel(self.f0, out.z) * (1.0 / specular_probability),
            density: f32x8::splat(a.token(), 0.0),
        };
        mirrored.where_or(is_specular & self.is_mirror(), sample)
    }
}

impl<S: Simd> BsdfSample<S> {
    /// Of each lane that of `self` where `mask` is set, else `other`'s.
    #[inline(always)]
    fn where_or(self, mask: mask32x8<S>, other: Self) -> Self {
        Self {
            is_there: self.is_there & mask | other.is_there & !mask,
            direction: self.direction.where_or(mask, other.direction),
            weight: self.weight.where_or(mask, other.weight),
            density: mask.select(self.density, other.density),
        }
    }
}

/// Schlick's approximation.
#[inline(always)]
fn fresnel<S: Simd>(f0: Vec3x8<S>, cosine: f32x8<S>) -> Vec3x8<S> {
    let m = (1.0 - cosine).max(0.0).min(1.0);
    let m2 = m * m;
    f0 + (Vec3x8::splat(m.token(), Vec3::ONE) - f0) * (m2 * m2 * m)
}

/// GGX distribution of normals (Walter et al. 2007, eq. 33).
#[inline(always)]
fn ggx_distribution<S: Simd>(alpha: f32x8<S>, cosine: f32x8<S>) -> f32x8<S> {
    let alpha2 = alpha * alpha;
    // 1 − cos² keeps its digits at grazing half vectors where (α² − 1)·cos² + 1 would lose them.
    let spread = (1.0 - cosine * cosine).max(0.0) + alpha2 * cosine * cosine;
    alpha2 * FRAC_1_PI / (spread * spread).max(1e-20)
}

/// Smith's Λ for GGX (Heitz 2014, eq. 72).
#[inline(always)]
fn smith_lambda<S: Simd>(alpha: f32x8<S>, cosine: f32x8<S>) -> f32x8<S> {
    let cosine2 = cosine * cosine;
    let tangent2 = (1.0 - cosine2).max(0.0) / cosine2.max(1e-12);
    0.5 * ((1.0 + alpha * alpha * tangent2).sqrt() - 1.0)
}

/// A normal with the density of those visible from `out` (Dupuy & Benyoub, "Sampling Visible GGX
/// Normals with Spherical Caps", HPG 2023).
#[inline(always)]
fn visible_normal<S: Simd>(alpha: f32x8<S>, out: Vec3x8<S>, a: f32x8<S>, b: f32x8<S>) -> Vec3x8<S> {
    let stretched = normalize3(Vec3x8::new(out.x * alpha, out.y * alpha, out.z));
    let (sine, cosine) = sine_cosine(a);
    let z = (1.0 - b) * (1.0 + stretched.z) - stretched.z;
    let radius = (1.0 - z * z).max(0.0).sqrt();
    let cap = Vec3x8::new(radius * cosine, radius * sine, z) + stretched;
    normalize3(Vec3x8::new(cap.x * alpha, cap.y * alpha, cap.z.max(1e-6)))
}

#[cfg(test)]
mod tests {
    use fearless_simd::{Level, dispatch};

    use super::*;
    use crate::stages::random::Random;

    /// Metallic and roughness.
    const SURFACES: [[f32; 2]; 6] = [[0.0, 1.0], [0.0, 0.5], [1.0, 0.3], [1.0, 1.0], [0.4, 0.2], [0.5, 0.0]];
    /// Cosines of exitant directions.
    const COSINES: [f32; 4] = [0.05, 0.3, 0.7, 0.99];

    /// What samples of a surface come to.
    #[derive(Default)]
    struct Sums {
        /// Of reflectance times cosine, by directions that are uniform over the hemisphere.
        uniform: [f64; 3],
        /// Of the density, likewise.
        density: f64,
        /// Of the weights of sampled directions.
        albedo: [f64; 3],
        /// The same without a mirror's.
        sampled: [f64; 3],
        /// How many sampled directions are no mirror's.
        kept: f64,
    }

    #[inline(always)]
    fn sums<S: Simd>(
        simd: S,
        pixel: u32,
        [metallic, roughness]: [f32; 2],
        cosine: f32,
        eights: usize,
    ) -> Sums {
        let color = Vec3x8::splat(simd, Vec3::new(0.9, 0.5, 0.2));
        let [metallic, roughness] = [metallic, roughness].map(|value| f32x8::splat(simd, value));
        let surface = Bsdf::new(color, metallic, roughness);
        let out = Vec3x8::splat(simd, Vec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine));
        let queue = Random::of_queue([9, 9], 0, pixel);
        let mut random = RandomX8::of_pixels(queue, [0, 1, 2, 3, 4, 5, 6, 7].simd_into(simd));
        let mut sums = Sums::default();
        let add = |sum: &mut [f64; 3], values: [[f32; 8]; 3], lane: usize| {
            (0..3).for_each(|channel| sum[channel] += f64::from(values[channel][lane]));
        };
        for _ in 0..eights {
            let (z, b) = (random.draw(), random.draw());
            let (sine, cosine) = sine_cosine(b);
            let radius = (1.0 - z * z).sqrt();
            let (value, density) = surface.evaluate(out, Vec3x8::new(radius * cosine, radius * sine, z));
            let sample = surface.sample(out, &mut random);
            for lane in 0..8 {
                add(&mut sums.uniform, value.to_arrays(), lane);
                sums.density += f64::from(density[lane]);
                if !sample.is_there.test(lane) {
                    continue;
                }
                add(&mut sums.albedo, sample.weight.to_arrays(), lane);
                if sample.density[lane] > 0.0 {
                    add(&mut sums.sampled, sample.weight.to_arrays(), lane);
                    sums.kept += 1.0;
                }
            }
        }
        sums
    }

    /// The density must integrate to the share of samples that are kept, and sampling must find
    /// the same albedo as uniform integration. No surface reflects more than it gets.
    #[test]
    fn sampling_agrees_with_uniform_integration() {
        const EIGHTS: usize = 400_000;
        for (number, surface) in (0..).zip(SURFACES) {
            for cosine in COSINES {
                let sums = dispatch!(Level::new(), simd => sums(simd, number, surface, cosine, EIGHTS));
                let per_sample = 1.0 / (8 * EIGHTS) as f64;
                let hemisphere = std::f64::consts::TAU * per_sample;
                let (density, kept) = (sums.density * hemisphere, sums.kept * per_sample);
                assert!(
                    (density - kept).abs() < 0.02,
                    "{surface:?} {cosine}: density {density}, kept {kept}"
                );
                for channel in 0..3 {
                    let albedo = sums.albedo[channel] * per_sample;
                    assert!(albedo <= 1.01, "{surface:?} {cosine}: {albedo}");
                    let (uniform, sampled) =
                        (sums.uniform[channel] * hemisphere, sums.sampled[channel] * per_sample);
                    assert!((uniform - sampled).abs() < 0.02, "{surface:?} {cosine}: {uniform} {sampled}");
                }
            }
        }
    }
}
