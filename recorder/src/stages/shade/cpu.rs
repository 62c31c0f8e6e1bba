//! Shading on threads, with next queues compacted in canonical order.

use std::array::from_fn;
use std::ops::Range;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use fearless_simd::prelude::*;
use fearless_simd::{Level, dispatch, mask32x8, u32x8};
use formats::prefetch::prefetch;
use formats::ray::Ray;
use glam::Vec3;
use rayon::prelude::*;
use scenes::features::Features;

use super::path::{Arriving, Leaving, Outcome, shade_paths};
use super::tables::ShadeTables;
use crate::stages::compact::cpu::{Paths, PathsMut, compact};
use crate::stages::eight::{LANES, Vec3x8};
use crate::stages::random::{Random, RandomX8};
use crate::stages::shared::{PathState, ShadeParams};
use crate::stages::trace::hits::Hits;

/// What tracing and the arrays that shading reads are specialised on. Lobes and lights are asked for by eight paths at
/// once: a branch that is never taken where a scene has none.
pub const SPECIALISED: Features = Features {
    alpha_masks: true,
    textures: true,
    emissive_triangles: false,
    sphere_lights: false,
    punctual_lights: false,
    environment: false,
    specular: false,
    vertex_normals: true,
};

/// Paths that one task shades.
const CHUNK: usize = 1 << 9;
/// Tasks for each thread after which what they leave is moved together, while it is in the threads' own caches.
const TASKS_PER_THREAD: usize = 8;
/// How many paths ahead the corners of a hit triangle are asked for, for the next eight; its indices twice as many.
const CORNERS_AHEAD: usize = LANES;

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
        params: &ShadeParams,
        (paths, hits): (&Paths, &Hits),
        film: &Film,
        live: [&mut Paths; 2],
    ) -> [usize; 2] {
        let level = Level::new();
        let queue = Queue { tables, params, paths, hits, film };
        let Self { left: [next, shadow], counts: [next_counts, shadow_counts] } = self;
        let (count, [next_live, shadow_live]) = (paths.ids.len(), live);
        let mut live = [0; 2];
        for first in (0..count).step_by(next_counts.len() * CHUNK) {
            let left = next.parts().chunks(CHUNK).zip(shadow.parts().chunks(CHUNK));
            let counts = next_counts.par_iter_mut().zip(shadow_counts.par_iter_mut());
            left.zip(counts).enumerate().with_max_len(1).for_each(|(task, ((next, shadow), counts))| {
                let [start, end] = [task, task + 1].map(|task| (first + task * CHUNK).min(count));
                let left = dispatch!(level, simd => shade_range(simd, &queue, start..end, [next, shadow]));
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

/// Shades the paths of a range, eight at a time; says how many next rays and shadow rays they leave.
#[inline(always)]
fn shade_range<S: Simd>(
    simd: S,
    queue: &Queue<'_>,
    range: Range<usize>,
    [mut next, mut shadow]: [PathsMut<'_>; 2],
) -> [usize; 2] {
    let Queue { tables, params, paths, hits, film } = *queue;
    let (mut next_count, mut shadow_count) = (0, 0);
    let (mut origin, mut leaving) = (Stored::default(), StoredRays::default());
    let random = Random::of_queue(params.seed, params.pass_index, params.bounce + 1);
    for first in range.clone().step_by(LANES) {
        let lanes = LANES.min(range.end - first);
        (first..first + lanes).for_each(|index| ask_ahead(tables, hits, index));
        // The last path stands in for those that are not there.
        let index: [usize; LANES] = from_fn(|lane| first + lane.min(lanes - 1));
        let arriving = Arriving {
            rays: from_fn(|lane| &paths.rays[index[lane]]),
            hits: from_fn(|lane| hits.hit(index[lane])),
            states: from_fn(|lane| &paths.states[index[lane]]),
        };
        let pixels: [u32; LANES] = from_fn(|lane| paths.ids[index[lane]]);
        let random = RandomX8::of_pixels(random, u32x8::load_array(simd, pixels));
        let outcome = shade_paths(tables, params, &arriving, random, simd);
        let there = |mask: mask32x8<S>| Lanes((mask.to_bitmask() & ((1 << lanes) - 1)) as u32);
        let Outcome { emitted, .. } = &outcome;
        let is_dark = emitted.x.simd_eq(0.0) & emitted.y.simd_eq(0.0) & emitted.z.simd_eq(0.0);
        for lane in there(!is_dark) {
            let light = [emitted.x[lane], emitted.y[lane], emitted.z[lane]];
            add(&film[pixels[lane] as usize], Vec3::from(light));
        }
        origin.set(outcome.origin);
        leaving.set(&outcome.shadow);
        for lane in there(outcome.shadow.is_there) {
            shadow.put(shadow_count, pixels[lane], leaving.ray(&origin, lane), outcome.lights[lane]);
            shadow_count += 1;
        }
        leaving.set(&outcome.next);
        for lane in there(outcome.next.is_there) {
            next.put(next_count, pixels[lane], leaving.ray(&origin, lane), 0);
            next_count += 1;
        }
    }
    [next_count, shadow_count]
}

/// The lanes of the bits that are set, in their order.
struct Lanes(u32);

impl Iterator for Lanes {
    type Item = usize;

    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        let lane = (self.0 != 0).then_some(self.0.trailing_zeros() as usize % LANES);
        self.0 &= self.0.wrapping_sub(1);
        lane
    }
}

/// Vectors of all lanes, to be read one by one.
#[derive(Default)]
struct Stored([[f32; LANES]; 3]);

impl Stored {
    /// Component by component: a copy of the whole would wait until each is in the cache.
    #[inline(always)]
    fn set<S: Simd>(&mut self, v: Vec3x8<S>) {
        let [x, y, z] = &mut self.0;
        v.x.store_array(x);
        v.y.store_array(y);
        v.z.store_array(z);
    }

    #[inline(always)]
    fn lane(&self, lane: usize) -> [f32; 3] {
        let [x, y, z] = &self.0;
        [x[lane], y[lane], z[lane]]
    }
}

/// Rays that leave surfaces, to be read one by one.
#[derive(Default)]
struct StoredRays {
    direction: Stored,
    t_max: [f32; LANES],
    color: Stored,
    density: [f32; LANES],
}

impl StoredRays {
    #[inline(always)]
    fn set<S: Simd>(&mut self, leaving: &Leaving<S>) {
        self.direction.set(leaving.direction);
        leaving.t_max.store_array(&mut self.t_max);
        self.color.set(leaving.color);
        leaving.density.store_array(&mut self.density);
    }

    #[inline(always)]
    fn ray(&self, origin: &Stored, lane: usize) -> (Ray, PathState) {
        let (origin, direction) = (origin.lane(lane), self.direction.lane(lane));
        let ray = Ray { origin, t_min: 0.0, direction, t_max: self.t_max[lane] };
        (ray, PathState { color: self.color.lane(lane), density: self.density[lane] })
    }
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

#[cfg(test)]
mod tests {
    use formats::ray::{Hit, Kind};

    use super::*;

    /// Paths with rays in any direction that hit anything or nothing, and what they hit.
    fn anywhere(triangles: usize) -> (Paths, Hits) {
        // Not a multiple of eight.
        const COUNT: usize = 4_003;
        let mut random = fastrand::Rng::with_seed(3);
        let mut paths = Paths::default();
        let mut hits = Vec::new();
        for id in 0..COUNT as u32 {
            let direction = Vec3::new(random.f32() - 0.5, random.f32() - 0.5, random.f32() - 0.5).normalize();
            let (origin, direction) = ([0.0; 3], direction.to_array());
            paths.rays.push(Ray { origin, t_min: 0.0, direction, t_max: f32::INFINITY });
            paths.ids.push(id);
            paths.states.push(PathState { color: [0.5, 0.75, 1.0], density: random.f32() });
            paths.lights.push(0);
            let (u, v) = (random.f32() * 0.5, random.f32() * 0.5);
            let hit = Hit { t: 1.0 + random.f32(), triangle: random.u32(0..triangles as u32), u, v };
            hits.push(if random.u8(0..8) == 0 { Hit::MISS } else { hit });
        }
        (paths, Hits::from_bytes(Kind::Closest, bytemuck::cast_slice(&hits)))
    }

    /// What paths leave and the film gets, all bits of it.
    fn shaded(level: Level, tables: &ShadeTables, paths: &Paths, hits: &Hits) -> Vec<u32> {
        let params = ShadeParams { seed: [1, 2], bounce: 2, roulette: 1, ..ShadeParams::default() };
        let film = dark_film(paths.ids.len());
        let queue = Queue { tables, params: &params, paths, hits, film: &film };
        let mut left = [Paths::default(), Paths::default()];
        left.iter_mut().for_each(|left| left.make_room(paths.ids.len()));
        let parts = left.each_mut().map(Paths::parts);
        let counts = dispatch!(level, simd => shade_range(simd, &queue, 0..paths.ids.len(), parts));
        let mut all: Vec<u32> = film.iter().flat_map(|pixel| light_of(pixel).map(f32::to_bits)).collect();
        for (mut left, count) in left.into_iter().zip(counts) {
            assert!(count > 100, "{count} rays");
            left.truncate(count);
            all.extend_from_slice(bytemuck::cast_slice(&left.rays));
            all.extend(left.states.iter().flat_map(|state| state.color.map(f32::to_bits)));
            all.extend(left.states.iter().map(|state| state.density.to_bits()));
            all.extend(left.ids.iter().chain(&left.lights));
        }
        all
    }

    #[cfg(target_arch = "x86_64")]
    #[test]
    fn all_instructions_give_the_same_bits() {
        let best = Level::new();
        let others = [
            best.as_sse2().map(Level::Sse2),
            best.as_sse4_2().map(Level::Sse4_2),
            best.as_avx2().map(Level::Avx2),
        ];
        for name in ["builtin:city?triangles=20000", "builtin:atrium?triangles=20000", "builtin:cornell"] {
            let scene = scenes::load(name).unwrap();
            let tables = ShadeTables::new(&scene);
            let (paths, hits) = anywhere(tables.triangles.len());
            let expected = shaded(best, &tables, &paths, &hits);
            for level in others.into_iter().flatten() {
                assert!(shaded(level, &tables, &paths, &hits) == expected, "{name}: {level:?}");
            }
        }
    }
}
