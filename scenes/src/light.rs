//! Lights: what shadow rays are sent to.

use serde::Deserialize;

use crate::bounds::Bounds;

/// One light. Radiometric values are linear RGB.
#[derive(Clone, Debug, PartialEq)]
pub enum Light {
    /// A glowing sphere that shadow rays sample and no ray hits (the paper's point lights, radius 0.05).
    Sphere {
        /// Centre in world space.
        position: [f32; 3],
        /// Radius in world units, > 0.
        radius: f32,
        /// Radiant intensity in W/sr: radiance times the area of the disk, `π·radius²`.
        intensity: [f32; 3],
    },
    /// A point without extent (`KHR_lights_punctual` point).
    Point {
        /// Place in world space.
        position: [f32; 3],
        /// Radiant intensity in W/sr.
        intensity: [f32; 3],
    },
    /// A cone of light (`KHR_lights_punctual` spot).
    Spot {
        /// Place in world space.
        position: [f32; 3],
        /// Unit vector in which the light shines.
        direction: [f32; 3],
        /// Radiant intensity on the axis in W/sr.
        intensity: [f32; 3],
        /// Cosine of the angle at which the fall-off starts.
        inner_cone_cos: f32,
        /// Cosine of the angle at which nothing is left; less than `inner_cone_cos`.
        outer_cone_cos: f32,
    },
    /// Parallel light (`KHR_lights_punctual` directional).
    Directional {
        /// Unit vector in which the light shines.
        direction: [f32; 3],
        /// Irradiance on a surface that faces the light, W/m².
        irradiance: [f32; 3],
    },
    /// The emissive triangles of one mesh primitive (one per instance); their material says how bright.
    Emissive {
        /// First triangle in the scene.
        first_triangle: u32,
        /// How many triangles follow it.
        triangle_count: u32,
    },
    /// Light from everywhere outside; at most one per scene, and the last light.
    Environment(Environment),
}

/// A sky: radiance mixed linearly by the height of the direction, `y` up.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Environment {
    /// Radiance straight up, W/(sr·m²), linear RGB.
    pub zenith: [f32; 3],
    /// Radiance straight down.
    pub nadir: [f32; 3],
}

impl Light {
    /// Centre in world space, for lights that have a place; `None` for directional ones and the environment.
    /// An emissive primitive's centre is the centre of its bounding box.
    pub fn centre(&self, scene: &crate::Scene) -> Option<[f32; 3]> {
        match *self {
            Self::Sphere { position, .. } | Self::Point { position, .. } | Self::Spot { position, .. } => {
                Some(position)
            }
            Self::Emissive { first_triangle, triangle_count } => {
                let triangles = first_triangle as usize..(first_triangle + triangle_count) as usize;
                let indices = scene.triangles[triangles].iter().flatten();
                Some(Bounds::of(indices.map(|&index| &scene.positions[index as usize])).centre())
            }
            Self::Directional { .. } | Self::Environment(_) => None,
        }
    }
}
