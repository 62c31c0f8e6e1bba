//! What a built-in scene is made of besides triangles: materials, lights, cameras.

use glam::DVec3;

use super::BuiltinInfo;
use super::mesh::Canvas;
use crate::{Camera, Environment, Light, Material, Texture};

/// How to make a built-in scene.
pub(super) struct Recipe {
    /// What users are told about it.
    pub(super) info: BuiltinInfo,
    /// Everything but the triangles.
    pub(super) setting: fn() -> Setting,
    /// Draws the triangles.
    pub(super) draw: fn(&mut Canvas),
}

/// Everything but the triangles.
pub(super) struct Setting {
    pub(super) materials: Vec<Material>,
    pub(super) textures: Vec<Texture>,
    /// Spheres and punctual lights; emissive triangles become lights by themselves.
    pub(super) lights: Vec<Light>,
    pub(super) environment: Option<Environment>,
    pub(super) cameras: Vec<Camera>,
}

/// Collects materials and hands out their numbers.
#[derive(Default)]
pub(super) struct Materials(pub(super) Vec<Material>);

impl Materials {
    fn add(&mut self, material: Material) -> u32 {
        self.0.push(material);
        self.0.len() as u32 - 1
    }

    /// Diffuse.
    pub(super) fn matt(&mut self, name: &str, base_color: [f32; 3]) -> u32 {
        self.glossy(name, base_color, 1.0)
    }

    /// A dielectric with a highlight.
    pub(super) fn glossy(&mut self, name: &str, base_color: [f32; 3], roughness: f32) -> u32 {
        self.add(Material { name: name.into(), base_color, roughness, ..Material::default() })
    }

    /// A metal; roughness 0 is a mirror.
    pub(super) fn metal(&mut self, name: &str, base_color: [f32; 3], roughness: f32) -> u32 {
        let name = name.into();
        self.add(Material { name, base_color, roughness, metallic: 1.0, ..Material::default() })
    }

    /// A surface that emits this radiance and reflects nothing.
    pub(super) fn lamp(&mut self, name: &str, emission: [f32; 3]) -> u32 {
        let base_color = [0.0; 3];
        self.add(Material { name: name.into(), base_color, emission, ..Material::default() })
    }

    /// Diffuse, cut out by the alpha of a texture.
    pub(super) fn cut_out(&mut self, name: &str, base_color: [f32; 3], texture: u32) -> u32 {
        self.add(Material {
            name: name.into(),
            base_color,
            base_color_texture: Some(texture),
            alpha_cutoff: Some(0.5),
            ..Material::default()
        })
    }
}

/// A light of the kind the paper uses: a glowing sphere of radius 0.05.
pub(super) fn sphere_light(position: [f32; 3], intensity: [f32; 3]) -> Light {
    Light::Sphere { position, radius: 0.05, intensity }
}

/// A camera that stands at `eye` and looks at `target`, which is not straight above or below it.
pub(super) fn camera(name: &str, eye: [f64; 3], target: [f64; 3], yfov_turns: f64) -> Camera {
    let (eye, target) = (DVec3::from(eye), DVec3::from(target));
    let forward = (target - eye).normalize();
    let right = forward.cross(DVec3::Y).normalize();
    let up = right.cross(forward);
    Camera {
        name: name.into(),
        eye: eye.as_vec3().to_array(),
        forward: forward.as_vec3().to_array(),
        right: right.as_vec3().to_array(),
        up: up.as_vec3().to_array(),
        yfov_radians: (yfov_turns * std::f64::consts::TAU) as f32,
    }
}
