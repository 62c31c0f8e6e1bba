//! Compact on threads: what the tasks of shading leave moves together, in canonical order.

use formats::pages::make_room;
use formats::ray::Ray;
use rayon::prelude::*;

use crate::stages::shared::PathState;

/// Rays with what they carry, in ascending path index; as many of each.
#[derive(Clone, Debug, Default)]
pub struct Paths {
    /// The rays.
    pub rays: Vec<Ray>,
    /// Path index of each.
    pub ids: Vec<u32>,
    /// State of each.
    pub states: Vec<PathState>,
    /// Index of the scene's light to which each shadow ray goes, by themselves, since keys are made from them.
    pub lights: Vec<u32>,
}

impl Paths {
    /// Makes and touches room for so many, of any value.
    pub fn make_room(&mut self, count: usize) {
        make_room(&mut self.rays, count);
        make_room(&mut self.ids, count);
        make_room(&mut self.states, count);
        make_room(&mut self.lights, count);
    }

    /// Leaves the first so many.
    pub fn truncate(&mut self, count: usize) {
        self.rays.truncate(count);
        self.ids.truncate(count);
        self.states.truncate(count);
        self.lights.truncate(count);
    }

    /// All of them, to be written.
    pub fn parts(&mut self) -> PathsMut<'_> {
        let Self { rays, ids, states, lights } = self;
        PathsMut { rays, ids, states, lights }
    }
}

/// A stretch of [`Paths`].
#[derive(Debug)]
pub struct PathsMut<'a> {
    rays: &'a mut [Ray],
    ids: &'a mut [u32],
    states: &'a mut [PathState],
    lights: &'a mut [u32],
}

impl<'a> PathsMut<'a> {
    fn split_at(self, at: usize) -> (Self, Self) {
        let (rays, rays_after) = self.rays.split_at_mut(at);
        let (ids, ids_after) = self.ids.split_at_mut(at);
        let (states, states_after) = self.states.split_at_mut(at);
        let (lights, lights_after) = self.lights.split_at_mut(at);
        let after = Self { rays: rays_after, ids: ids_after, states: states_after, lights: lights_after };
        (Self { rays, ids, states, lights }, after)
    }

    /// What comes after the first so many.
    pub fn after(self, count: usize) -> Self {
        self.split_at(count).1
    }

    /// Stretches of `chunk` each, the last one shorter.
    pub fn chunks(self, chunk: usize) -> impl IndexedParallelIterator<Item = Self> {
        let numbers = self.ids.par_chunks_mut(chunk).zip(self.lights.par_chunks_mut(chunk));
        let carried = self.rays.par_chunks_mut(chunk).zip(self.states.par_chunks_mut(chunk));
        carried.zip(numbers).map(|((rays, states), (ids, lights))| Self { rays, ids, states, lights })
    }

    /// Writes one; a closest ray has light 0.
    pub fn put(&mut self, at: usize, id: u32, (ray, state): (Ray, PathState), light: u32) {
        self.rays[at] = ray;
        self.ids[at] = id;
        self.states[at] = state;
        self.lights[at] = light;
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
            live.states.copy_from_slice(&paths.states[range.clone()]);
            live.lights.copy_from_slice(&paths.lights[range]);
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
