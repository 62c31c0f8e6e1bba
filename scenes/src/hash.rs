//! The content hash: what a scene is, in 32 bytes.

use bytemuck::NoUninit;
use sha2::{Digest, Sha256};

use crate::{Light, Material, Scene, Texture};

/// Changes whenever the bytes that are hashed change their meaning.
const DOMAIN: &[u8] = b"rayscope scene 1";

#[cfg(target_endian = "big")]
compile_error!("numbers are hashed as they lie in memory, which must be little-endian");

/// SHA-256 over all that a recording depends on: geometry, materials, textures and lights, each
/// array preceded by its length. Names, cameras and notices do not count.
pub fn content_hash(scene: &Scene) -> [u8; 32] {
    let mut hasher = Hasher(Sha256::new());
    hasher.0.update(DOMAIN);
    hasher.array(&scene.positions);
    hasher.array(&scene.normals);
    hasher.array(&scene.uvs);
    hasher.array(&scene.triangles);
    hasher.array(&scene.triangle_materials);
    hasher.length(scene.materials.len());
    for material in &scene.materials {
        hasher.material(material);
    }
    hasher.length(scene.textures.len());
    for Texture { width, height, rgba } in &scene.textures {
        hasher.values(&[*width, *height]);
        hasher.array(rgba);
    }
    hasher.length(scene.lights.len());
    for light in &scene.lights {
        hasher.light(light);
    }
    hasher.0.finalize().into()
}

struct Hasher(Sha256);

impl Hasher {
    fn length(&mut self, length: usize) {
        self.0.update((length as u64).to_le_bytes());
    }

    fn values<T: NoUninit>(&mut self, values: &[T]) {
        self.0.update(bytemuck::cast_slice::<T, u8>(values));
    }

    /// Values with their number before them.
    fn array<T: NoUninit>(&mut self, values: &[T]) {
        self.length(values.len());
        self.values(values);
    }

    fn material(&mut self, material: &Material) {
        let Material {
            name: _,
            base_color,
            base_color_texture,
            metallic,
            roughness,
            emission,
            alpha_cutoff,
            alpha,
        } = material;
        self.values(base_color);
        self.values(&[u8::from(base_color_texture.is_some())]);
        self.values(&[base_color_texture.unwrap_or(0)]);
        self.values(&[*metallic, *roughness, *alpha]);
        self.values(emission);
        self.values(&[u8::from(alpha_cutoff.is_some())]);
        self.values(&[alpha_cutoff.unwrap_or(0.0)]);
    }

    /// A number that says which kind of light follows, and the light.
    fn light(&mut self, light: &Light) {
        match light {
            Light::Sphere { position, radius, intensity } => {
                self.values(&[0_u8]);
                self.values(position);
                self.values(&[*radius]);
                self.values(intensity);
            }
            Light::Point { position, intensity } => {
                self.values(&[1_u8]);
                self.values(&[*position, *intensity]);
            }
            Light::Spot { position, direction, intensity, inner_cone_cos, outer_cone_cos } => {
                self.values(&[2_u8]);
                self.values(&[*position, *direction, *intensity]);
                self.values(&[*inner_cone_cos, *outer_cone_cos]);
            }
            Light::Directional { direction, irradiance } => {
                self.values(&[3_u8]);
                self.values(&[*direction, *irradiance]);
            }
            Light::Emissive { first_triangle, triangle_count } => {
                self.values(&[4_u8]);
                self.values(&[*first_triangle, *triangle_count]);
            }
            Light::Environment(crate::Environment { zenith, nadir }) => {
                self.values(&[5_u8]);
                self.values(&[*zenith, *nadir]);
            }
        }
    }
}
