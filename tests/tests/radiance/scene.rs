//! Scenes put together by hand.

use scenes::{Camera, Environment, Light, Material, Scene};
use tests::shapes::Triangle;

/// Surfaces of one material each, lights, and a camera.
pub(crate) struct SceneOf {
    scene: Scene,
}

/// Diffuse, of one reflectance for all colours.
pub(crate) fn matt(reflectance: f32) -> Material {
    Material { base_color: [reflectance; 3], ..Material::default() }
}

/// Emits the same radiance in all directions, and reflects.
pub(crate) fn glowing(reflectance: f32, radiance: f32) -> Material {
    Material { emission: [radiance; 3], ..matt(reflectance) }
}

/// Reflects as a mirror, of one reflectance at normal incidence.
pub(crate) fn mirror(reflectance: f32) -> Material {
    Material { metallic: 1.0, roughness: 0.0, ..matt(reflectance) }
}

/// The two triangles of a parallelogram.
pub(crate) fn parallelogram(corner: [f32; 3], along: [f32; 3], up: [f32; 3]) -> Vec<Triangle> {
    let plus = |a: [f32; 3], b: [f32; 3]| [0, 1, 2].map(|axis| a[axis] + b[axis]);
    let (b, d) = (plus(corner, along), plus(corner, up));
    let c = plus(b, up);
    vec![[corner, b, c], [corner, c, d]]
}

impl SceneOf {
    /// Nothing yet but a camera at `eye` that looks at `target`.
    pub(crate) fn seen(eye: [f32; 3], target: [f32; 3], yfov_degrees: f32) -> Self {
        let up = if (eye[0] - target[0]).abs() + (eye[2] - target[2]).abs() > 1e-3 {
            [0.0, 1.0, 0.0]
        } else {
            [0.0, 0.0, 1.0]
        };
        let mut scene = Scene::of_geometry("known".into(), Vec::new(), Vec::new());
        scene.materials.clear();
        scene.cameras = vec![Camera::look_at("test", eye, target, up, yfov_degrees.to_radians()).unwrap()];
        Self { scene }
    }

    /// Adds a surface; one that glows is a light, too.
    pub(crate) fn surface(mut self, triangles: &[Triangle], material: Material) -> Self {
        let scene = &mut self.scene;
        let first_triangle = scene.triangles.len() as u32;
        if material.is_emissive() {
            scene.lights.push(Light::Emissive { first_triangle, triangle_count: triangles.len() as u32 });
        }
        let number = scene.materials.len() as u32;
        for triangle in triangles {
            let vertex = scene.positions.len() as u32;
            scene.positions.extend(triangle);
            scene.triangles.push([vertex, vertex + 1, vertex + 2]);
            scene.triangle_materials.push(number);
        }
        scene.materials.push(material);
        self
    }

    pub(crate) fn light(mut self, light: Light) -> Self {
        self.scene.lights.push(light);
        self
    }

    /// Light of radiance 1 from everywhere.
    pub(crate) fn white_sky(self) -> Self {
        self.light(Light::Environment(Environment { zenith: [1.0; 3], nadir: [1.0; 3] }))
    }

    pub(crate) fn scene(self) -> Scene {
        self.scene
    }
}
