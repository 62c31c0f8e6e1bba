//! Surface materials and the textures they refer to.

/// A metallic-roughness material (glTF 2.0 §3.9), the part of it that the tracer shades with.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name from the file, or an empty string.
    pub name: String,
    /// Linear RGB reflectance, 0 to 1; multiplied by the texture where there is one.
    pub base_color: [f32; 3],
    /// Index into the scene's textures.
    pub base_color_texture: Option<u32>,
    /// 0 = dielectric, 1 = metal.
    pub metallic: f32,
    /// Perceptual roughness, 0 to 1; GGX α is its square.
    pub roughness: f32,
    /// Emitted radiance, linear RGB, factor times strength.
    pub emission: [f32; 3],
    /// Points whose base-colour alpha (factor times texture) is below this are holes. `None` = opaque.
    pub alpha_cutoff: Option<f32>,
    /// Alpha factor of the base colour, 0 to 1.
    pub alpha: f32,
}

impl Default for Material {
    /// Mid-grey and matt.
    fn default() -> Self {
        Self {
            name: String::new(),
            base_color: [0.8; 3],
            base_color_texture: None,
            metallic: 0.0,
            roughness: 1.0,
            emission: [0.0; 3],
            alpha_cutoff: None,
            alpha: 1.0,
        }
    }
}

impl Material {
    /// Whether the surface emits light.
    pub fn is_emissive(&self) -> bool {
        self.emission.iter().any(|&channel| channel > 0.0)
    }

    /// Whether the surface has a GGX lobe beside its diffuse one; see [`crate::features::Features`].
    pub fn is_specular(&self) -> bool {
        self.metallic > 0.0 || self.roughness < 1.0
    }

    /// Which alpha bytes of the texture are holes: `a` is one exactly if `u32::from(a)` is below
    /// this. 0 for an opaque material, 256 if there is nothing but holes; where there is no texture,
    /// `a` counts as 255. One integer for all backends, so that none rounds its way to another mask.
    pub fn alpha_threshold(&self) -> u32 {
        /// One more than the largest byte.
        const ALL_HOLES: f32 = 256.0;

        match self.alpha_cutoff {
            Some(cutoff) if cutoff > 0.0 => {
                let threshold = (cutoff / self.alpha * 255.0).ceil();
                threshold.min(ALL_HOLES) as u32
            }
            _ => 0,
        }
    }
}

/// An image with 8 bits per channel; wraps around at its edges.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// Texels per row, ≥ 1.
    pub width: u32,
    /// Rows, ≥ 1.
    pub height: u32,
    /// `width × height` texels, top row first: sRGB-encoded red, green, blue, then linear alpha.
    pub rgba: Vec<[u8; 4]>,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn masked(cutoff: f32, alpha: f32) -> Material {
        Material { alpha_cutoff: Some(cutoff), alpha, ..Material::default() }
    }

    #[test]
    fn threshold_splits_bytes_as_real_numbers_do() {
        for cutoff in [0.0, 0.1, 0.25, 0.3, 0.5, 0.7, 0.999, 1.0, 1.5] {
            for alpha in [0.1, 0.33, 0.5, 0.9, 1.0] {
                let threshold = masked(cutoff, alpha).alpha_threshold();
                for byte in 0..=255_u32 {
                    let seen = f64::from(byte) / 255.0 * f64::from(alpha);
                    // On the very edge either is right.
                    if (seen - f64::from(cutoff)).abs() > 1e-6 {
                        let is_hole = seen < f64::from(cutoff);
                        assert_eq!(byte < threshold, is_hole, "byte {byte}, {cutoff}, {alpha}");
                    }
                }
            }
        }
    }

    #[test]
    fn threshold_of_edges() {
        assert_eq!(Material::default().alpha_threshold(), 0);
        assert_eq!(masked(0.5, 1.0).alpha_threshold(), 128);
        // 51 is exactly 0.2 of 255, and not below it.
        assert_eq!(masked(0.2, 1.0).alpha_threshold(), 51);
        assert_eq!(masked(1.0, 1.0).alpha_threshold(), 255);
        assert_eq!(masked(0.5, 0.0).alpha_threshold(), 256);
        assert_eq!(masked(0.0, 0.0).alpha_threshold(), 0);
        assert_eq!(masked(2.0, 1.0).alpha_threshold(), 256);
    }
}
