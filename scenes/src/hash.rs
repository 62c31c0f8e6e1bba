//! The content hash: what a scene is, in 32 bytes.

use sha2::{Digest, Sha256};

use crate::{Light, Material, Scene, Texture};

/// Changes whenever the bytes that are hashed change their meaning.
const DOMAIN: &[u8] = b"rayscope scene 1";

/// SHA-256 over all that a recording depends on: geometry, materials, textures and lights, each
/// array preceded by its length. Names, cameras and notices do not count. All numbers are hashed in
/// little-endian order, so every machine gets the same.
pub fn content_hash(scene: &Scene) -> [u8; 32] {
    let mut hasher = Hasher(Sha256::new());
    hasher.0.update(DOMAIN);
    hasher.rows(&scene.positions, f32::to_le_bytes);
    hasher.rows(&scene.normals, f32::to_le_bytes);
    hasher.rows(&scene.uvs, f32::to_le_bytes);
    hasher.rows(&scene.triangles, u32::to_le_bytes);
    hasher.length(scene.triangle_materials.len());
    hasher.words(&scene.triangle_materials, u32::to_le_bytes);
    hasher.length(scene.materials.len());
    for material in &scene.materials {
        hasher.material(material);
    }
    hasher.length(scene.textures.len());
    for Texture { width, height, rgba } in &scene.textures {
        hasher.words(&[*width, *height], u32::to_le_bytes);
        hasher.length(rgba.len());
        hasher.0.update(rgba.as_flattened());
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

    /// An array of rows, with its length.
    fn rows<T: Copy, const N: usize>(&mut self, rows: &[[T; N]], bytes: fn(T) -> [u8; 4]) {
        self.length(rows.len());
        self.words(rows.as_flattened(), bytes);
    }

    fn words<T: Copy>(&mut self, words: &[T], bytes: fn(T) -> [u8; 4]) {
        /// Words are turned into bytes in pieces that stay in the cache.
        const WORDS_AT_A_TIME: usize = 4096;

        let mut buffer = [[0; 4]; WORDS_AT_A_TIME];
        for words in words.chunks(WORDS_AT_A_TIME) {
            for (bytes_of_word, &word) in buffer.iter_mut().zip(words) {
                *bytes_of_word = bytes(word);
            }
            self.0.update(buffer[..words.len()].as_flattened());
        }
    }

    fn floats(&mut self, floats: &[f32]) {
        self.words(floats, f32::to_le_bytes);
    }

    /// A number that says which variant follows.
    fn tag(&mut self, tag: u8) {
        self.0.update([tag]);
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
        self.floats(base_color);
        self.tag(u8::from(base_color_texture.is_some()));
        self.words(&[base_color_texture.unwrap_or(0)], u32::to_le_bytes);
        self.floats(&[*metallic, *roughness, *alpha]);
        self.floats(emission);
        self.tag(u8::from(alpha_cutoff.is_some()));
        self.floats(&[alpha_cutoff.unwrap_or(0.0)]);
    }

    fn light(&mut self, light: &Light) {
        match light {
            Light::Sphere { position, radius, intensity } => {
                self.tag(0);
                self.floats(position);
                self.floats(&[*radius]);
                self.floats(intensity);
            }
            Light::Point { position, intensity } => {
                self.tag(1);
                self.floats(position);
                self.floats(intensity);
            }
            Light::Spot { position, direction, intensity, inner_cone_cos, outer_cone_cos } => {
                self.tag(2);
                self.floats(position);
                self.floats(direction);
                self.floats(intensity);
                self.floats(&[*inner_cone_cos, *outer_cone_cos]);
            }
            Light::Directional { direction, irradiance } => {
                self.tag(3);
                self.floats(direction);
                self.floats(irradiance);
            }
            Light::Emissive { first_triangle, triangle_count } => {
                self.tag(4);
                self.words(&[*first_triangle, *triangle_count], u32::to_le_bytes);
            }
            Light::Environment(crate::Environment { zenith, nadir }) => {
                self.tag(5);
                self.floats(zenith);
                self.floats(nadir);
            }
        }
    }
}
