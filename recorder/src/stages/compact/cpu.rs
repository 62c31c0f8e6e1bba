//! Compact on threads: what the tasks of shading leave is joined in canonical order.

use formats::ray::Ray;

/// What a ray carries beside itself.
#[derive(Clone, Copy, Debug, Default)]
pub struct RayState {
    /// Throughput of the path; of a shadow ray the radiance that the film gets if it arrives.
    pub color: [f32; 3],
    /// Density over solid angle of a closest ray's direction; 0 for camera rays and mirrors.
    pub density: f32,
    /// Index of the scene's light to which a shadow ray goes.
    pub light: u32,
}

/// Rays with what they carry, in ascending path index; as many of each.
#[derive(Clone, Debug, Default)]
pub struct Paths {
    /// The rays.
    pub rays: Vec<Ray>,
    /// Path index of each.
    pub ids: Vec<u32>,
    /// State of each.
    pub states: Vec<RayState>,
}

impl Paths {
    /// Room for so many.
    fn with_capacity(count: usize) -> Self {
        Self {
            rays: Vec::with_capacity(count),
            ids: Vec::with_capacity(count),
            states: Vec::with_capacity(count),
        }
    }

    /// Adds one.
    pub fn push(&mut self, id: u32, (ray, state): (Ray, RayState)) {
        self.rays.push(ray);
        self.ids.push(id);
        self.states.push(state);
    }

    /// One after the other.
    pub fn joined(parts: &[Self]) -> Self {
        let mut all = Self::with_capacity(parts.iter().map(|part| part.rays.len()).sum());
        for part in parts {
            all.rays.extend_from_slice(&part.rays);
            all.ids.extend_from_slice(&part.ids);
            all.states.extend_from_slice(&part.states);
        }
        all
    }
}
