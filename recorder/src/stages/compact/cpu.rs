//! Compact on threads: what the tasks of shading leave moves together, in canonical order.

use bytemuck::Zeroable;
use formats::pages::make_room;
use formats::ray::Ray;
use rayon::prelude::*;

/// What a ray carries beside itself.
#[derive(Clone, Copy, Debug, Default, Zeroable)]
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
    /// Makes and touches room for so many, of any value.
    pub fn make_room(&mut self, count: usize) {
        make_room(&mut self.rays, count);
        make_room(&mut self.ids, count);
        make_room(&mut self.states, count);
    }

    /// Leaves the first so many.
    pub fn truncate(&mut self, count: usize) {
        self.rays.truncate(count);
        self.ids.truncate(count);
        self.states.truncate(count);
    }

    /// All of them, to be written.
    pub fn parts(&mut self) -> PathsMut<'_> {
        PathsMut { rays: &mut self.rays, ids: &mut self.ids, states: &mut self.states }
    }
}

/// A stretch of [`Paths`].
#[derive(Debug)]
pub struct PathsMut<'a> {
    rays: &'a mut [Ray],
    ids: &'a mut [u32],
    states: &'a mut [RayState],
}

impl<'a> PathsMut<'a> {
    fn split_at(self, at: usize) -> (Self, Self) {
        let (rays, rays_after) = self.rays.split_at_mut(at);
        let (ids, ids_after) = self.ids.split_at_mut(at);
        let (states, states_after) = self.states.split_at_mut(at);
        (Self { rays, ids, states }, Self { rays: rays_after, ids: ids_after, states: states_after })
    }

    /// What comes after the first so many.
    pub fn after(self, count: usize) -> Self {
        self.split_at(count).1
    }

    /// Stretches of `chunk` each, the last one shorter.
    pub fn chunks(self, chunk: usize) -> impl IndexedParallelIterator<Item = Self> {
        let rest = self.ids.par_chunks_mut(chunk).zip(self.states.par_chunks_mut(chunk));
        let all = self.rays.par_chunks_mut(chunk).zip(rest);
        all.map(|(rays, (ids, states))| Self { rays, ids, states })
    }

    /// Writes one.
    pub fn put(&mut self, at: usize, id: u32, (ray, state): (Ray, RayState)) {
        self.rays[at] = ray;
        self.ids[at] = id;
        self.states[at] = state;
    }
}

/// Moves the first `counts[i]` of the i-th `chunk` of paths together; returns how many there are.
///
/// # Panics
/// If `live` has no room for them.
pub fn compact(paths: &Paths, chunk: usize, counts: &[u32], live: PathsMut<'_>) -> usize {
    move_chunks(paths, chunk, 0, counts, live);
    total(counts)
}

fn total(counts: &[u32]) -> usize {
    counts.iter().map(|&count| count as usize).sum()
}

/// Halves the chunks until each task has one, so that no list of them is made.
fn move_chunks(paths: &Paths, chunk: usize, first: usize, counts: &[u32], live: PathsMut<'_>) {
    match counts {
        [] => {}
        &[count] => {
            let range = first * chunk..first * chunk + count as usize;
            let (live, _) = live.split_at(count as usize);
            live.rays.copy_from_slice(&paths.rays[range.clone()]);
            live.ids.copy_from_slice(&paths.ids[range.clone()]);
            live.states.copy_from_slice(&paths.states[range]);
        }
        _ => {
            let (before, after) = counts.split_at(counts.len() / 2);
            let (live_before, live_after) = live.split_at(total(before));
            rayon::join(
                || move_chunks(paths, chunk, first, before, live_before),
                || move_chunks(paths, chunk, first + before.len(), after, live_after),
            );
        }
    }
}
