//! The verbs of the loop: what the wavefront needs from a backend, and no more.

pub mod cpu;
pub mod gpu;
mod pool;

use anyhow::{Result, bail, ensure};
use bytemuck::Pod;
use formats::length_table::LengthCell;
use formats::manifest::QueueId;
use formats::ray::{Kind, Ray};

use crate::clock::Sample;
use crate::stages::setup::Setup;
use crate::stages::trace::Order;

/// A queue: the live rays of one pass, bounce and kind, in canonical order unless a verb says otherwise.
pub trait Queue {
    /// Which one it is.
    fn id(&self) -> QueueId;
    /// Number of rays.
    fn len(&self) -> usize;

    /// Whether no ray is left.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// The queues that a bounce leaves behind.
#[derive(Debug)]
pub struct Shaded<R> {
    /// The paths' next rays.
    pub next: R,
    /// Rays to light samples.
    pub shadow: R,
}

/// Rays that were recorded, in canonical order.
#[derive(Clone, Copy, Debug)]
pub struct RecordedRays<'a> {
    /// The queue that they were.
    pub id: QueueId,
    /// The rays; at most one per pixel of the picture.
    pub rays: &'a [Ray],
    /// Path index of each.
    pub path_ids: &'a [u32],
    /// Light index of each shadow ray; empty for closest rays.
    pub lights: &'a [u32],
    /// The touched cells of the length table that their methods read; the table as it is if not given.
    pub lengths: Option<&'a [LengthCell]>,
}

impl RecordedRays<'_> {
    /// Refuses what kernels must not be given: indices beyond the picture or the lights, arrays of other lengths.
    ///
    /// # Errors
    /// The first thing that is wrong.
    fn check(&self, setup: &Setup) -> Result<()> {
        let Self { id, rays, path_ids, lights, .. } = self;
        let (count, pixels) = (rays.len(), setup.width as usize * setup.height as usize);
        let light_count = if id.kind == Kind::Shadow { count } else { 0 };
        ensure!(
            path_ids.len() == count && lights.len() == light_count,
            "{id} has {count} rays, {} path indices and {} lights; expected {count} and {light_count}",
            path_ids.len(),
            lights.len()
        );
        ensure!(count <= pixels, "{id} has {count} rays, but the picture has {pixels} pixels");
        if let Some(at) = path_ids.iter().position(|&path| path as usize >= pixels) {
            bail!("ray {at} of {id} is of path {}, but the picture has {pixels} pixels", path_ids[at]);
        }
        let sites = setup.light_sites.len();
        if let Some(at) = lights.iter().position(|&light| light as usize >= sites) {
            bail!("ray {at} of {id} goes to light {}, but there are {sites}", lights[at]);
        }
        Ok(())
    }
}

/// Which of the two length tables of a kind lengths are added to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Table {
    /// The one that methods read.
    Learnt,
    /// One that nothing reads, to time the adding alone.
    Scratch,
}

/// Takes an array's bytes, piece by piece.
pub type Sink<'a> = dyn FnMut(&[u8]) -> Result<()> + 'a;

