//! Looks at each queue of the loop: measures it, captures it, keeps what the closing table needs.

use anyhow::{Result, bail};
use formats::key::method::UNSORTED;
use formats::length_table::LengthCell;
use formats::manifest::{
    MethodArray, Mismatches, Place as ArrayPlace, QueueArray, QueueId, QueueRecord, Record, Stage,
    TimingRecord,
};
use formats::npy::Dtype;
use formats::ray::{Kind, Ray};
use formats::reader::Dump;

use crate::backend::{Backend, MethodPlan, Queue, collected};
use crate::cache_model::CacheModel;
use crate::capture::Capture;
use crate::comparison::compare;
use crate::measure::{MethodMeasurement, OrderObserver, QueueMeasurement, measure, queue_name};
use crate::options::{Keep, KeepPasses};
use crate::progress::Progress;
use crate::wavefront::{Observer, Place};

/// What is measured and kept.
pub struct Plan<'a> {
    /// Methods, in order.
    pub methods: Vec<MethodPlan>,
    /// Passes of the run; the last one is measured.
    pub passes: u32,
    /// Timed repeats.
    pub repeats: u32,
    /// Arrays to keep.
    pub keep: Keep,
    /// Passes to keep them of.
    pub keep_passes: KeepPasses,
    /// Whether results may differ between orders (the driver's own traversal).
    pub tolerates_mismatches: bool,
    /// Whether the trace kernel counts its work.
    pub counts_work: bool,
    /// Says what caches would make of each order, if that is kept.
    pub cache_model: Option<CacheModel>,
    /// The recording whose queues these are: only what is found otherwise is kept once more.
    pub recorded: Option<&'a Dump>,
}

/// A measured queue, for the closing table.
pub struct MeasuredQueue {
    /// Bounce.
    pub bounce: u32,
    /// Kind.
    pub kind: Kind,
    /// Rays.
    pub rays: usize,
    /// Its times.
    pub measurement: QueueMeasurement,
}

/// The observer of a recording.
pub struct Recorder<'a> {
    plan: &'a Plan<'a>,
    capture: &'a mut Capture,
    progress: &'a Progress,
    /// Every queue of the measured pass.
    pub measured: Vec<MeasuredQueue>,
    /// Rays that did not find what was recorded.
    pub differing: u64,
    /// The last queue of each kind whose arrays are kept.
    last_kept: [Option<QueueId>; 2],
}

impl<'a> Recorder<'a> {
    /// An observer that writes through `capture`.
    pub fn new(plan: &'a Plan<'a>, capture: &'a mut Capture, progress: &'a Progress) -> Self {
        Self { plan, capture, progress, measured: Vec::new(), differing: 0, last_kept: [None; 2] }
    }

    /// Writes the tables' last state. Call once after the loop.
    ///
    /// # Errors
    /// What the backend or the disk reports.
    pub fn finish<B: Backend>(&mut self, backend: &mut B) -> Result<()> {
        if !self.plan.keep.lengths {
            return Ok(());
        }
        for id in self.last_kept.into_iter().flatten() {
            let cells = backend.touched_cells(id.kind)?;
            self.write_cells(id, QueueArray::FinalLengths, &cells)?;
        }
        Ok(())
    }

    fn is_measured(&self, place: Place) -> bool {
        place.pass + 1 == self.plan.passes
    }

    fn keeps(&self, place: Place) -> bool {
        self.is_measured(place) || self.plan.keep_passes == KeepPasses::All
    }

    fn write_cells(&mut self, id: QueueId, array: QueueArray, cells: &[LengthCell]) -> Result<()> {
        self.capture.whole_array(ArrayPlace::Queue(id, array), &[cells.len() as u64], cells)
    }

