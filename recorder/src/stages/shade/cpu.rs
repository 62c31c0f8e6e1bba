//! Shading on threads, with next queues compacted in canonical order.

use glam::Vec3;
use rayon::prelude::*;
use scenes::features::Features;

use super::path::{Outcome, shade_path};
use super::tables::ShadeTables;
use crate::stages::compact::cpu::Paths;
use crate::stages::shared::ShadeParams;
use crate::stages::trace::hits::Hits;

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

/// Shades a queue and adds what it met to `film`, one entry per pixel; returns next rays and shadow rays.
pub fn shade(
    tables: &ShadeTables,
    features: &Features,
    params: &ShadeParams,
    (paths, hits): (&Paths, &Hits),
    film: &mut [Vec3],
) -> [Paths; 2] {
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
        let (ray, state, pixel) = (&paths.rays[index], &paths.states[index], paths.ids[index]);
        specialised(tables, params, ray, &hits.hit(index), state, pixel)
    };
    let chunks = film_chunks(&paths.ids, film);
    let parts: Vec<_> = chunks
        .into_par_iter()
        .map(|FilmChunk { first, count, first_pixel, film }| {
            let (mut next, mut shadow) = (Paths::default(), Paths::default());
            for index in first..first + count {
                let outcome = shade_one(index);
                let pixel = paths.ids[index];
                if outcome.emitted != Vec3::ZERO {
                    film[pixel as usize - first_pixel] += outcome.emitted;
                }
                outcome.shadow.into_iter().for_each(|ray| shadow.push(pixel, ray));
                outcome.next.into_iter().for_each(|ray| next.push(pixel, ray));
            }
            (next, shadow)
        })
        .collect();
    let (next, shadow): (Vec<_>, Vec<_>) = parts.into_iter().unzip();
    [Paths::joined(&next), Paths::joined(&shadow)]
}

/// Adds the light of the shadow rays that nothing blocked.
pub fn add_light(paths: &Paths, hits: &Hits, film: &mut [Vec3]) {
    film_chunks(&paths.ids, film).into_par_iter().for_each(
        |FilmChunk { first, count, first_pixel, film }| {
            for index in first..first + count {
                if hits.distance(index) == f32::INFINITY {
                    film[paths.ids[index] as usize - first_pixel] += Vec3::from(paths.states[index].color);
                }
            }
        },
    );
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
