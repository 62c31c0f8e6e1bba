//! Checks a dump against everything that the format and the definitions say about it.
//!
//! - [`report`]: what was checked and what was found
//! - `files`: checksums, lengths, headers, files that no record names
//! - `scene`: the header's own numbers, the scene's arrays, the picture
//! - `records`: queues, timings and cache records of what was recorded
//! - `decisions`: what `auto` chose
//! - `kept`: that what the header says was kept is there
//! - `queues`: arrays that belong together, rays, path indices, lights, throughput
//! - `hits`: hits and distances against their rays and triangles
//! - `work`: what was counted of each ray, by its way through the hierarchy
//! - `orders`: keys recomputed from the stored rays, permutations
//! - `tables`: length tables, each the one before plus the traced lengths
//!
//! Memory: the arrays of one queue at a time, beside the scene.

mod decisions;
mod files;
mod hits;
mod kept;
mod orders;
mod queues;
mod records;
pub mod report;
mod scene;
mod tables;
mod work;

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};

pub use report::{Check, Findings, Report};

use crate::key::Encoder;
use crate::length_table::{LengthCell, LengthTable};
use crate::manifest::{MethodRecord, Place, QueueArray, QueueId, QueueRecord, SceneArray, Source};
use crate::npy::Element;
use crate::reader::{Dump, Loaded, ReadError};
use crate::stored_table::{self, StoredTableError};
use crate::traced::{Traced, TracedError};
use crate::unit_space::UnitSpace;

/// Checks everything in a dump that can be checked with what it holds.
pub fn verify(dump: &Dump) -> Report {
    let subject = Subject::new(dump);
    files::find_damage(&subject);
    let mut checks: Vec<Check> = scene::check(&subject).into();
    checks.insert(1, records::check(&subject));
    checks.insert(2, kept::check(&subject));
    checks.extend((!dump.manifest().decisions.is_empty()).then(|| decisions::check(&subject)));
    checks.extend(queues::check(&subject));
    checks.extend(hits::check(&subject));
    checks.extend(work::check(&subject));
    checks.extend(orders::check(&subject));
    checks.extend(scene::check_imported_hits(&subject));
    checks.push(tables::check(&subject));
    checks.insert(0, files::check(subject));
    Report { checks }
}

const NOT_KEPT: &str = "not kept";

/// The dump that is checked, and what most checks need of it.
struct Subject<'a> {
    dump: &'a Dump,
    unit: UnitSpace,
    /// Every queue with a record or an array.
    queues: BTreeMap<QueueId, Queue<'a>>,
    /// Records of methods by name.
    methods: BTreeMap<&'a str, &'a MethodRecord>,
    /// What is wrong with the files of arrays.
    faults: RefCell<BTreeMap<Place, String>>,
}

/// What a manifest says of a queue.
#[derive(Default)]
struct Queue<'a> {
    record: Option<&'a QueueRecord>,
    /// The methods that the record names.
    measured: BTreeSet<&'a str>,
    /// Where its arrays are.
    places: BTreeSet<Place>,
}

impl<'a> Subject<'a> {
    fn new(dump: &'a Dump) -> Self {
        let manifest = dump.manifest();
        let scene = &manifest.header.scene;
        let mut queues: BTreeMap<QueueId, Queue<'_>> = BTreeMap::new();
        for record in &manifest.queues {
            let measured = record.methods.iter().map(String::as_str).collect();
            queues.insert(record.id, Queue { record: Some(record), measured, places: BTreeSet::new() });
        }
        for array in &manifest.arrays {
            if let Some(queue) = array.place.queue() {
                queues.entry(queue).or_default().places.insert(array.place.clone());
            }
        }
        let methods = manifest.methods.iter().map(|method| (method.name.as_str(), method)).collect();
        let unit = UnitSpace::from_bounds(scene.bounds_min, scene.bounds_max);
        Self { dump, unit, queues, methods, faults: RefCell::default() }
    }

    /// Notes what is wrong with the file of an array; the first thing stands.
    fn note_fault(&self, place: &Place, fault: String) {
        self.faults.borrow_mut().entry(place.clone()).or_insert(fault);
    }

    /// An array, if the dump or its source has it; what is wrong with its file is noted.
    fn array<T: Element>(&self, place: &Place) -> Option<Loaded<T>> {
        let array = self.dump.array(place);
        array.map_err(|error| self.note_error(place, &error)).ok()
    }

    fn note_error(&self, place: &Place, error: &ReadError) {
        if !matches!(error, ReadError::NoSuchArray { .. }) {
            self.note_fault(place, error.to_string());
        }
    }

    fn queue_array<T: Element>(&self, queue: QueueId, array: QueueArray) -> Option<Loaded<T>> {
        self.array(&Place::Queue(queue, array))
    }

    /// Where an array is that [`Subject::array`] did not find, after "it was".
    fn absence(&self, place: &Place) -> &'static str {
        let is_replay = matches!(self.dump.manifest().header.source, Source::Replayed { .. });
        if self.faults.borrow().contains_key(place) {
            "damaged"
        } else if is_replay && self.dump.source().is_none() && self.dump.record(place).is_none() {
            "in the source, which is missing"
        } else {
            NOT_KEPT
        }
    }

    /// The same of an array of a queue.
    fn queue_absence(&self, queue: QueueId, array: QueueArray) -> &'static str {
        self.absence(&Place::Queue(queue, array))
    }

    /// The same of what traced lengths are made from.
    fn traced_absence(&self, queue: QueueId) -> &'static str {
        self.absence_of(
            [QueueArray::Rays, QueueArray::results(queue.kind)].map(|array| Place::Queue(queue, array)),
        )
    }

    /// The same of the scene's triangles and their corners.
    fn geometry_absence(&self) -> &'static str {
        self.absence_of([SceneArray::Positions, SceneArray::Triangles].map(Place::Scene))
    }

    /// The same of arrays that are needed together.
    fn absence_of(&self, places: [Place; 2]) -> &'static str {
        let mut absences = places.iter().map(|place| self.absence(place));
        absences.find(|absence| *absence != NOT_KEPT).unwrap_or(NOT_KEPT)
    }

    /// Whether the adapter's arithmetic is such that every number must be met exactly.
    fn is_exact(&self) -> bool {
        self.dump.manifest().header.ieee_arithmetic
    }

    /// What gives a ray's cell in the length table.
    fn cell_encoder(&self) -> Option<Encoder> {
        self.dump.manifest().header.cell_encoder()
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
        self.traced_in(self.dump, queue)
    }

    fn traced_in(&self, dump: &Dump, queue: QueueId) -> Option<Traced> {
        match Traced::open(dump, queue) {
            Ok(traced) => Some(traced),
            Err(TracedError::Read(error)) => {
                self.note_error(&Place::Queue(queue, QueueArray::Rays), &error);
                None
            }
            // `queues` finds arrays that do not belong together.
            Err(TracedError::Lengths { .. }) => None,
        }
    }
}
