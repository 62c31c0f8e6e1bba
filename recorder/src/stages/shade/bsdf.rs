//! Diffuse and GGX metallic-roughness reflection (glTF 2.0 Appendix B), sampled by visible normals.
//!
//! Deviation: Appendix B weakens the diffuse lobe by the Fresnel term of the half vector and so
//! reflects more than it gets at grazing angles; here it is weakened by what the surface reflects
//! on the way in and on the way out.
//!
//! All vectors are in the local frame of the shading normal, z up, and point away from the surface.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use crate::stages::random::{Random, cosine_hemisphere, sine_cosine};
use crate::stages::vector::{dot3, luminance, normalize3};

/// Reflectance of dielectrics at normal incidence.
pub const DIELECTRIC_F0: f32 = 0.04;
/// Surfaces with α below this reflect like a mirror: their lobe cannot be sampled by light.
pub const MIRROR_ALPHA: f32 = 1.0 / 1024.0;

/// A surface point's reflection properties.
#[derive(Clone, Copy, Debug)]
pub struct Bsdf {
    /// Diffuse albedo.
    pub diffuse: Vec3,
    /// Specular reflectance at normal incidence.
    pub f0: Vec3,
    /// GGX α; below [`MIRROR_ALPHA`] a mirror.
    pub alpha: f32,
    /// Whether there is a specular lobe at all.
    pub is_glossy: bool,
}

/// A sampled direction.
#[derive(Clone, Copy, Debug)]
pub struct BsdfSample {
    /// Incident direction.
    pub direction: Vec3,
    /// Reflectance times cosine over density.
    pub weight: Vec3,
    /// Density over solid angle; 0 for a mirror reflection.
    pub density: f32,
}

impl Bsdf {
    /// From base colour, metallic and roughness. Metallic 0 with roughness 1 is purely diffuse.
    #[inline(always)]
    pub fn new(base_color: Vec3, metallic: f32, roughness: f32) -> Self {
        Self {
            diffuse: base_color * (1.0 - metallic),
            f0: Vec3::splat(DIELECTRIC_F0) * (1.0 - metallic) + base_color * metallic,
            alpha: roughness * roughness,
            is_glossy: metallic > 0.0 || roughness < 1.0,
        }
    }

    #[inline(always)]
    fn is_mirror(&self) -> bool {
        self.alpha < MIRROR_ALPHA
    }

    /// Probability of sampling the specular lobe for an exitant direction.
    #[inline(always)]
    fn specular_probability(&self, cos_out: f32) -> f32 {
        let specular = luminance(fresnel(self.f0, cos_out));
        let diffuse = luminance(self.diffuse);
        specular / (specular + diffuse).max(1e-8)
    }

    /// Reflectance times cosine, and the density with which [`Bsdf::sample`] finds `incident`.
    /// Zero below the horizon. A mirror's lobe is not part of it.
    #[inline(always)]
    pub fn evaluate<const GLOSSY: bool>(&self, out: Vec3, incident: Vec3) -> (Vec3, f32) {
        if out.z <= 0.0 || incident.z <= 0.0 {
            return (Vec3::ZERO, 0.0);
        }
        let diffuse = self.diffuse * (incident.z * FRAC_1_PI);
        let diffuse_density = incident.z * FRAC_1_PI;
        if !GLOSSY || !self.is_glossy {
            return (diffuse, diffuse_density);
        }
        let specular_probability = self.specular_probability(out.z);
        let diffuse_probability = 1.0 - specular_probability;
        let diffuse =
            diffuse * (Vec3::ONE - fresnel(self.f0, out.z)) * (Vec3::ONE - fresnel(self.f0, incident.z));
        if self.is_mirror() {
            return (diffuse, diffuse_density * diffuse_probability);
        }
        let half = normalize3(out + incident);
        let reflected = fresnel(self.f0, dot3(out, half));
        let distribution = ggx_distribution(self.alpha, half.z);
        let shadowing_out = smith_lambda(self.alpha, out.z);
        let shadowing = 1.0 / (1.0 + shadowing_out + smith_lambda(self.alpha, incident.z));
        let specular = reflected * (distribution * shadowing / (4.0 * out.z));
        let specular_density = distribution / ((1.0 + shadowing_out) * 4.0 * out.z);
        (specular + diffuse, specular_density * specular_probability + diffuse_density * diffuse_probability)
    }

    /// Draws an incident direction; `None` if it falls below the horizon. Uses three numbers.
    #[inline(always)]
    pub fn sample<const GLOSSY: bool>(&self, out: Vec3, random: &mut Random) -> Option<BsdfSample> {
        let (choice, a, b) = (random.draw(), random.draw(), random.draw());
        if out.z <= 0.0 {
            return None;
        }
        if !GLOSSY || !self.is_glossy {
            let direction = cosine_hemisphere(a, b);
            return (direction.z > 0.0).then_some(BsdfSample {
                direction,
                weight: self.diffuse,
                density: direction.z * FRAC_1_PI,
            });
        }
        let specular_probability = self.specular_probability(out.z);
        let is_specular = choice < specular_probability;
        if is_specular && self.is_mirror() {
            let weight = fresnel(self.f0, out.z) * (1.0 / specular_probability);
            return Some(BsdfSample { direction: Vec3::new(-out.x, -out.y, out.z), weight, density: 0.0 });
        }
        let direction = if is_specular {
            let half = visible_normal(self.alpha, out, a, b);
            half * (2.0 * dot3(out, half)) - out
        } else {
            cosine_hemisphere(a, b)
        };
        if direction.z <= 0.0 {
            return None;
        }
        let (value, density) = self.evaluate::<GLOSSY>(out, direction);
        (density > 1e-12).then_some(BsdfSample { direction, weight: value * (1.0 / density), density })
    }
}

