//! Shading on threads, with next queues compacted in canonical order.

use formats::ray::{Hit, Ray};
use glam::Vec3;
use rayon::prelude::*;
use scenes::features::Features;

use super::path::{Outcome, ShadowState, shade_path};
use super::tables::ShadeTables;
use crate::stages::shared::{PathState, ShadeParams};

/// What [`shade`] and the tracer on threads are specialised on. Lights are rows of a table there, and what a
/// scene has none of has no row: a branch that is never taken.
pub const SPECIALISED: Features = Features {
    alpha_masks: true,
    textures: true,
    emissive_triangles: false,
    sphere_lights: false,
    punctual_lights: false,
    environment: false,
    specular: true,
    vertex_normals: true,
};

/// Paths that one task shades.
const CHUNK: usize = 1 << 13;

/// A queue's next rays or shadow rays, state of type `S` beside each.
#[derive(Clone, Debug)]
pub struct Compacted<S> {
    /// The rays, in ascending path index.
    pub rays: Vec<Ray>,
    /// Path index of each.
    pub path_ids: Vec<u32>,
    /// State of each.
    pub states: Vec<S>,
}

impl<S> Default for Compacted<S> {
    fn default() -> Self {
        Self { rays: Vec::new(), path_ids: Vec::new(), states: Vec::new() }
    }
}

impl<S: Copy + Send + Sync> Compacted<S> {
    fn push(&mut self, pixel: u32, ray: Ray, state: S) {
        self.rays.push(ray);
        self.path_ids.push(pixel);
        self.states.push(state);
    }

    fn joined(parts: Vec<Self>) -> Self {
        let total = parts.iter().map(|part| part.rays.len()).sum();
        let mut all = Self {
            rays: Vec::with_capacity(total),
            path_ids: Vec::with_capacity(total),
            states: Vec::with_capacity(total),
        };
        for part in parts {
            all.rays.extend_from_slice(&part.rays);
            all.path_ids.extend_from_slice(&part.path_ids);
            all.states.extend_from_slice(&part.states);
        }
        all
    }
}

/// A queue as shading reads it.
#[derive(Clone, Copy, Debug)]
pub struct Paths<'a> {
    /// The rays.
    pub rays: &'a [Ray],
    /// What they hit.
    pub hits: &'a [Hit],
    /// Path index of each, ascending.
    pub path_ids: &'a [u32],
    /// State of each.
    pub states: &'a [PathState],
}

/// Shades a queue and adds what it met to `film`, one entry per pixel.
pub fn shade(
    tables: &ShadeTables,
    features: &Features,
    params: &ShadeParams,
    paths: Paths<'_>,
    film: &mut [Vec3],
) -> (Compacted<PathState>, Compacted<ShadowState>) {
    let specialised = match (features.textures, features.vertex_normals, features.specular) {
        (false, false, false) => shade_path::<false, false, false>,
        (false, false, true) => shade_path::<false, false, true>,
        (false, true, false) => shade_path::<false, true, false>,
        (false, true, true) => shade_path::<false, true, true>,
        (true, false, false) => shade_path::<true, false, false>,
        (true, false, true) => shade_path::<true, false, true>,
        (true, true, false) => shade_path::<true, true, false>,
        (true, true, true) => shade_path::<true, true, true>,
    };
    let shade_one = |index: usize| -> Outcome {
        specialised(
            tables,
            params,
            &paths.rays[index],
            &paths.hits[index],
            &paths.states[index],
            paths.path_ids[index],
        )
    };
    let chunks = film_chunks(paths.path_ids, film);
    let parts: Vec<_> = chunks
        .into_par_iter()
        .map(|FilmChunk { first, count, first_pixel, film }| {
            let (mut next, mut shadow) = (Compacted::default(), Compacted::default());
            for index in first..first + count {
                let outcome = shade_one(index);
                let pixel = paths.path_ids[index];
                if outcome.emitted != Vec3::ZERO {
                    film[pixel as usize - first_pixel] += outcome.emitted;
                }
                if let Some((ray, state)) = outcome.shadow {
                    shadow.push(pixel, ray, state);
                }
                if let Some((ray, state)) = outcome.next {
                    next.push(pixel, ray, state);
                }
            }
            (next, shadow)
        })
        .collect();
    let (next, shadow): (Vec<_>, Vec<_>) = parts.into_iter().unzip();
    (Compacted::joined(next), Compacted::joined(shadow))
}

/// Adds the light of the shadow rays that nothing blocked (`distances` is `+inf`).
pub fn add_light(path_ids: &[u32], states: &[ShadowState], distances: &[f32], film: &mut [Vec3]) {
    film_chunks(path_ids, film).into_par_iter().for_each(|FilmChunk { first, count, first_pixel, film }| {
        for index in first..first + count {
            if distances[index] == f32::INFINITY {
                film[path_ids[index] as usize - first_pixel] += Vec3::from(states[index].color);
            }
        }
    });
}

/// A run of paths and the pixels from its first path's to just before the next run's.
struct FilmChunk<'a> {
    first: usize,
    count: usize,
    first_pixel: usize,
    film: &'a mut [Vec3],
}

/// Splits the film between tasks; path indices ascend, so no two tasks share a pixel.
fn film_chunks<'a>(path_ids: &[u32], film: &'a mut [Vec3]) -> Vec<FilmChunk<'a>> {
    let mut chunks = Vec::new();
    let mut rest = film;
    let mut first_pixel = 0;
    for (number, chunk) in path_ids.chunks(CHUNK).enumerate() {
        let first = number * CHUNK;
        let end_pixel =
            path_ids.get(first + chunk.len()).map_or(first_pixel + rest.len(), |&pixel| pixel as usize);
        let (film, after) = rest.split_at_mut(end_pixel - first_pixel);
        chunks.push(FilmChunk { first, count: chunk.len(), first_pixel, film });
        (rest, first_pixel) = (after, end_pixel);
    }
    chunks
}
