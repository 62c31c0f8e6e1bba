//! Measures and captures each queue of the loop, and keeps what the closing table needs.

use anyhow::{Result, bail};
use formats::key::method::UNSORTED;
use formats::length_table::LengthCell;
use formats::manifest::{
    DecisionRecord, DisturbedRecord, MethodArray, Mismatches, Place, QueueArray, QueueId, QueueRecord,
    Record, Stage, TimingRecord, Way, WayRecord,
};
use formats::npy::Dtype;
use formats::ray::{Kind, Ray};
use formats::reader::Dump;

use crate::auto::{Auto, Decision};
use crate::backends::{Array, Backend, Queue, collect};
use crate::cache_model::CacheModel;
use crate::capture::Capture;
use crate::comparison::compare;
use crate::foreign::ForeignOrder;
use crate::measure::{Measured, Measurement, QueueMeasurement, Queued, Subject, queue_name};
use crate::options::{KeepPasses, RecordOptions};
use crate::progress::Progress;
use crate::stages::setup::MethodPlan;
use crate::wavefront::Observer;

/// What is measured and kept.
pub struct Plan<'a> {
    /// Methods, in order.
    pub methods: Vec<MethodPlan>,
    /// What was asked for; the last of its passes is measured.
    pub options: &'a RecordOptions,
    /// What is measured on every queue of that pass.
    pub measured: Measured,
    /// Whether the trace kernel is ours: it counts its work, and finds the same in every order.
    pub kernel_is_ours: bool,
    /// Says what caches would make of each order, if that is kept.
    pub cache_model: Option<CacheModel>,
    /// Orders that came with the queues.
    pub foreign: &'a [ForeignOrder],
    /// What chooses orders for `auto`.
    pub auto: Option<Auto>,
    /// The recording whose queues these are: only what is found otherwise is kept once more.
    pub recorded: Option<&'a Dump>,
}

/// The way that was shorter over all queues in the trial rounds; `None` where there are not two.
fn chosen_way(queues: &[QueueMeasurement], subject: Subject) -> Option<Way> {
    let entries = queues.iter().flatten();
    let ns = entries.filter(|entry| entry.subject == subject).map(|entry| entry.trial_ns);
    let ns: Vec<[u64; 2]> = ns.filter(|ns| !ns.contains(&0)).collect();
    let [gathered, indices] = [0, 1].map(|way| ns.iter().map(|ns| ns[way]).sum::<u64>());
    let way = if indices < gathered { Way::Indices } else { Way::Gathered };
    (!ns.is_empty()).then_some(way)
}

/// The observer of a recording.
pub struct Recorder<'a> {
    plan: &'a Plan<'a>,
    capture: &'a mut Capture,
    progress: &'a Progress,
    /// Every queue of the measured pass.
    measured: Vec<QueueMeasurement>,
    /// Rays that did not find what was recorded.
    pub differing: u64,
    /// The last queue of each kind whose arrays are kept.
    last_kept: [Option<QueueId>; 2],
    /// What was copied from the backend last.
    cells: Vec<LengthCell>,
    rays: Vec<Ray>,
    places: Vec<u32>,
}

impl<'a> Recorder<'a> {
    /// An observer that writes through `capture`.
    pub fn new(plan: &'a Plan<'a>, capture: &'a mut Capture, progress: &'a Progress) -> Self {
        Self {
            plan,
            capture,
            progress,
            measured: Vec::new(),
            differing: 0,
            last_kept: [None; 2],
            cells: Vec::new(),
            rays: Vec::new(),
            places: Vec::new(),
        }
    }

    /// Writes which way of tracing counts for each method, and the tables' last state. Call once after the loop.
    ///
    /// # Errors
    /// What the backend or the disk reports.
    pub fn finish<B: Backend>(&mut self, backend: &mut B) -> Result<()> {
        for &subject in &self.plan.measured.orders {
            if let Some(way) = chosen_way(&self.measured, subject) {
                let method = subject.name(&self.plan.methods).to_owned();
                self.capture.record(Record::Way(WayRecord { method, way }))?;
            }
        }
        if !self.plan.options.keep.lengths {
            return Ok(());
        }
        for id in self.last_kept.into_iter().flatten() {
            self.write_cells(backend, id, QueueArray::FinalLengths)?;
        }
        Ok(())
    }

    fn is_measured(&self, id: QueueId) -> bool {
        id.pass + 1 == self.plan.options.passes
    }

    fn keeps(&self, id: QueueId) -> bool {
        self.is_measured(id) || self.plan.options.keep_passes == KeepPasses::All
    }

    fn write_cells<B: Backend>(&mut self, backend: &mut B, id: QueueId, array: QueueArray) -> Result<()> {
        collect(backend, Array::Lengths(id.kind), &mut self.cells)?;
        self.capture.whole_array(Place::Queue(id, array), &[self.cells.len() as u64], &self.cells)
    }

