//! Measures every method on one queue: key → sort → gather → trace, in round-robin (DESIGN §7).

use anyhow::Result;
use formats::key::Termination;
use formats::metrics::speedup::StageSamples;
use formats::ray::Kind;

use crate::backend::{Backend, MethodPlan, Queue};

/// What measuring one queue gave.
#[derive(Clone, Debug)]
pub struct QueueMeasurement {
    /// Traces in canonical order, nanoseconds each.
    pub unsorted_ns: Vec<u64>,
    /// One entry per method that applies, in the order of the methods.
    pub methods: Vec<MethodMeasurement>,
}

/// What measuring one method on one queue gave.
#[derive(Clone, Debug)]
pub struct MethodMeasurement {
    /// Index into the methods of the run.
    pub method: usize,
    /// Samples per stage.
    pub stages: StageSamples,
    /// Most results of any of its traces that differed from the unsorted ones.
    pub mismatches: u64,
}

/// Keys and order of a method, seen once per queue, before the timed repeats.
pub trait OrderObserver<B: Backend> {
    /// The keys and the permutation that one method gave.
    fn ordered(&mut self, backend: &mut B, method: usize, keys: &B::Keys, order: &B::Order) -> Result<()>;
}

/// Measures all methods that apply to the queue.
///
/// A warm-up round comes first; it also hands keys and permutation to `observer`. Then each repeat
/// runs the baseline and every method once, starting one method later each time, so that drift
/// hits all alike.
///
/// # Errors
/// Whatever the backend or the observer reports.
pub fn measure<B: Backend>(
    backend: &mut B,
    rays: &B::Rays,
    hits: &B::Hits,
    methods: &[MethodPlan],
    repeats: u32,
    observer: &mut impl OrderObserver<B>,
) -> Result<QueueMeasurement> {
    let applicable = (0..methods.len()).filter(|&method| methods[method].applies_to(rays.kind()));
    let mut measured: Vec<MethodMeasurement> = applicable
        .map(|method| MethodMeasurement { method, stages: StageSamples::default(), mismatches: 0 })
        .collect();
    for entry in &mut measured {
        let keys = backend.key(rays, hits, entry.method)?.value;
        let order = backend.sort(&keys)?.value;
        observer.ordered(backend, entry.method, &keys, &order)?;
        warm_up(backend, rays, hits, &order)?;
    }
    let mut unsorted_ns = Vec::new();
    for repeat in 0..repeats as usize {
        unsorted_ns.push(backend.trace(rays)?.elapsed_ns);
        let count = measured.len();
        for turn in 0..count {
            let entry = &mut measured[(turn + repeat) % count];
            measure_once(backend, rays, hits, &methods[entry.method], entry)?;
        }
    }
    Ok(QueueMeasurement { unsorted_ns, methods: measured })
}

/// Runs every stage after the sort once, so that no timed one is the first to compile or to touch memory.
fn warm_up<B: Backend>(backend: &mut B, rays: &B::Rays, hits: &B::Hits, order: &B::Order) -> Result<()> {
    let gathered = backend.gather(rays, order)?.value;
    backend.trace_gathered(&gathered, order)?;
    backend.trace_indirect(rays, order)?;
    backend.time_accumulate(rays, hits)?;
    Ok(())
}

fn measure_once<B: Backend>(
    backend: &mut B,
    rays: &B::Rays,
    hits: &B::Hits,
    method: &MethodPlan,
    entry: &mut MethodMeasurement,
) -> Result<()> {
    let keys = backend.key(rays, hits, entry.method)?;
    entry.stages.key.push(keys.elapsed_ns);
    let order = backend.sort(&keys.value)?;
    entry.stages.sort.push(order.elapsed_ns);
    let gathered = backend.gather(rays, &order.value)?;
    entry.stages.gather.push(gathered.elapsed_ns);
    let scattered = backend.trace_gathered(&gathered.value, &order.value)?;
    entry.stages.trace.push(scattered.elapsed_ns);
    entry.mismatches = entry.mismatches.max(backend.differences(rays, hits, &scattered.value)?);
    let scattered = backend.trace_indirect(rays, &order.value)?;
    entry.stages.trace_indirect.push(scattered.elapsed_ns);
    entry.mismatches = entry.mismatches.max(backend.differences(rays, hits, &scattered.value)?);
    if method.termination == Termination::Adaptive {
        entry.stages.accumulate.push(backend.time_accumulate(rays, hits)?);
    }
    Ok(())
}

/// Whether a speedup may be quoted: the real length is only known once the ray was traced.
pub fn has_speedup(method: &MethodPlan) -> bool {
    method.termination != Termination::Real
}

/// Name of a queue for messages.
pub fn queue_name(bounce: u32, kind: Kind) -> String {
    format!("bounce {bounce}, {kind} rays")
}
