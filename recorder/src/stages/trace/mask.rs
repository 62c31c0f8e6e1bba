//! Alpha masks: which points of a triangle are holes.
//!
//! At a hit the texture coordinates are `(w·a + u·b) + v·c` with `w = (1 − u) − v`; the texel is
//! the nearest one, the texture repeats. A point is a hole if the texel's alpha byte is below the
//! material's threshold, an integer, so that no rounding decides.

use scenes::features::Features;
use scenes::{Material, Scene};

use crate::stages::shared::MaskedTriangle;

/// All alpha masks of a scene.
#[derive(Clone, Debug, Default)]
pub struct Masks {
    /// The triangles that have one.
    pub triangles: Vec<MaskedTriangle>,
    /// Per scene triangle its place in `triangles` plus 1, 0 for none; empty if none has one.
    pub numbers: Vec<u32>,
    /// Alpha bytes of all mask textures. The first is 255: what materials without a texture have.
    pub alphas: Vec<u8>,
}

impl Masks {
    /// Collects the masks of a scene; empty where no material has one that makes a hole.
    pub fn new(scene: &Scene) -> Self {
        let thresholds: Vec<u32> = scene.materials.iter().map(Material::alpha_threshold).collect();
        if thresholds.iter().all(|&threshold| threshold == 0) {
            return Self::default();
        }
        let mut alphas = vec![255];
        let mut places = vec![None; scene.textures.len()];
        let mut triangles = Vec::new();
        let number_of = |(index, &material): (usize, &u32)| {
            let threshold = thresholds[material as usize];
            if threshold == 0 {
                return 0;
            }
            let texture = scene.materials[material as usize].base_color_texture;
            let (first, width, height) = match texture.map(|texture| texture as usize) {
                None => (0, 1, 1),
                Some(texture) => {
                    let image = &scene.textures[texture];
                    let first = *places[texture].get_or_insert_with(|| {
                        alphas.extend(image.rgba.iter().map(|texel| texel[3]));
                        (alphas.len() - image.rgba.len()) as u32
                    });
                    (first, image.width, image.height)
                }
            };
            let corner = |vertex: u32| scene.uvs.get(vertex as usize).copied().unwrap_or_default();
            let [uv_a, uv_b, uv_c] = scene.triangles[index].map(corner);
            triangles.push(MaskedTriangle { uv_a, uv_b, uv_c, threshold, first, width, height });
            triangles.len() as u32
        };
        let numbers: Vec<u32> = scene.triangle_materials.iter().enumerate().map(number_of).collect();
        if triangles.is_empty() { Self::default() } else { Self { triangles, numbers, alphas } }
    }

    /// Those of a scene, for kernels that look for holes if `features` say so: where there are none, every
    /// triangle says that it has none.
    pub fn for_features(scene: &Scene, features: &Features) -> Self {
        let masks = Self::new(scene);
        if !features.alpha_masks || !masks.is_empty() {
            return masks;
        }
        Self { triangles: Vec::new(), numbers: vec![0; scene.triangles.len()], alphas: vec![255] }
    }

    /// Whether kernels need not look for holes.
    pub fn is_empty(&self) -> bool {
        self.numbers.is_empty()
    }

    /// Number of a scene triangle's mask, counted from 1; 0 for none.
    pub fn number(&self, triangle: u32) -> u32 {
        self.numbers.get(triangle as usize).copied().unwrap_or(0)
    }

    /// Whether the point with barycentric weights u and v is a hole. `number` is not 0.
    pub fn is_hole(&self, number: u32, u: f32, v: f32) -> bool {
        let mask = &self.triangles[number as usize - 1];
        let w = (1.0 - u) - v;
        let [a, b, c] = [mask.uv_a, mask.uv_b, mask.uv_c];
        let texel = |axis: usize, size: u32| {
            let at = (w * a[axis] + u * b[axis]) + v * c[axis];
            (((at - at.floor()) * size as f32) as u32).min(size - 1)
        };
        let place = mask.first + texel(1, mask.height) * mask.width + texel(0, mask.width);
        u32::from(self.alphas[place as usize]) < mask.threshold
    }
}