    fn keep_queue<B: Backend>(&mut self, backend: &mut B, rays: &B::Rays, hits: &B::Hits) -> Result<()> {
        let (keep, id) = (&self.plan.options.keep, rays.id());
        let differs = match self.plan.recorded {
            None => false,
            Some(dump) => {
                let difference = compare(backend, dump, id, hits)?;
                self.differing += difference.rays;
                difference.in_bits
            }
        };
        let is_closest = id.kind == Kind::Closest;
        let result_type = if is_closest { Dtype::Hit } else { Dtype::F4 };
        let arrays = [
            (keep.rays, QueueArray::Rays, Dtype::Ray, Array::Rays(rays)),
            (keep.rays, QueueArray::PathIds, Dtype::U4, Array::PathIds(rays)),
            (keep.rays && !is_closest, QueueArray::Lights, Dtype::U4, Array::Lights(rays)),
            (keep.hits || differs, QueueArray::results(id.kind), result_type, Array::Hits(hits)),
            (keep.work && self.plan.kernel_is_ours, QueueArray::Work, Dtype::Work, Array::Work(rays)),
            (keep.throughput && is_closest, QueueArray::Throughput, Dtype::F4, Array::Throughput(rays)),
        ];
        for (_, name, dtype, array) in arrays.into_iter().filter(|(is_kept, ..)| *is_kept) {
            let in_columns = [rays.len() as u64, 3];
            let shape = if name == QueueArray::Throughput { &in_columns[..] } else { &in_columns[..1] };
            self.capture.array(Place::Queue(id, name), dtype, shape, |sink| backend.read(array, sink))?;
        }
        if keep.lengths {
            self.write_cells(backend, id, QueueArray::Lengths)?;
        }
        Ok(())
    }

    /// What the cache model says of canonical order; copies the rays, for the other orders.
    fn model_baseline<B: Backend>(&mut self, backend: &mut B, rays: &B::Rays) -> Result<()> {
        let Some(model) = &self.plan.cache_model else { return Ok(()) };
        collect(backend, Array::Rays(rays), &mut self.rays)?;
        self.capture.record(Record::Cache(model.record(rays.id(), UNSORTED, &self.rays, |at| at)))
    }

