//! The path of a pixel through all bounces of a pass.

use formats::key::method::UNSORTED;
use formats::manifest::{MethodArray, Place, QueueArray, QueueId};
use formats::metrics::capsule::Segment;
use formats::reader::{Dump, Loaded};
use formats::traced::Traced;
use rayon::prelude::*;

/// A ray of a path.
#[derive(Clone, Debug, PartialEq)]
pub struct PathRay {
    /// Its queue.
    pub queue: QueueId,
    /// Its canonical index there.
    pub ray: usize,
    /// From its origin to where it ended, unit space.
    pub segment: Segment,
    /// Traced length, unit lengths.
    pub length: f32,
    /// Whether it ended at a surface.
    pub is_at_surface: bool,
    /// Its place in orders A and B; `None` where the queue has no such order.
    pub places: [Option<usize>; 2],
}

impl PathRay {
    /// The ray of a path in a queue; `None` if it has none, or its arrays were not kept.
    pub(super) fn of(dump: &Dump, queue: QueueId, path: u32, methods: &[Option<String>; 2]) -> Option<Self> {
        let paths: Loaded<u32> = dump.array(&Place::Queue(queue, QueueArray::PathIds)).ok()?;
        let ray = paths.binary_search(&path).ok()?;
        let traced = Traced::open(dump, queue).ok()?;
        let found = traced.rays().get(ray)?;
        let place = |method: &Option<String>| match method.as_deref()? {
            UNSORTED => Some(ray),
            method => {
                let place = Place::Method(queue, method.to_owned(), MethodArray::Permutation);
                let order: Loaded<u32> = dump.array(&place).ok()?;
                order.par_iter().position_any(|&index| index as usize == ray)
            }
        };
        let length = traced.length(ray);
        Some(Self {
            queue,
            ray,
            segment: Segment::of(traced.unit(), found, length),
            length,
            is_at_surface: traced.is_at_surface(ray),
            places: methods.each_ref().map(place),
        })
    }
}
