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
