//! Rays, hits and counters, byte for byte as they lie in a dump and in the buffers of a GPU.

use bytemuck::{Pod, Zeroable};
use serde::{Deserialize, Serialize};

/// Largest absolute coordinate of a ray's origin, world units (2^60): with it, and coordinates of the scene of at most
/// 2^40, no edge function of the triangle test overflows.
pub const ORIGIN_LIMIT: f32 = (1u64 << 60) as f32;

/// A ray in world space; 32 bytes, and in memory aligned to them: rays that are read in no order then never lie
/// in two cache lines.
#[repr(C, align(32))]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Ray {
    /// Start, world units; at most [`ORIGIN_LIMIT`] either way.
    pub origin: [f32; 3],
    /// Hits nearer than this do not count, world units, ≥ 0.
    pub t_min: f32,
    /// Unit vector.
    pub direction: [f32; 3],
    /// Hits farther than this do not count, world units; `+inf` for closest rays.
    pub t_max: f32,
}

/// The nearest hit of a ray; 16 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Hit {
    /// Distance along the ray in world units; `+inf` on a miss.
    pub t: f32,
    /// Index of the triangle; [`Hit::NONE`] on a miss.
    pub triangle: u32,
    /// Barycentric weight of the triangle's second corner, 0 to 1.
    pub u: f32,
    /// Barycentric weight of the triangle's third corner, 0 to 1.
    pub v: f32,
}

impl Hit {
    /// The triangle index of a miss.
    pub const NONE: u32 = u32::MAX;

    /// What a ray gets that hits nothing.
    pub const MISS: Self = Self { t: f32::INFINITY, triangle: Self::NONE, u: 0.0, v: 0.0 };

    /// Whether the ray hit a triangle.
    pub fn is_hit(&self) -> bool {
        self.triangle != Self::NONE
    }
}

/// What a trace kernel did for one ray; 8 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct Work {
    /// Hierarchy nodes visited.
    pub nodes: u32,
    /// Triangles tested.
    pub triangles: u32,
}

/// What a queue's rays ask for; in manifests the number of the variant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// The nearest hit: camera and secondary rays.
    Closest,
    /// Any hit between a surface and a light sample.
    Shadow,
}

impl Kind {
    /// Both kinds, in the order in which a bounce traces them.
    pub const ALL: [Self; 2] = [Self::Closest, Self::Shadow];

    /// Name in paths, tables and JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::Closest => "closest",
            Self::Shadow => "shadow",
        }
    }
}

impl std::fmt::Display for Kind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(self.name())
    }
}
