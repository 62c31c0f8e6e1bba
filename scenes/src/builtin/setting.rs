//! What a built-in scene is made of besides triangles: materials, lights, cameras.

use glam::DVec3;

use super::canvas::Canvas;
use crate::{Camera, Environment, Light, Material, Scene};

/// How to make a built-in scene.
pub(super) struct Recipe {
    pub(super) name: &'static str,
    pub(super) description: &'static str,
    /// The fewest it can have, how many it has if none are asked for, and the most.
    pub(super) triangles: [u64; 3],
    /// Everything but the triangles, and the lights that they are.
    pub(super) setting: fn() -> Scene,
    /// Draws the triangles.
    pub(super) draw: fn(&mut Canvas),
}

/// The materials of a scene, `NUMBER = material;` each: a constant that strokes take, and
/// `materials()`, which lists them in the same order.
macro_rules! palette {
    ($($number:ident = $material:expr;)*) => {
        #[allow(clippy::upper_case_acronyms, non_camel_case_types, reason = "they name constants")]
        enum Number { $($number),* }
        $(const $number: u32 = Number::$number as u32;)*
        fn materials() -> Vec<crate::Material> {
            vec![$($material),*]
        }
    };
}
pub(super) use palette;

/// Diffuse.
pub(super) fn matt(name: &str, base_color: [f32; 3]) -> Material {
    glossy(name, base_color, 1.0)
}

/// A dielectric with a highlight.
pub(super) fn glossy(name: &str, base_color: [f32; 3], roughness: f32) -> Material {
    Material { name: name.into(), base_color, roughness, ..Material::default() }
}

/// A metal; roughness 0 is a mirror.
pub(super) fn metal(name: &str, base_color: [f32; 3], roughness: f32) -> Material {
    Material { metallic: 1.0, ..glossy(name, base_color, roughness) }
}

/// A surface that emits this radiance and reflects nothing.
pub(super) fn lamp(name: &str, emission: [f32; 3]) -> Material {
    Material { name: name.into(), base_color: [0.0; 3], emission, ..Material::default() }
}

/// Diffuse, of the colour of a texture and cut out by its alpha.
pub(super) fn cut_out(name: &str, texture: u32) -> Material {
    let (base_color_texture, alpha_cutoff) = (Some(texture), Some(0.5));
    Material { base_color_texture, alpha_cutoff, ..matt(name, [1.0; 3]) }
}

/// A light of the kind the paper uses: a glowing sphere of radius 0.05.
pub(super) fn sphere_light(position: [f32; 3], intensity: [f32; 3]) -> Light {
    Light::Sphere { position, radius: 0.05, intensity }
}

/// Light from all around; the last light of a scene.
pub(super) fn environment(zenith: [f32; 3], nadir: [f32; 3]) -> Light {
    Light::Environment(Environment { zenith, nadir })
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