    fn keep_queue<B: Backend>(
        &mut self,
        backend: &mut B,
        id: QueueId,
        rays: &B::Rays,
        hits: &B::Hits,
    ) -> Result<()> {
        let keep = &self.plan.keep;
        let shape = [rays.len() as u64];
        let at = |array| ArrayPlace::Queue(id, array);
        if keep.rays {
            self.capture
                .array(at(QueueArray::Rays), Dtype::Ray, &shape, |sink| backend.read_rays(rays, sink))?;
            self.capture.array(at(QueueArray::PathIds), Dtype::U4, &shape, |sink| {
                backend.read_path_ids(rays, sink)
            })?;
            if id.kind == Kind::Shadow {
                self.capture.array(at(QueueArray::Lights), Dtype::U4, &shape, |sink| {
                    backend.read_lights(rays, sink)
                })?;
            }
        }
        let differs = match self.plan.recorded {
            None => false,
            Some(dump) => {
                let difference = compare(backend, dump, id, hits)?;
                self.differing += difference.rays;
                difference.in_bits
            }
        };
        if keep.hits || differs {
            let (array, dtype) = match id.kind {
                Kind::Closest => (QueueArray::Hits, Dtype::Hit),
                Kind::Shadow => (QueueArray::Distances, Dtype::F4),
            };
            self.capture.array(at(array), dtype, &shape, |sink| backend.read_hits(hits, sink))?;
        }
        if keep.work && self.plan.counts_work {
            self.capture
                .array(at(QueueArray::Work), Dtype::Work, &shape, |sink| backend.read_work(rays, sink))?;
        }
        if keep.lengths {
            let cells = backend.touched_cells(id.kind)?;
            self.write_cells(id, QueueArray::Lengths, &cells)?;
        }
        Ok(())
    }

    /// What the cache model says of canonical order; returns the rays, for the other orders.
    fn model_baseline<B: Backend>(
        &mut self,
        backend: &mut B,
        id: QueueId,
        rays: &B::Rays,
    ) -> Result<Vec<Ray>> {
        let Some(model) = &self.plan.cache_model else { return Ok(Vec::new()) };
        let copied: Vec<Ray> = collected(|sink| backend.read_rays(rays, sink))?;
        self.capture.record(Record::Cache(model.record(id, UNSORTED, &copied, |at| at)))?;
        Ok(copied)
    }

    fn write_timings(&mut self, id: QueueId, measurement: &QueueMeasurement) -> Result<()> {
        self.timing(id, UNSORTED, Stage::Trace, &measurement.unsorted_ns)?;
        for MethodMeasurement { method, stages, .. } in &measurement.methods {
            let name = &self.plan.methods[*method].name;
            for (stage, samples) in [
                (Stage::Key, &stages.key),
                (Stage::Sort, &stages.sort),
                (Stage::Gather, &stages.gather),
                (Stage::Trace, &stages.trace),
                (Stage::TraceIndirect, &stages.trace_indirect),
                (Stage::Accumulate, &stages.accumulate),
            ] {
                if !samples.is_empty() {
                    self.timing(id, name, stage, samples)?;
                }
            }
        }
        Ok(())
    }

    fn timing(&mut self, id: QueueId, method: &str, stage: Stage, samples_ns: &[u64]) -> Result<()> {
        self.capture.record(Record::Timing(TimingRecord {
            pass: id.pass,
            bounce: id.bounce,
            kind: (!matches!(stage, Stage::Generate | Stage::Shade)).then_some(id.kind),
            method: method.to_owned(),
            stage,
            samples_ns: samples_ns.to_vec(),
        }))
    }

    fn queue_record(&self, id: QueueId, rays: usize, measurement: Option<&QueueMeasurement>) -> QueueRecord {
        let name = |entry: &MethodMeasurement| self.plan.methods[entry.method].name.clone();
        let entries = measurement.map_or(&[][..], |measurement| &measurement.methods);
        let baseline = measurement.map(|_| UNSORTED.to_owned());
        let mismatches =
            entries.iter().map(|entry| Mismatches { method: name(entry), rays: entry.mismatches });
        QueueRecord {
            id,
            rays: rays as u64,
            methods: baseline.into_iter().chain(entries.iter().map(name)).collect(),
            mismatches: mismatches.collect(),
        }
    }
}