/// Schlick's approximation.
#[inline(always)]
fn fresnel(f0: Vec3, cosine: f32) -> Vec3 {
    let m = (1.0 - cosine).clamp(0.0, 1.0);
    let m2 = m * m;
    f0 + (Vec3::ONE - f0) * (m2 * m2 * m)
}

/// GGX distribution of normals (Walter et al. 2007, eq. 33).
#[inline(always)]
fn ggx_distribution(alpha: f32, cosine: f32) -> f32 {
    let alpha2 = alpha * alpha;
    // 1 − cos² keeps its digits at grazing half vectors where (α² − 1)·cos² + 1 would lose them.
    let spread = (1.0 - cosine * cosine).max(0.0) + alpha2 * cosine * cosine;
    alpha2 * FRAC_1_PI / (spread * spread).max(1e-20)
}

/// Smith's Λ for GGX (Heitz 2014, eq. 72).
#[inline(always)]
fn smith_lambda(alpha: f32, cosine: f32) -> f32 {
    let cosine2 = cosine * cosine;
    let tangent2 = (1.0 - cosine2).max(0.0) / cosine2.max(1e-12);
    0.5 * ((1.0 + alpha * alpha * tangent2).sqrt() - 1.0)
}

/// A normal with the density of those visible from `out` (Dupuy & Benyoub, "Sampling Visible GGX
/// Normals with Spherical Caps", HPG 2023).
#[inline(always)]
fn visible_normal(alpha: f32, out: Vec3, a: f32, b: f32) -> Vec3 {
    let stretched = normalize3(Vec3::new(out.x * alpha, out.y * alpha, out.z));
    let (sine, cosine) = sine_cosine(a);
    let z = (1.0 - b) * (1.0 + stretched.z) - stretched.z;
    let radius = (1.0 - z * z).max(0.0).sqrt();
    let cap = Vec3::new(radius * cosine, radius * sine, z) + stretched;
    normalize3(Vec3::new(cap.x * alpha, cap.y * alpha, cap.z.max(1e-6)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn directions() -> Vec<Vec3> {
        [0.05f32, 0.3, 0.7, 0.99].map(|z| Vec3::new((1.0 - z * z).sqrt(), 0.0, z)).to_vec()
    }

    fn surfaces() -> Vec<Bsdf> {
        let color = Vec3::new(0.9, 0.5, 0.2);
        [(0.0, 1.0), (0.0, 0.5), (1.0, 0.3), (1.0, 1.0), (0.4, 0.2), (0.5, 0.0)]
            .map(|(metallic, roughness)| Bsdf::new(color, metallic, roughness))
            .to_vec()
    }

    /// The density must integrate to the share of samples that are kept, and sampling must find
    /// the same albedo as uniform integration. No surface reflects more than it gets.
    #[test]
    fn sampling_agrees_with_uniform_integration() {
        for (number, surface) in surfaces().into_iter().enumerate() {
            for out in directions() {
                let n = 400_000;
                let mut random = Random::new([9, 9], number as u32, 0, 0);
                let (mut uniform, mut density_sum, mut sampled, mut kept, mut albedo) =
                    (Vec3::ZERO, 0.0f64, Vec3::ZERO, 0.0f64, Vec3::ZERO);
                for _ in 0..n {
                    let (z, b) = (random.draw(), random.draw());
                    let (sine, cosine) = sine_cosine(b);
                    let radius = (1.0 - z * z).sqrt();
                    let (value, density) =
                        surface.evaluate::<true>(out, Vec3::new(radius * cosine, radius * sine, z));
                    uniform += value * std::f32::consts::TAU / n as f32;
                    density_sum += f64::from(density) * std::f64::consts::TAU / f64::from(n);
                    let Some(sample) = surface.sample::<true>(out, &mut random) else { continue };
                    albedo += sample.weight / n as f32;
                    if sample.density > 0.0 {
                        sampled += sample.weight / n as f32;
                        kept += 1.0 / f64::from(n);
                    }
                }
                assert!(albedo.max_element() <= 1.01, "{surface:?} {out}: {albedo}");
                assert!(
                    (density_sum - kept).abs() < 0.04,
                    "{surface:?} {out}: density {density_sum}, kept {kept}"
                );
                assert!(
                    (uniform - sampled).abs().max_element() < 0.04,
                    "{surface:?} {out}: {uniform} {sampled}"
                );
            }
        }
    }
}