/// What can be read back of a queue and of what was made of it.
pub enum Array<'a, B: Backend + ?Sized> {
    /// The rays, [`Ray`] each.
    Rays(&'a B::Rays),
    /// Those of its sample, [`formats::auto::sample`].
    Sample(&'a B::Rays),
    /// Path index of each ray, u32.
    PathIds(&'a B::Rays),
    /// Light index of each shadow ray, u32.
    Lights(&'a B::Rays),
    /// Throughput of the path of each closest ray, linear RGB, f32 each; zero where rays were recorded.
    Throughput(&'a B::Rays),
    /// Work of tracing each ray, [`formats::ray::Work`] each, from an untimed run.
    Work(&'a B::Rays),
    /// Lanes of a group, work of all rays as they lie and what its steps had room for, u64 each, from an untimed
    /// run; nothing by kernels that trace rays one by one.
    LaneUse(&'a B::Rays),
    /// [`formats::ray::Hit`] of each closest ray, f32 distance of each shadow ray.
    Hits(&'a B::Hits),
    /// Keys in canonical order, u32 up to 32 bits, else u64.
    Keys(&'a B::Keys),
    /// The permutation, u32.
    Permutation(&'a B::Permutation),
    /// Touched cells of the length table of a kind, [`LengthCell`] each.
    Lengths(Kind),
    /// Light that each pixel got so far, linear RGB, f32 each; top row first.
    Film,
}

/// The elements of an array of a backend.
///
/// # Errors
/// Any of the backend.
pub fn collected<T: Pod, B: Backend>(backend: &mut B, array: Array<'_, B>) -> Result<Vec<T>> {
    let mut elements = Vec::new();
    collect(backend, array, &mut elements)?;
    Ok(elements)
}

/// The same in place of what `elements` had before, in its memory: new memory costs more than the copy.
///
/// # Errors
/// Any of the backend.
pub fn collect<T: Pod, B: Backend>(
    backend: &mut B,
    array: Array<'_, B>,
    elements: &mut Vec<T>,
) -> Result<()> {
    elements.clear();
    backend.read(array, &mut |bytes| {
        elements.extend(bytes.chunks_exact(size_of::<T>()).map(bytemuck::pod_read_unaligned::<T>));
        Ok(())
    })
}

/// The picture after so many passes, linear RGB, top row first.
///
/// # Errors
/// Any of the backend.
pub fn picture<B: Backend>(backend: &mut B, passes: u32) -> Result<Vec<[f32; 3]>> {
    let scale = 1.0 / passes as f32;
    let film: Vec<[f32; 3]> = collected(backend, Array::Film)?;
    Ok(film.into_iter().map(|pixel| pixel.map(|light| light * scale)).collect())
}

/// Why the keys of a queue cannot be made.
fn untraced(id: QueueId, method: &str) -> String {
    format!("{id} was to be keyed by '{method}' before it was traced, but that needs the length of each ray")
}

/// Why a queue has no paths.
fn gathered(id: QueueId) -> String {
    format!("the rays of {id} were gathered, and only those of a whole queue carry paths")
}

/// A device that runs the stages. Queues and everything made of them are opaque, and live in memory that is
/// used again once they are dropped: what a verb writes while it is timed was touched before.
pub trait Backend {
    /// A queue, or its rays in another order.
    type Rays: Queue;
    /// What tracing rays found, a result for each.
    type Hits;
    /// Keys in canonical order.
    type Keys;
    /// A permutation of a queue.
    type Permutation;

    /// The time of the last verb, on the device's clock where it has one. Copies between the device and main
    /// memory are not timed.
    fn sample(&self) -> Sample;

    /// The same in nanoseconds alone.
    fn elapsed_ns(&self) -> u64 {
        self.sample().elapsed_ns
    }

    /// Begins a picture: a dark film, length tables that nothing was added to.
    fn restart(&mut self) -> Result<()>;
    /// Camera rays of a pass.
    fn generate(&mut self, pass: u32) -> Result<Self::Rays>;
    /// A queue of recorded rays. What paths carry beside their rays is not recorded: shading it is dark.
    fn upload(&mut self, queue: RecordedRays<'_>) -> Result<Self::Rays>;
    /// An order that no key has: the canonical index of the ray at each place, each once.
    fn upload_permutation(&mut self, indices: &[u32]) -> Result<Self::Permutation>;
    /// Keys that were made elsewhere, of so many bits, 1 to 64.
    fn upload_keys(&mut self, keys: &[u64], bits: u32) -> Result<Self::Keys>;
    /// Traces rays; results lie as the rays do.
    fn trace(&mut self, rays: &Self::Rays, order: Order<&Self::Permutation>) -> Result<Self::Hits>;
    /// Makes a device that learns what it does again and again, as processors do, forget a queue: before a turn in
    /// which its trace is timed. Nothing that the queue or its tables have changes.
    fn forget(&mut self, rays: &Self::Rays) -> Result<()>;
    /// Adds traced lengths to a table of the queue's kind.
    fn accumulate(&mut self, rays: &Self::Rays, hits: &Self::Hits, table: Table) -> Result<()>;
    /// Shades the hits of closest rays: light to the film, next rays, shadow rays.
    fn shade(&mut self, rays: &Self::Rays, hits: &Self::Hits) -> Result<Shaded<Self::Rays>>;
    /// Adds the light of shadow rays that arrived to the film.
    fn add_light(&mut self, rays: &Self::Rays, hits: &Self::Hits) -> Result<()>;

    /// Keys of a queue by method number, the query of the length table included. Only methods of real lengths
    /// need hits.
    fn key(&mut self, rays: &Self::Rays, hits: Option<&Self::Hits>, method: usize) -> Result<Self::Keys>;
    /// Sorts keys, stably.
    fn sort(&mut self, keys: &Self::Keys) -> Result<Self::Permutation>;
    /// Brings what gathered rays found home to canonical places.
    fn scatter(&mut self, hits: &Self::Hits, permutation: &Self::Permutation) -> Result<Self::Hits>;
    /// Copies rays into an order.
    fn gather(&mut self, rays: &Self::Rays, permutation: &Self::Permutation) -> Result<Self::Rays>;
    /// Copies rays into an order with all that their paths carry: a queue that shading goes on with, and leaves
    /// others in the order of.
    fn reorder(&mut self, rays: &Self::Rays, permutation: &Self::Permutation) -> Result<Self::Rays>;
    /// Counts results that differ: all of a hit's fields, for shadow rays the occlusion.
    fn differences(&mut self, hits: &Self::Hits, others: &Self::Hits) -> Result<u64>;

    /// Hands the bytes of an array to a sink, piece by piece.
    fn read(&mut self, array: Array<'_, Self>, sink: &mut Sink<'_>) -> Result<()>;
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::cpu::CpuBackend;
    use super::*;

    #[test]
    fn what_kernels_must_not_be_given_is_not_uploaded() {
        let setup = Setup { width: 2, height: 2, ..Setup::made_up(false, 32) };
        let mut backend = CpuBackend::in_cornell(Arc::new(setup));
        let rays = [Ray { origin: [0.0; 3], t_min: 0.0, direction: [0.0, 0.0, 1.0], t_max: 1.0 }; 5];
        let mut upload = |rays: &[Ray], path_ids: &[u32], lights: &[u32]| {
            let id = QueueId { pass: 0, bounce: 1, kind: Kind::Shadow };
            backend.upload(RecordedRays { id, rays, path_ids, lights, lengths: None }).map(drop)
        };
        upload(&rays[..2], &[0, 3], &[0, 2]).unwrap();
        for (found, expected) in [
            (upload(&rays[..2], &[0, 4], &[0, 2]), "ray 1 of pass-000/bounce-01/shadow is of path 4"),
            (upload(&rays[..2], &[0, 3], &[3, 2]), "goes to light 3, but there are 3"),
            (upload(&rays[..2], &[0], &[0, 2]), "2 rays, 1 path indices and 2 lights; expected 2 and 2"),
            (upload(&rays[..2], &[0, 3], &[]), "2 rays, 2 path indices and 0 lights"),
            (upload(&rays, &[0; 5], &[0; 5]), "5 rays, but the picture has 4 pixels"),
        ] {
            let message = found.unwrap_err().to_string();
            assert!(message.contains(expected), "{message}");
        }
    }
}
