//! The queues of a recording, found fit for kernels before anything runs on them.

use anyhow::{Context, Result, bail, ensure};
use formats::length_table::LengthCell;
use formats::manifest::{Place, QueueArray, QueueId, QueueRecord};
use formats::npy::Element;
use formats::queue_check::{QueueRays, QueueRules};
use formats::ray::{Hit, Kind, Ray};
use formats::reader::{Dump, Loaded};
use formats::stored_table;

use crate::backends::RecordedRays;

/// A queue of a recording that was found fit for kernels.
pub struct RecordedQueue {
    id: QueueId,
    rays: Loaded<Ray>,
    path_ids: Loaded<u32>,
    lights: Option<Loaded<u32>>,
    /// The length table that its methods read, unless tables are made anew.
    cells: Option<Loaded<LengthCell>>,
}

impl RecordedQueue {
    fn open(dump: &Dump, record: &QueueRecord, is_same_table: bool) -> Result<Self> {
        let (id, header) = (record.id, &dump.manifest().header);
        let is_shadow = id.kind == Kind::Shadow;
        let queue = Self {
            id,
            rays: array(dump, id, QueueArray::Rays)?,
            path_ids: array(dump, id, QueueArray::PathIds)?,
            lights: is_shadow.then(|| array(dump, id, QueueArray::Lights)).transpose()?,
            cells: is_same_table.then(|| array(dump, id, QueueArray::Lengths)).transpose()?,
        };
        let rules = QueueRules::new(id, header);
        let RecordedRays { rays, path_ids, lights, .. } = queue.rays();
        rules.check(QueueRays { rays, path_ids, lights }, record.rays)?;
        let results = QueueArray::results(id.kind);
        if dump.has(&Place::Queue(id, results)) {
            let found = match id.kind {
                Kind::Closest => array::<Hit>(dump, id, results)?.len(),
                Kind::Shadow => array::<f32>(dump, id, results)?.len(),
            };
            rules.check_count(results, found as u64, record.rays)?;
        }
        if let Some(cells) = &queue.cells {
            stored_table::from_cells(header, cells).with_context(|| format!("{id}/lengths.npy"))?;
            let most = u64::from(u32::MAX) - queue.rays.len() as u64;
            if let Some(full) = cells.iter().find(|cell| u64::from(cell.count) > most) {
                bail!(
                    "{id}/lengths.npy: cell {} counts {} rays, to which those of the queue cannot be added",
                    full.cell,
                    full.count
                );
            }
        }
        Ok(queue)
    }

    /// Its arrays, as the loop takes them.
    pub fn rays(&self) -> RecordedRays<'_> {
        RecordedRays {
            id: self.id,
            rays: &self.rays,
            path_ids: &self.path_ids,
            lights: self.lights.as_deref().unwrap_or_default(),
            lengths: self.cells.as_deref(),
        }
    }
}

/// The queues of a recording, each checked before anything runs on them or is written. `is_same_table`
/// says whether its length tables are addressed as those of this run. If not, they are made anew from the
/// queues in the order in which they were recorded.
///
/// # Errors
/// The first array that was not kept, and the first that kernels must not be given.
pub fn open(dump: &Dump, is_same_table: bool) -> Result<Vec<RecordedQueue>> {
    let queues = &dump.manifest().queues;
    ensure!(!queues.is_empty(), "{} has no queue of rays", dump.root().display());
    let opened: Result<_> =
        queues.iter().map(|record| RecordedQueue::open(dump, record, is_same_table)).collect();
    opened.with_context(|| format!("{} cannot be replayed", dump.root().display()))
}

/// What a recording that can be replayed has kept.
pub(super) const NEEDED: &str = "a replay needs the rays, length tables and scene of a recording";

fn array<T: Element>(dump: &Dump, id: QueueId, array: QueueArray) -> Result<Loaded<T>> {
    let place = Place::Queue(id, array);
    // A file that is there and damaged says so itself.
    if dump.has(&place) { Ok(dump.checked_array(&place)?) } else { dump.array(&place).context(NEEDED) }
}
