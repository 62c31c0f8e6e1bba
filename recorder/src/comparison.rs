//! What a backend found, beside what a recording says of the same rays.

use anyhow::{Context, Result};
use formats::manifest::{Place, QueueArray, QueueId};
use formats::ray::{Hit, Kind};
use formats::reader::Dump;

use crate::backends::{Array, Backend};

/// How results differ from recorded ones.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Difference {
    /// Rays with another answer: another hit, for shadow rays another occlusion.
    pub(crate) rays: u64,
    /// Whether any result has other bits: shadow rays may find another occluder of the same light, and
    /// what is made of their lengths differs with it.
    pub(crate) in_bits: bool,
}

/// Compares results with those of a recording; no difference if they were not kept.
///
/// # Errors
/// A damaged array, or any of the backend.
pub(crate) fn compare<B: Backend>(
    backend: &mut B,
    dump: &Dump,
    id: QueueId,
    hits: &B::Hits,
) -> Result<Difference> {
    let place = Place::Queue(id, QueueArray::results(id.kind));
    if !dump.has(&place) {
        return Ok(Difference::default());
    }
    match id.kind {
        Kind::Closest => compare_each::<B, Hit>(backend, hits, &dump.array(&place)?, |_, _| true),
        Kind::Shadow => compare_each::<B, f32>(backend, hits, &dump.array(&place)?, |found, stored| {
            found.is_finite() != stored.is_finite()
        }),
    }
}

/// Compares bits, and counts those rays of which other bits are another answer.
fn compare_each<B: Backend, T: bytemuck::Pod>(
    backend: &mut B,
    hits: &B::Hits,
    stored: &[T],
    is_other_answer: impl Fn(&T, &T) -> bool,
) -> Result<Difference> {
    let mut stored = stored.iter();
    let mut difference = Difference::default();
    backend.read(Array::Hits(hits), &mut |bytes| {
        for found in bytes.chunks_exact(size_of::<T>()) {
            let stored = stored.next().context("more hits than were recorded")?;
            if found != bytemuck::bytes_of(stored) {
                difference.in_bits = true;
                difference.rays += u64::from(is_other_answer(&bytemuck::pod_read_unaligned(found), stored));
            }
        }
        Ok(())
    })?;
    Ok(difference)
}
