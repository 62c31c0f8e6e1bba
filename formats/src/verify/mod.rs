//! Checks a dump against everything that the format and the definitions say about it.
//!
//! - [`report`]: what was checked and what was found
//! - `files`: checksums, lengths, headers, files that no record names
//! - `scene`: the header's own numbers, the scene's arrays, the picture
//! - `queues`: arrays that belong together, rays, path indices, lights
//! - `hits`: hits and distances against their rays and triangles
//! - `orders`: keys recomputed from the stored rays, permutations
//! - `tables`: length tables, each the one before plus the traced lengths
//!
//! Memory is bounded whatever the size of the dump: arrays are mapped one queue at a time.

mod files;
mod hits;
mod orders;
mod queues;
pub mod report;
mod scene;
mod tables;

use std::collections::{BTreeMap, BTreeSet};

pub use report::{Check, Findings, Report};

use crate::key::Encoder;
use crate::length_table::{LengthCell, LengthTable};
use crate::manifest::{Place, QueueArray, QueueId};
use crate::npy::Element;
use crate::reader::{Dump, Mapped};
use crate::stored_table::{self, StoredTableError};
use crate::traced::Traced;
use crate::unit_space::UnitSpace;

/// Checks everything in a dump that can be checked with what it holds.
pub fn verify(dump: &Dump) -> Report {
    let subject = Subject::new(dump);
    let files = files::check(&subject);
    let mut checks = vec![files];
    checks.extend(scene::check(&subject));
    checks.extend(queues::check(&subject));
    checks.extend(hits::check(&subject));
    checks.extend(orders::check(&subject));
    checks.push(tables::check(&subject));
    Report { checks }
}

/// The dump that is checked, and what most checks need of it.
struct Subject<'a> {
    dump: &'a Dump,
    unit: UnitSpace,
    /// Every queue with a record or an array, with the arrays' places.
    queues: BTreeMap<QueueId, BTreeSet<Place>>,
}

impl<'a> Subject<'a> {
    fn new(dump: &'a Dump) -> Self {
        let manifest = dump.manifest();
        let scene = &manifest.header.scene;
        let mut queues: BTreeMap<QueueId, BTreeSet<Place>> = BTreeMap::new();
        for queue in &manifest.queues {
            queues.entry(queue.id).or_default();
        }
        for array in &manifest.arrays {
            if let Some(queue) = array.place.queue() {
                queues.entry(queue).or_default().insert(array.place.clone());
            }
        }
        Self { dump, unit: UnitSpace::from_bounds(scene.bounds_min, scene.bounds_max), queues }
    }

    /// An array, if the dump has it and its file is what the manifest says; if it is not, `files`
    /// has found that already.
    fn array<T: Element>(&self, place: &Place) -> Option<Mapped<T>> {
        self.dump.array(place).ok()
    }

    fn queue_array<T: Element>(&self, queue: QueueId, array: QueueArray) -> Option<Mapped<T>> {
        self.array(&Place::Queue(queue, array))
    }

    /// Whether the adapter's arithmetic is such that every number must be met exactly.
    fn is_exact(&self) -> bool {
        self.dump.manifest().header.ieee_arithmetic
    }

    /// What gives a ray's cell in the length table.
    fn cell_encoder(&self) -> Option<Encoder> {
        stored_table::cell_encoder(&self.dump.manifest().header)
    }

    /// The length table of these cells, if they are one.
    fn table(&self, cells: &[LengthCell]) -> Result<LengthTable, StoredTableError> {
        stored_table::from_cells(&self.dump.manifest().header, cells)
    }

    /// The recording whose queues were added to the length tables: this one, or the source of a replay that
    /// has no tables of its own.
    fn table_maker(&self) -> &Dump {
        let is_table = |place: &Place| matches!(place, Place::Queue(_, QueueArray::Lengths));
        let has_own = self.dump.manifest().arrays.iter().any(|array| is_table(&array.place));
        self.dump.source().filter(|_| !has_own).unwrap_or(self.dump)
    }

    /// What the traced lengths of a queue are made from, if it was kept.
    fn traced(&self, queue: QueueId) -> Option<Traced> {
        Traced::open(self.dump, queue).ok()
    }
}
