//! Shading on threads, with next queues compacted in canonical order.

use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use formats::prefetch::prefetch;
use glam::Vec3;
use rayon::prelude::*;
use scenes::features::Features;

use super::path::{Outcome, shade_path};
use super::tables::ShadeTables;
use crate::stages::compact::cpu::{Paths, compact};
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
const CHUNK: usize = 1 << 12;
/// How many paths ahead the corners of a hit triangle are asked for; its indices twice as many.
const CORNERS_AHEAD: usize = 4;

/// Light that each pixel got, linear RGB, the bits of an f32 each; a pixel is written by one task at a time.
pub type Film = Vec<[AtomicU32; 3]>;

/// A film on which no light fell.
pub fn dark_film(pixels: usize) -> Film {
    (0..pixels).map(|_| Default::default()).collect()
}

/// Light of a pixel.
pub fn light_of(pixel: &[AtomicU32; 3]) -> [f32; 3] {
    [0, 1, 2].map(|channel| f32::from_bits(pixel[channel].load(Relaxed)))
}

fn add(pixel: &[AtomicU32; 3], light: Vec3) {
    let sum = (Vec3::from(light_of(pixel)) + light).to_array();
    (0..3).for_each(|channel| pixel[channel].store(sum[channel].to_bits(), Relaxed));
}

/// Shades, in memory that it keeps for the next time.
#[derive(Debug, Default)]
pub struct Shader {
    /// Next rays and shadow rays as the tasks leave them, each task's from the start of its chunk.
    left: [Paths; 2],
    /// How many each task leaves.
    counts: [Vec<u32>; 2],
}

impl Shader {
    /// Makes and touches the memory that shading so many paths takes, and the queues that it leaves.
    pub fn make_room(&mut self, count: usize, live: [&mut Paths; 2]) {
        self.left.iter_mut().chain(live).for_each(|paths| paths.make_room(count));
        self.counts.iter_mut().for_each(|counts| counts.resize(count.div_ceil(CHUNK), 0));
    }

    /// Shades a queue and adds what it met to `film`; leaves next rays and shadow rays in `live`, which has
    /// room for as many as there are paths, and returns how many of each there are.
    ///
    /// # Panics
    /// If [`Shader::make_room`] did not come before.
    pub fn shade(
        &mut self,
        tables: &ShadeTables,
        features: &Features,
        params: &ShadeParams,
        (paths, hits): (&Paths, &Hits),
        film: &Film,
        live: [&mut Paths; 2],
    ) -> [usize; 2] {
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
        let [next, shadow] = &mut self.left;
        let [next_counts, shadow_counts] = &mut self.counts;
        let left = next.parts().chunks(CHUNK).zip(shadow.parts().chunks(CHUNK));
        let counts = next_counts.par_iter_mut().zip(shadow_counts.par_iter_mut());
        left.zip(counts).enumerate().with_max_len(1).for_each(|(chunk, ((mut next, mut shadow), counts))| {
            let (mut next_count, mut shadow_count) = (0, 0);
            let first = chunk * CHUNK;
            for index in first..paths.ids.len().min(first + CHUNK) {
                ask_ahead(tables, hits, index);
                let outcome = shade_one(index);
                let pixel = paths.ids[index];
                if outcome.emitted != Vec3::ZERO {
                    add(&film[pixel as usize], outcome.emitted);
                }
                if let Some(ray) = outcome.shadow {
                    shadow.put(shadow_count, pixel, ray);
                    shadow_count += 1;
                }
                if let Some(ray) = outcome.next {
                    next.put(next_count, pixel, ray);
                    next_count += 1;
                }
            }
            (*counts.0, *counts.1) = (next_count as u32, shadow_count as u32);
        });
        let [next_live, shadow_live] = live;
        let (next, shadow) = rayon::join(
            || compact(&self.left[0], CHUNK, &self.counts[0], next_live),
            || compact(&self.left[1], CHUNK, &self.counts[1], shadow_live),
        );
        [next, shadow]
    }
}

/// Asks for the surfaces of the next paths, which lie far apart.
fn ask_ahead(tables: &ShadeTables, hits: &Hits, index: usize) {
    let triangle = |ahead: usize| {
        let at = index + ahead;
        (at < hits.len()).then(|| tables.triangles.get(hits.hit(at).triangle as usize)).flatten()
    };
    if let Some(triangle) = triangle(2 * CORNERS_AHEAD) {
        prefetch(triangle);
    }
    for &corner in triangle(CORNERS_AHEAD).into_iter().flat_map(|triangle| &triangle[..3]) {
        prefetch(&tables.positions[corner as usize]);
        tables.normals.get(corner as usize).into_iter().for_each(prefetch);
    }
}

/// Adds the light of the shadow rays that nothing blocked.
pub fn add_light(paths: &Paths, hits: &Hits, film: &Film) {
    (0..paths.ids.len()).into_par_iter().with_min_len(CHUNK).for_each(|index| {
        if hits.distance(index) == f32::INFINITY {
            add(&film[paths.ids[index] as usize], Vec3::from(paths.states[index].color));
        }
    });
}
