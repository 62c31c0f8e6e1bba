//! The loop over recorded queues: what `wavefront` is for paths.

use anyhow::{Context, Result, ensure};
use formats::length_table::LengthCell;
use formats::manifest::{Place as ArrayPlace, QueueArray, QueueId};
use formats::npy::Element;
use formats::ray::{Hit, Kind, Ray};
use formats::reader::{Dump, Mapped};

use crate::backend::{Backend, UploadedRays};
use crate::wavefront::{Observer, Place};

/// Rays that someone else has traced.
pub enum RecordedRays<'a> {
    /// The queues of a recording.
    Dump {
        /// The recording.
        dump: &'a Dump,
        /// Whether its length tables are addressed as those of this run. If not, they are made anew from
        /// the queues in the order in which they were recorded.
        is_same_table: bool,
    },
    /// One queue.
    Queue(UploadedRays<'a>),
}

/// Whether a recording has what [`run`] reads of it, before anything is written.
///
/// # Errors
/// The first array that was not kept.
pub fn check(dump: &Dump, is_same_table: bool) -> Result<()> {
    for queue in &dump.manifest().queues {
        let mut needed = vec![QueueArray::Rays, QueueArray::PathIds];
        needed.extend((queue.id.kind == Kind::Shadow).then_some(QueueArray::Lights));
        needed.extend(is_same_table.then_some(QueueArray::Lengths));
        for array in needed {
            let place = ArrayPlace::Queue(queue.id, array);
            ensure!(dump.has(&place), "{} has no {place}: {NEEDED}", dump.root().display());
        }
    }
    ensure!(!dump.manifest().queues.is_empty(), "{} has no queue of rays", dump.root().display());
    Ok(())
}

const NEEDED: &str = "a replay needs the rays and length tables of a recording; record with --keep rays,hits,lengths,scene and more";

/// Traces each queue in canonical order and hands it to the observer; returns how many rays did not find
/// what was recorded.
///
/// # Errors
/// Missing or damaged arrays, and whatever the backend or the observer reports.
pub fn run<B: Backend>(
    backend: &mut B,
    rays: &RecordedRays<'_>,
    observer: &mut impl Observer<B>,
) -> Result<u64> {
    match rays {
        RecordedRays::Dump { dump, is_same_table } => {
            let mut differing = 0;
            for queue in &dump.manifest().queues {
                differing += run_recorded(backend, dump, queue.id, *is_same_table, observer)?;
            }
            Ok(differing)
        }
        RecordedRays::Queue(queue) => {
            let place = Place { pass: 0, bounce: queue.bounce, kind: queue.kind };
            let rays = backend.upload(*queue)?;
            let hits = backend.trace(&rays)?;
            observer.traced(backend, place, &rays, &hits.value, hits.elapsed_ns)?;
            backend.accumulate(&rays, &hits.value)?;
            Ok(0)
        }
    }
}

fn run_recorded<B: Backend>(
    backend: &mut B,
    dump: &Dump,
    id: QueueId,
    is_same_table: bool,
    observer: &mut impl Observer<B>,
) -> Result<u64> {
    let place = Place { pass: id.pass, bounce: id.bounce, kind: id.kind };
    let rays: Mapped<Ray> = array(dump, id, QueueArray::Rays)?;
    let path_ids: Mapped<u32> = array(dump, id, QueueArray::PathIds)?;
    let lights: Option<Mapped<u32>> =
        (id.kind == Kind::Shadow).then(|| array(dump, id, QueueArray::Lights)).transpose()?;
    if is_same_table {
        let cells: Mapped<LengthCell> = array(dump, id, QueueArray::Lengths)?;
        backend.load_table(id.kind, &cells)?;
    }
    let queue = UploadedRays {
        kind: id.kind,
        bounce: id.bounce,
        rays: &rays,
        path_ids: &path_ids,
        lights: lights.as_deref().unwrap_or_default(),
    };
    let queue = backend.upload(queue)?;
    let hits = backend.trace(&queue)?;
    let differing = differing(backend, dump, id, &hits.value)?;
    observer.traced(backend, place, &queue, &hits.value, hits.elapsed_ns)?;
    if !is_same_table {
        backend.accumulate(&queue, &hits.value)?;
    }
    Ok(differing)
}

fn array<T: Element>(dump: &Dump, id: QueueId, array: QueueArray) -> Result<Mapped<T>> {
    dump.array(&ArrayPlace::Queue(id, array)).context(NEEDED)
}

/// How many rays found something else than was recorded: another hit, for shadow rays another answer. 0 if
/// the hits were not kept.
fn differing<B: Backend>(backend: &mut B, dump: &Dump, id: QueueId, hits: &B::Hits) -> Result<u64> {
    let kept = match id.kind {
        Kind::Closest => QueueArray::Hits,
        Kind::Shadow => QueueArray::Distances,
    };
    let place = ArrayPlace::Queue(id, kept);
    if !dump.has(&place) {
        return Ok(0);
    }
    let mut differing = 0;
    match id.kind {
        Kind::Closest => {
            let stored: Mapped<Hit> = dump.array(&place)?;
            compare(backend, hits, &stored, |found: &Hit, stored| {
                differing += u64::from(bytemuck::bytes_of(found) != bytemuck::bytes_of(stored));
            })?;
        }
        Kind::Shadow => {
            let stored: Mapped<f32> = dump.array(&place)?;
            compare(backend, hits, &stored, |found: &f32, stored| {
                differing += u64::from(found.is_finite() != stored.is_finite());
            })?;
        }
    }
    Ok(differing)
}

fn compare<B: Backend, T: bytemuck::AnyBitPattern>(
    backend: &mut B,
    hits: &B::Hits,
    stored: &[T],
    mut compare: impl FnMut(&T, &T),
) -> Result<()> {
    let mut stored = stored.iter();
    backend.read_hits(hits, &mut |bytes| {
        for found in bytes.chunks_exact(size_of::<T>()) {
            let stored = stored.next().context("more hits than were recorded")?;
            compare(&bytemuck::pod_read_unaligned(found), stored);
        }
        Ok(())
    })
}