    fn write_timings(&mut self, id: QueueId, measurements: &QueueMeasurement) -> Result<()> {
        let plan = self.plan;
        for Measurement { subject, stages, disturbed, .. } in measurements {
            let name = subject.name(&plan.methods);
            for (stage, samples) in stages.iter() {
                self.timing(id, name, stage, samples)?;
            }
            for (&stage, rounds) in disturbed {
                self.capture.record(Record::Disturbed(DisturbedRecord {
                    queue: id,
                    method: name.to_owned(),
                    stage,
                    samples: rounds.clone(),
                }))?;
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

    fn queue_record(&self, id: QueueId, rays: usize, measurements: &[Measurement]) -> QueueRecord {
        let of_method = |entry: &&Measurement| match entry.subject {
            Subject::Unsorted => false,
            Subject::Control => self.plan.options.orders.control,
            Subject::Method(_) | Subject::Shuffled | Subject::Auto | Subject::Foreign(_) => true,
        };
        let name = |entry: &Measurement| entry.subject.name(&self.plan.methods).to_owned();
        let methods = measurements.iter().filter(of_method);
        let baseline = (!measurements.is_empty()).then(|| UNSORTED.to_owned());
        let mismatches =
            methods.clone().map(|entry| Mismatches { method: name(entry), rays: entry.mismatches });
        QueueRecord {
            id,
            rays: rays as u64,
            mismatches: mismatches.collect(),
            methods: baseline.into_iter().chain(methods.map(name)).collect(),
        }
    }
}

impl<B: Backend> Observer<B> for Recorder<'_> {
    fn measure(&mut self, backend: &mut B, rays: &B::Rays, hits: &B::Hits) -> Result<()> {
        let (id, count) = (rays.id(), rays.len());
        self.progress.traced(id, count);
        if self.keeps(id) {
            self.keep_queue(backend, rays, hits)?;
            self.last_kept[id.kind as usize] = Some(id);
        }
        let measurements =
            if self.is_measured(id) { self.measure_orders(backend, rays, hits)? } else { Vec::new() };
        if self.keeps(id) {
            self.capture.record(Record::Queue(self.queue_record(id, count, &measurements)))?;
            // The first stage of the measured pass is timed, too.
            if id.pass + 2 == self.plan.options.passes {
                self.capture.drain()?;
            }
        }
        if self.is_measured(id) {
            self.measured.push(measurements);
        }
        Ok(())
    }

    fn ran(&mut self, backend: &B, stage: Stage, rays: &B::Rays) -> Result<()> {
        if self.is_measured(rays.id()) {
            self.timing(rays.id(), UNSORTED, stage, &[backend.elapsed_ns()])?;
        }
        Ok(())
    }
}

impl Recorder<'_> {
    /// Measures every order, and captures keys and permutations as the warm-up round makes them.
    fn measure_orders<B: Backend>(
        &mut self,
        backend: &mut B,
        rays: &B::Rays,
        hits: &B::Hits,
    ) -> Result<QueueMeasurement> {
        let (plan, id) = (self.plan, rays.id());
        self.model_baseline(backend, rays)?;
        let queue =
            Queued { rays, hits, methods: &plan.methods, foreign: plan.foreign, auto: plan.auto.as_ref() };
        self.write_decision(backend, rays)?;
        self.keep_foreign(id)?;
        let orders = queue.warm_up(backend, &plan.measured, |backend, subject, keys, permutation| {
            self.keep_order(backend, rays, subject, (keys, permutation))
        })?;
        self.capture.drain()?;
        let measurements = queue.measure(backend, &plan.measured, &orders)?;
        self.progress.measured(id, rays.len());
        self.check_mismatches(id, &measurements)?;
        self.write_timings(id, &measurements)?;
        Ok(measurements)
    }

    /// Writes which order `auto` gives the queue.
    fn write_decision<B: Backend>(&mut self, backend: &mut B, rays: &B::Rays) -> Result<()> {
        let Some(auto) = &self.plan.auto else { return Ok(()) };
        let Decision { area, choice, .. } = auto.decide(backend, rays)?.0;
        self.capture.record(Record::Decision(DecisionRecord { queue: rays.id(), area, choice }))
    }

    /// Writes keys and permutation, and what caches make of the order.
    fn keep_order<B: Backend>(
        &mut self,
        backend: &mut B,
        rays: &B::Rays,
        subject: Subject,
        (keys, permutation): (Option<&B::Keys>, &B::Permutation),
    ) -> Result<()> {
        if subject == Subject::Control && !self.plan.options.orders.control {
            return Ok(());
        }
        let name = subject.name(&self.plan.methods);
        let at = |array| Place::Method(rays.id(), name.to_owned(), array);
        let shape = [rays.len() as u64];
        if let (Subject::Method(number), Some(keys)) = (subject, keys.filter(|_| self.plan.options.keep.keys))
        {
            let dtype = if self.plan.methods[number].key_bits <= 32 { Dtype::U4 } else { Dtype::U8 };
            self.capture
                .array(at(MethodArray::Keys), dtype, &shape, |sink| backend.read(Array::Keys(keys), sink))?;
        }
        // Those that came with the queue are written as they came.
        if self.plan.options.keep.permutations && !matches!(subject, Subject::Foreign(_)) {
            self.capture.array(at(MethodArray::Permutation), Dtype::U4, &shape, |sink| {
                backend.read(Array::Permutation(permutation), sink)
            })?;
        }
        if let Some(model) = &self.plan.cache_model {
            let Self { places, rays: copied, .. } = self;
            collect(backend, Array::Permutation(permutation), places)?;
            self.capture
                .record(Record::Cache(model.record(rays.id(), name, copied, |at| places[at] as usize)))?;
        }
        Ok(())
    }

    /// Writes the orders that came with a queue, also what is no permutation.
    fn keep_foreign(&mut self, id: QueueId) -> Result<()> {
        let keep = self.plan.options.keep;
        for ForeignOrder { name, permutation, keys, .. } in
            self.plan.foreign.iter().filter(|order| order.queue == id)
        {
            let at = |array| Place::Method(id, name.clone(), array);
            let shape = [permutation.len() as u64];
            if let Some(keys) = keys.as_ref().filter(|_| keep.keys) {
                let place = at(MethodArray::Keys);
                self.capture.array(place, keys.dtype(), &shape, |sink| sink(keys.bytes()))?;
            }
            if keep.permutations {
                self.capture.whole_array(at(MethodArray::Permutation), &shape, permutation)?;
            }
        }
        Ok(())
    }

    fn check_mismatches(&self, id: QueueId, measurements: &QueueMeasurement) -> Result<()> {
        for entry in measurements {
            if entry.mismatches > 0 && self.plan.kernel_is_ours {
                bail!(
                    "{}: {} rays traced in the order of '{}' found something else than in canonical order; \
                     a ray's result must depend on that ray alone, so this is a fault of the driver or of this program: please report it",
                    queue_name(id.bounce, id.kind),
                    entry.mismatches,
                    entry.subject.name(&self.plan.methods)
                );
            }
        }
        Ok(())
    }
}
