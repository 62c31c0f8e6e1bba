//! Shading on threads, with next queues compacted in canonical order.

use std::ops::Range;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use formats::prefetch::prefetch;
use glam::Vec3;
use rayon::prelude::*;
use scenes::features::Features;

use super::path::shade_path;
use super::tables::ShadeTables;
use crate::stages::compact::cpu::{Paths, PathsMut, compact};
use crate::stages::random::Random;
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
const CHUNK: usize = 1 << 9;
/// Tasks for each thread after which what they leave is moved together, while it is in the threads' own caches.
const TASKS_PER_THREAD: usize = 8;
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
    /// Makes and touches the memory that shading takes on these threads, and the queues that so many paths leave.
    pub fn make_room(&mut self, count: usize, live: [&mut Paths; 2]) {
        let tasks = TASKS_PER_THREAD * rayon::current_num_threads();
        self.counts.iter_mut().for_each(|counts| counts.resize(tasks, 0));
        self.left.iter_mut().for_each(|paths| paths.make_room(tasks * CHUNK));
        live.into_iter().for_each(|paths| paths.make_room(count));
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
        let shade = match (features.textures, features.vertex_normals, features.specular) {
            (false, false, false) => shade_best::<false, false, false>,
            (false, false, true) => shade_best::<false, false, true>,
            (false, true, false) => shade_best::<false, true, false>,
            (false, true, true) => shade_best::<false, true, true>,
            (true, false, false) => shade_best::<true, false, false>,
            (true, false, true) => shade_best::<true, false, true>,
            (true, true, false) => shade_best::<true, true, false>,
            (true, true, true) => shade_best::<true, true, true>,
        };
        let queue = Queue { tables, params, paths, hits, film };
        let Self { left: [next, shadow], counts: [next_counts, shadow_counts] } = self;
        let (count, [next_live, shadow_live]) = (paths.ids.len(), live);
        let mut live = [0; 2];
        for first in (0..count).step_by(next_counts.len() * CHUNK) {
            let left = next.parts().chunks(CHUNK).zip(shadow.parts().chunks(CHUNK));
            let counts = next_counts.par_iter_mut().zip(shadow_counts.par_iter_mut());
            left.zip(counts).enumerate().with_max_len(1).for_each(|(task, ((next, shadow), counts))| {
                let [start, end] = [task, task + 1].map(|task| (first + task * CHUNK).min(count));
                let left = shade(&queue, start..end, [next, shadow]);
                [*counts.0, *counts.1] = left.map(|count| count as u32);
            });
            let (next_more, shadow_more) = rayon::join(
                || compact(next, CHUNK, next_counts, next_live.parts().after(live[0])),
                || compact(shadow, CHUNK, shadow_counts, shadow_live.parts().after(live[1])),
            );
            live = [live[0] + next_more, live[1] + shadow_more];
        }
        live
    }
}

/// What is shaded.
struct Queue<'a> {
    tables: &'a ShadeTables,
    params: &'a ShadeParams,
    paths: &'a Paths,
    hits: &'a Hits,
    film: &'a Film,
}

/// Shades the paths of a range by code for AVX2 where the processor has it, with the same bits; says how many next
/// rays and shadow rays they leave.
fn shade_best<const TEXTURES: bool, const NORMALS: bool, const GLOSSY: bool>(
    queue: &Queue<'_>,
    range: Range<usize>,
    left: [PathsMut<'_>; 2],
) -> [usize; 2] {
    #[cfg(target_arch = "x86_64")]
    if is_x86_feature_detected!("avx2") {
        // SAFETY: the processor has AVX2.
        return unsafe { shade_range_avx2::<TEXTURES, NORMALS, GLOSSY>(queue, range, left) };
    }
    shade_range::<TEXTURES, NORMALS, GLOSSY>(queue, range, left)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn shade_range_avx2<const TEXTURES: bool, const NORMALS: bool, const GLOSSY: bool>(
    queue: &Queue<'_>,
    range: Range<usize>,
    left: [PathsMut<'_>; 2],
) -> [usize; 2] {
    shade_range::<TEXTURES, NORMALS, GLOSSY>(queue, range, left)
}

#[inline(always)]
fn shade_range<const TEXTURES: bool, const NORMALS: bool, const GLOSSY: bool>(
    queue: &Queue<'_>,
    range: Range<usize>,
    [mut next, mut shadow]: [PathsMut<'_>; 2],
) -> [usize; 2] {
    let Queue { tables, params, paths, hits, film } = *queue;
    let (mut next_count, mut shadow_count) = (0, 0);
    let random = Random::of_queue(params.seed, params.pass_index, params.bounce + 1);
    for index in range {
        ask_ahead(tables, hits, index);
        let (ray, state, pixel) = (&paths.rays[index], &paths.states[index], paths.ids[index]);
        let outcome = shade_path::<TEXTURES, NORMALS, GLOSSY>(
            tables,
            params,
            ray,
            &hits.hit(index),
            state,
            Random::of_pixel(random, pixel),
        );
        if outcome.emitted != Vec3::ZERO {
            add(&film[pixel as usize], outcome.emitted);
        }
        if let Some((ray, light)) = outcome.shadow {
            shadow.put(shadow_count, pixel, ray, light);
            shadow_count += 1;
        }
        if let Some(ray) = outcome.next {
            next.put(next_count, pixel, ray, 0);
            next_count += 1;
        }
    }
    [next_count, shadow_count]
}

/// Asks for the surfaces of the next paths, which lie far apart.
#[inline(always)]
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
