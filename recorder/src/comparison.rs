//! What a backend found, beside what a recording says of the same rays.

use anyhow::{Context, Result};
use formats::manifest::{Place, QueueArray, QueueId};
use formats::ray::{Hit, Kind};
use formats::reader::{Dump, Loaded};

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
    let is_shadow = id.kind == Kind::Shadow;
    let place = Place::Queue(id, if is_shadow { QueueArray::Distances } else { QueueArray::Hits });
    let mut difference = Difference::default();
    if !dump.has(&place) {
        return Ok(difference);
    }
    if is_shadow {
        let stored: Loaded<f32> = dump.array(&place)?;
        compare_each(backend, hits, &stored, |found: &f32, stored| {
            difference.rays += u64::from(found.is_finite() != stored.is_finite());
            difference.in_bits |= found.to_bits() != stored.to_bits();
        })?;
    } else {
        let stored: Loaded<Hit> = dump.array(&place)?;
        compare_each(backend, hits, &stored, |found: &Hit, stored| {
            difference.rays += u64::from(bytemuck::bytes_of(found) != bytemuck::bytes_of(stored));
        })?;
        difference.in_bits = difference.rays > 0;
    }
    Ok(difference)
}

fn compare_each<B: Backend, T: bytemuck::AnyBitPattern>(
    backend: &mut B,
    hits: &B::Hits,
    stored: &[T],
    mut compare: impl FnMut(&T, &T),
) -> Result<()> {
    let mut stored = stored.iter();
    backend.read(Array::Hits(hits), &mut |bytes| {
        for found in bytes.chunks_exact(size_of::<T>()) {
            let stored = stored.next().context("more hits than were recorded")?;
            compare(&bytemuck::pod_read_unaligned(found), stored);
        }
        Ok(())
    })
}
