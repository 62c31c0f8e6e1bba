//! Measures every method on one queue: key → sort → gather → trace, in round-robin (DESIGN §7).

use anyhow::Result;
use formats::key::Termination;
use formats::metrics::speedup::StageSamples;
use formats::ray::Kind;

use crate::backends::{Backend, Queue, Table};
use crate::stages::setup::MethodPlan;
use crate::stages::trace::Order;

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

/// Measures all methods that apply to the queue.
///
/// A warm-up round comes first; it also hands the number of each method, its keys and its permutation to
/// `ordered`. Then each repeat runs the baseline and every method once, starting one method later each time,
/// so that drift hits all alike.
///
/// # Errors
/// Any of the backend or of `ordered`.
pub fn measure<B: Backend>(
    backend: &mut B,
    rays: &B::Rays,
    hits: &B::Hits,
    methods: &[MethodPlan],
    repeats: u32,
    mut ordered: impl FnMut(&mut B, usize, &B::Keys, &B::Permutation) -> Result<()>,
) -> Result<QueueMeasurement> {
    let applicable = (0..methods.len()).filter(|&method| methods[method].applies_to(rays.id().kind));
    let mut measured: Vec<MethodMeasurement> = applicable
        .map(|method| MethodMeasurement { method, stages: StageSamples::default(), mismatches: 0 })
        .collect();
    for entry in &mut measured {
        let keys = backend.key(rays, hits, entry.method)?;
        let permutation = backend.sort(&keys)?;
        ordered(backend, entry.method, &keys, &permutation)?;
        warm_up(backend, rays, hits, &permutation)?;
    }
    let mut unsorted_ns = Vec::new();
    for repeat in 0..repeats as usize {
        backend.trace(rays, Order::Canonical)?;
        unsorted_ns.push(backend.elapsed_ns());
        let count = measured.len();
        for turn in 0..count {
            let entry = &mut measured[(turn + repeat) % count];
            measure_once(backend, rays, hits, &methods[entry.method], entry)?;
        }
    }
    Ok(QueueMeasurement { unsorted_ns, methods: measured })
}

/// Runs every stage after the sort once, so that no timed one is the first to compile or to touch memory.
fn warm_up<B: Backend>(
    backend: &mut B,
    rays: &B::Rays,
    hits: &B::Hits,
    permutation: &B::Permutation,
) -> Result<()> {
    let gathered = backend.gather(rays, permutation)?;
    backend.trace(&gathered, Order::Gathered(permutation))?;
    backend.trace(rays, Order::Indirect(permutation))?;
    backend.accumulate(rays, hits, Table::Scratch)
}

fn measure_once<B: Backend>(
    backend: &mut B,
    rays: &B::Rays,
    hits: &B::Hits,
    method: &MethodPlan,
    entry: &mut MethodMeasurement,
) -> Result<()> {
    let stages = &mut entry.stages;
    let keys = backend.key(rays, hits, entry.method)?;
    stages.key.push(backend.elapsed_ns());
    let permutation = backend.sort(&keys)?;
    stages.sort.push(backend.elapsed_ns());
    let gathered = backend.gather(rays, &permutation)?;
    stages.gather.push(backend.elapsed_ns());
    let found = backend.trace(&gathered, Order::Gathered(&permutation))?;
    stages.trace.push(backend.elapsed_ns());
    entry.mismatches = entry.mismatches.max(backend.differences(hits, &found)?);
    let found = backend.trace(rays, Order::Indirect(&permutation))?;
    stages.trace_indirect.push(backend.elapsed_ns());
    entry.mismatches = entry.mismatches.max(backend.differences(hits, &found)?);
    if method.termination == Termination::Adaptive {
        backend.accumulate(rays, hits, Table::Scratch)?;
        stages.accumulate.push(backend.elapsed_ns());
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
