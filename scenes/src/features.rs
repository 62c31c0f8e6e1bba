//! What a scene uses of all that a tracer can do, so that what is absent costs nothing.

use crate::{Light, Material, Scene};

/// Which capabilities a scene needs. Materials count only if a triangle has them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub struct Features {
    /// Surfaces with holes, so that every hit must be looked up in a texture.
    pub alpha_masks: bool,
    /// Base-colour textures.
    pub textures: bool,
    /// Triangles that emit light.
    pub emissive_triangles: bool,
    /// Glowing spheres.
    pub sphere_lights: bool,
    /// Point, spot and directional lights.
    pub punctual_lights: bool,
    /// Light from everywhere outside.
    pub environment: bool,
    /// Surfaces with a GGX lobe: metallic above 0 or roughness below 1. A material with metallic 0
    /// and roughness 1 is purely diffuse; glTF would give it a lobe of F0 = 0.04 that is too wide to
    /// be seen, and leaving it out is what lets a scene without gloss skip the lobe [choice].
    pub specular: bool,
    /// Normals that differ from the triangle's own.
    pub vertex_normals: bool,
}

impl Features {
    /// What `scene` uses.
    pub fn of(scene: &Scene) -> Self {
        let mut is_used = vec![false; scene.materials.len()];
        for &material in &scene.triangle_materials {
            is_used[material as usize] = true;
        }
        let materials = scene.materials.iter().zip(is_used).filter(|(_, is_used)| *is_used);
        let any_material = |has: fn(&Material) -> bool| materials.clone().any(|(material, _)| has(material));
        let any_light = |is: fn(&Light) -> bool| scene.lights.iter().any(is);
        Self {
            alpha_masks: any_material(|material| material.alpha_threshold() > 0),
            textures: any_material(|material| material.base_color_texture.is_some()),
            emissive_triangles: any_material(Material::is_emissive),
            sphere_lights: any_light(|light| matches!(light, Light::Sphere { .. })),
            punctual_lights: any_light(|light| {
                matches!(light, Light::Point { .. } | Light::Spot { .. } | Light::Directional { .. })
            }),
            environment: any_light(|light| matches!(light, Light::Environment(_))),
            specular: any_material(Material::is_specular),
            vertex_normals: !scene.normals.is_empty(),
        }
    }

    /// Names of what is used.
    pub fn used(&self) -> Vec<&'static str> {
        self.names(true)
    }

    /// Names of what is not used and therefore skipped.
    pub fn skipped(&self) -> Vec<&'static str> {
        self.names(false)
    }

    /// Each feature on its own, with its name.
    pub fn each() -> [(&'static str, Self); 8] {
        let none = Self::default();
        [
            ("alpha-masks", Self { alpha_masks: true, ..none }),
            ("textures", Self { textures: true, ..none }),
            ("emissive-triangles", Self { emissive_triangles: true, ..none }),
            ("sphere-lights", Self { sphere_lights: true, ..none }),
            ("punctual-lights", Self { punctual_lights: true, ..none }),
            ("environment", Self { environment: true, ..none }),
            ("specular", Self { specular: true, ..none }),
            ("vertex-normals", Self { vertex_normals: true, ..none }),
        ]
    }

    /// What either of two has.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self {
            alpha_masks: self.alpha_masks || other.alpha_masks,
            textures: self.textures || other.textures,
            emissive_triangles: self.emissive_triangles || other.emissive_triangles,
            sphere_lights: self.sphere_lights || other.sphere_lights,
            punctual_lights: self.punctual_lights || other.punctual_lights,
            environment: self.environment || other.environment,
            specular: self.specular || other.specular,
            vertex_normals: self.vertex_normals || other.vertex_normals,
        }
    }

    fn names(&self, used: bool) -> Vec<&'static str> {
        let has = |feature: Self| self.union(feature) == *self;
        Self::each().into_iter().filter(|&(_, feature)| has(feature) == used).map(|(name, _)| name).collect()
    }
}
