//! What a scene is once it is loaded: flat arrays in world space.

use crate::bounds::Bounds;
use crate::{Camera, Light, Material, Texture};

/// A scene in world space, ready to trace: instances flattened, everything finite and in range.
///
/// Invariants, kept by every loader: all positions are finite; every index is in range; at least
/// one triangle and one camera; `triangle_materials.len() == triangles.len()`; `normals` and
/// `uvs` are empty or have one entry per position. The default is empty: what a loader begins with.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// File stem or built-in name.
    pub name: String,
    /// World-space vertex positions.
    pub positions: Vec<[f32; 3]>,
    /// Unit vertex normals, or a zero vector where a vertex has none (the face normal counts
    /// there). Empty if no vertex has a normal.
    pub normals: Vec<[f32; 3]>,
    /// Texture coordinates (glTF convention: v runs down). Empty if no material has a texture.
    pub uvs: Vec<[f32; 2]>,
    /// Vertex indices, three per triangle. Degenerate triangles stay: they are never hit.
    pub triangles: Vec<[u32; 3]>,
    /// Index into `materials` per triangle.
    pub triangle_materials: Vec<u32>,
    /// At least one.
    pub materials: Vec<Material>,
    /// Base-colour textures that materials refer to.
    pub textures: Vec<Texture>,
    /// All lights in the order that numbers them: file, sidecar, emissive mesh primitives, environment.
    pub lights: Vec<Light>,
    /// At least one; the first is the default.
    pub cameras: Vec<Camera>,
    /// What the loader wants to tell the user, one sentence each (unknown extensions, a made-up
    /// camera, degenerate triangles …).
    pub notices: Vec<String>,
}

impl Scene {
    /// Geometry alone, as a recording holds it: one plain material, no lights, no cameras. Enough to
    /// trace rays through, not to make pictures.
    pub fn of_geometry(name: String, positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> Self {
        Self {
            name,
            positions,
            triangle_materials: vec![0; triangles.len()],
            triangles,
            materials: vec![Material::default()],
            ..Self::default()
        }
    }

    /// Turns every point light into a sphere of this radius, world units, as intense, and says so in a notice; the
    /// paper gives its point lights a radius of 0.05. Spot lights and parallel light stay sharp.
    pub fn give_points_a_radius(&mut self, radius: f32) {
        let mut changed = 0;
        for light in &mut self.lights {
            if let Light::Point { position, intensity } = *light {
                *light = Light::Sphere { position, radius, intensity };
                changed += 1;
            }
        }
        self.notices.push(match changed {
            0 => "no light of the scene is a point that could be given a radius".to_owned(),
            _ => format!("point lights were given a radius of {radius} ({changed} of {})", self.lights.len()),
        });
    }

    /// The box around all vertices that a triangle refers to.
    pub fn bounds(&self) -> Bounds {
        Bounds::of(self.triangles.iter().flatten().map(|&index| &self.positions[index as usize]))
    }

    /// World-space corners of a triangle.
    pub fn corners(&self, triangle: usize) -> [[f32; 3]; 3] {
        self.triangles[triangle].map(|index| self.positions[index as usize])
    }
}