impl<B: Backend> Observer<B> for Recorder<'_> {
    fn traced(
        &mut self,
        backend: &mut B,
        place: Place,
        rays: &B::Rays,
        hits: &B::Hits,
        _elapsed_ns: u64,
    ) -> Result<()> {
        let id = QueueId { pass: place.pass, bounce: place.bounce, kind: place.kind };
        self.progress.traced(place, rays.len());
        if self.keeps(place) {
            self.keep_queue(backend, id, rays, hits)?;
            self.last_kept[place.kind as usize] = Some(id);
        }
        let mut measurement = None;
        if self.is_measured(place) {
            let copied = self.model_baseline(backend, id, rays)?;
            let mut orders =
                OrderCapture { plan: self.plan, capture: self.capture, id, rays: rays.len(), copied };
            let measured = measure(backend, rays, hits, &self.plan.methods, self.plan.repeats, &mut orders)?;
            self.progress.measured(place, rays.len());
            self.check_mismatches(place, &measured)?;
            self.write_timings(id, &measured)?;
            measurement = Some(measured);
        }
        if self.keeps(place) {
            self.capture.record(Record::Queue(self.queue_record(id, rays.len(), measurement.as_ref())))?;
        }
        if let Some(measurement) = measurement {
            self.measured.push(MeasuredQueue {
                bounce: place.bounce,
                kind: place.kind,
                rays: rays.len(),
                measurement,
            });
        }
        Ok(())
    }

    fn stage(&mut self, place: Place, stage: Stage, elapsed_ns: u64) -> Result<()> {
        if self.is_measured(place) {
            let id = QueueId { pass: place.pass, bounce: place.bounce, kind: place.kind };
            self.timing(id, UNSORTED, stage, &[elapsed_ns])?;
        }
        Ok(())
    }
}

impl Recorder<'_> {
    fn check_mismatches(&self, place: Place, measurement: &QueueMeasurement) -> Result<()> {
        for entry in &measurement.methods {
            if entry.mismatches > 0 && !self.plan.tolerates_mismatches {
                bail!(
                    "{}: {} rays traced in the order of '{}' found something else than in canonical order; \
                     a ray's result must depend on that ray alone, so this is a fault of the driver or of this program: please report it",
                    queue_name(place.bounce, place.kind),
                    entry.mismatches,
                    self.plan.methods[entry.method].name
                );
            }
        }
        Ok(())
    }
}

/// Writes keys and permutations as the warm-up round makes them.
struct OrderCapture<'a> {
    plan: &'a Plan<'a>,
    capture: &'a mut Capture,
    id: QueueId,
    rays: usize,
    /// The rays themselves, for the cache model; empty without it.
    copied: Vec<Ray>,
}

impl<B: Backend> OrderObserver<B> for OrderCapture<'_> {
    fn ordered(&mut self, backend: &mut B, method: usize, keys: &B::Keys, order: &B::Order) -> Result<()> {
        let plan = &self.plan.methods[method];
        let at = |array| ArrayPlace::Method(self.id, plan.name.clone(), array);
        let shape = [self.rays as u64];
        if self.plan.keep.keys {
            let dtype = if plan.key_bits <= 32 { Dtype::U4 } else { Dtype::U8 };
            self.capture.array(at(MethodArray::Keys), dtype, &shape, |sink| backend.read_keys(keys, sink))?;
        }
        if self.plan.keep.permutations {
            self.capture.array(at(MethodArray::Permutation), Dtype::U4, &shape, |sink| {
                backend.read_order(order, sink)
            })?;
        }
        if let Some(model) = &self.plan.cache_model {
            let permutation: Vec<u32> = collected(|sink| backend.read_order(order, sink))?;
            let record = model.record(self.id, &plan.name, &self.copied, |at| permutation[at] as usize);
            self.capture.record(Record::Cache(record))?;
        }
        Ok(())
    }
}
