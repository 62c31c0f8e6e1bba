//! A scene as the shading kernels of both backends read it.

use bytemuck::Zeroable;
use glam::Vec3;
use scenes::base_colour::linear_from_srgb;
use scenes::features::Features;
use scenes::{Light, Scene, Texture};

use super::emitters;
use crate::stages::shared::{Emitter, MaterialData};

/// Texels begin after the table that turns sRGB bytes into linear values.
pub const LINEAR_TABLE_SIZE: u32 = 256;

/// Flat arrays for shading; index meanings as in [`Scene`].
#[derive(Clone, Debug, Default)]
pub struct ShadeTables {
    /// Vertex positions.
    pub positions: Vec<[f32; 3]>,
    /// Vertex normals; empty if the scene has none.
    pub normals: Vec<[f32; 3]>,
    /// Texture coordinates; empty if the scene has no textures.
    pub uvs: Vec<[f32; 2]>,
    /// Vertex indices and material of each triangle.
    pub triangles: Vec<[u32; 4]>,
    /// Materials.
    pub materials: Vec<MaterialData>,
    /// The bits of 256 linear values, one per sRGB byte, then every texture's RGBA bytes.
    pub texels: Vec<u32>,
    /// What shadow rays pick from; empty if nothing shines.
    pub emitters: Vec<Emitter>,
    /// Density over area of picking a point on an emissive triangle, per luminance of its radiance.
    pub emission_density: f32,
    /// Density over solid angle of picking a sky direction; 0 without a sky.
    pub sky_density: f32,
    /// Sky radiance straight up.
    pub zenith: Vec3,
    /// Sky radiance straight down.
    pub nadir: Vec3,
}

impl ShadeTables {
    /// From a scene that keeps the invariants of [`Scene`].
    pub fn new(scene: &Scene) -> Self {
        let (emitters, total_power, sky_probability) = emitters::build(scene);
        let sky = scene.lights.iter().find_map(|light| match light {
            Light::Environment(sky) => Some(*sky),
            _ => None,
        });
        let (places, texels) = pack_textures(&scene.textures);
        let place = |texture: u32| places[texture as usize];
        let triangles = scene.triangles.iter().zip(&scene.triangle_materials);
        Self {
            positions: scene.positions.clone(),
            normals: scene.normals.clone(),
            uvs: scene.uvs.clone(),
            triangles: triangles.map(|(&[a, b, c], &material)| [a, b, c, material]).collect(),
            materials: scene.materials.iter().map(|material| material_data(material, place)).collect(),
            texels,
            emission_density: if total_power > 0.0 {
                (emitters::POWER_PER_AREA / total_power) as f32
            } else {
                0.0
            },
            emitters,
            sky_density: sky_probability / (4.0 * std::f32::consts::PI),
            zenith: sky.map_or(Vec3::ZERO, |sky| Vec3::from(sky.zenith)),
            nadir: sky.map_or(Vec3::ZERO, |sky| Vec3::from(sky.nadir)),
        }
    }

    /// The same with arrays for kernels of these features: where a scene has none, normals of length 0, which
    /// stand for the triangle's own, and one texture that no material has.
    #[must_use]
    pub fn for_features(mut self, features: &Features) -> Self {
        if features.vertex_normals && self.normals.is_empty() {
            self.normals = vec![[0.0; 3]; self.positions.len()];
        }
        if features.textures && self.texels.is_empty() {
            self.uvs = vec![[0.0; 2]; self.positions.len()];
            let white = Texture { width: 1, height: 1, rgba: vec![[255; 4]] };
            self.texels = pack_textures(&[white]).1;
        }
        self
    }
}

fn material_data(material: &scenes::Material, place: impl Fn(u32) -> [u32; 3]) -> MaterialData {
    let [texture_first, texture_width, texture_height] = material.base_color_texture.map_or([0; 3], place);
    MaterialData {
        base_color: material.base_color,
        metallic: material.metallic,
        emission: material.emission,
        roughness: material.roughness,
        texture_first,
        texture_width,
        texture_height,
        ..MaterialData::zeroed()
    }
}

/// First texel, width and height of every texture, and the texels of all.
fn pack_textures(scene_textures: &[Texture]) -> (Vec<[u32; 3]>, Vec<u32>) {
    if scene_textures.is_empty() {
        return (Vec::new(), Vec::new());
    }
    let mut texels: Vec<u32> =
        (0..LINEAR_TABLE_SIZE).map(|byte| linear_from_srgb(byte as u8).to_bits()).collect();
    let mut places = Vec::new();
    for texture in scene_textures {
        places.push([texels.len() as u32, texture.width, texture.height]);
        texels.extend(texture.rgba.iter().map(|&rgba| u32::from_le_bytes(rgba)));
    }
    (places, texels)
}
