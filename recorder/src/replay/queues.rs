//! The loop over recorded queues: what `wavefront` is for paths.

use anyhow::{Context, Result, ensure};
use formats::length_table::LengthCell;
use formats::manifest::{Place as ArrayPlace, QueueArray, QueueId, QueueRecord};
use formats::npy::Element;
use formats::queue_check::{QueueRays, QueueRules};
use formats::ray::{Hit, Kind, Ray};
use formats::reader::{Dump, Mapped};
use formats::stored_table;

use crate::backend::{Backend, UploadedRays};
use crate::wavefront::{Observer, Place};

/// Rays that someone else has traced.
pub enum RecordedRays<'a> {
    /// The queues of a recording.
    Dump {
        /// The recording.
        dump: &'a Dump,
        /// Its queues, checked.
        queues: Vec<RecordedQueue>,
    },
    /// One queue.
    Queue(UploadedRays<'a>),
}

/// A queue of a recording that was found fit for kernels.
pub struct RecordedQueue {
    id: QueueId,
    rays: Mapped<Ray>,
    path_ids: Mapped<u32>,
    lights: Option<Mapped<u32>>,
    /// The length table that its methods read, unless tables are made anew.
    cells: Option<Mapped<LengthCell>>,
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
        let UploadedRays { rays, path_ids, lights, .. } = queue.uploaded();
        rules.check(QueueRays { rays, path_ids, lights }, record.rays)?;
        let results = if is_shadow { QueueArray::Distances } else { QueueArray::Hits };
        if dump.has(&ArrayPlace::Queue(id, results)) {
            let found = match id.kind {
                Kind::Closest => array::<Hit>(dump, id, results)?.len(),
                Kind::Shadow => array::<f32>(dump, id, results)?.len(),
            };
            rules.check_count(results, found as u64, record.rays)?;
        }
        if let Some(cells) = &queue.cells {
            stored_table::from_cells(header, cells).with_context(|| format!("{id}/lengths.npy"))?;
        }
        Ok(queue)
    }

    fn uploaded(&self) -> UploadedRays<'_> {
        UploadedRays {
            kind: self.id.kind,
            bounce: self.id.bounce,
            rays: &self.rays,
            path_ids: &self.path_ids,
            lights: self.lights.as_deref().unwrap_or_default(),
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

const NEEDED: &str = "a replay needs the rays and length tables of a recording; record with --keep rays,hits,lengths,scene and more";

/// Traces each queue in canonical order and hands it to the observer.
///
/// # Errors
/// Whatever the backend or the observer reports.
pub fn run<B: Backend>(
    backend: &mut B,
    rays: &RecordedRays<'_>,
    observer: &mut impl Observer<B>,
) -> Result<()> {
    match rays {
        RecordedRays::Dump { queues, .. } => {
            queues.iter().try_for_each(|queue| run_recorded(backend, queue, observer))
        }
        RecordedRays::Queue(queue) => {
            let place = Place { pass: 0, bounce: queue.bounce, kind: queue.kind };
            let rays = backend.upload(*queue)?;
            let hits = backend.trace(&rays)?;
            observer.traced(backend, place, &rays, &hits.value, hits.elapsed_ns)?;
            backend.accumulate(&rays, &hits.value)
        }
    }
}

fn run_recorded<B: Backend>(
    backend: &mut B,
    recorded: &RecordedQueue,
    observer: &mut impl Observer<B>,
) -> Result<()> {
    let id = recorded.id;
    let place = Place { pass: id.pass, bounce: id.bounce, kind: id.kind };
    if let Some(cells) = &recorded.cells {
        backend.load_table(id.kind, cells)?;
    }
    let queue = backend.upload(recorded.uploaded())?;
    let hits = backend.trace(&queue)?;
    observer.traced(backend, place, &queue, &hits.value, hits.elapsed_ns)?;
    if recorded.cells.is_none() {
        backend.accumulate(&queue, &hits.value)?;
    }
    Ok(())
}

fn array<T: Element>(dump: &Dump, id: QueueId, array: QueueArray) -> Result<Mapped<T>> {
    let place = ArrayPlace::Queue(id, array);
    // A file that is there and damaged says so itself.
    if dump.has(&place) { Ok(dump.checked_array(&place)?) } else { dump.array(&place).context(NEEDED) }
}
