//! Trace rate per scene, kernel, bounce, kind and order, all of them on the same rays, in rounds.

use std::sync::Arc;

use anyhow::Result;
use formats::bench_result::{BenchResult, LaneRow, Rows, TraceRow};
use formats::key::method::UNSORTED;
use formats::length_table::LengthCell;
use formats::metrics::lanes::{LaneUse, work_of};
use formats::ray::Work;
use scenes::Scene;

use super::backends::{Configuration, OnBackends, measure_all};
use super::queues::Copied;
use super::result;
use crate::backends::{Array, Backend, Queue, collected};
use crate::machine;
use crate::measure::{sampled, seed_of};
use crate::options::{DeviceOptions, RecordOptions};
use crate::recording::prepared;
use crate::stages::setup::Setup;
use crate::stages::trace::{Order, TraceKernel};
use crate::wavefront::{self, Observer};

/// What to measure: scenes one after the other, the rest as for a recording.
#[derive(Clone, Debug)]
pub struct TraceBench {
    /// Scenes, files or built-in names.
    pub scenes: Vec<String>,
    /// Trace kernels; rays are made with the first.
    pub kernels: Vec<TraceKernel>,
    /// Size of the run, methods, device; what is to be kept is of no interest.
    pub run: RecordOptions,
}

/// Traces every queue of each scene's last pass with every kernel in every order.
///
/// # Errors
/// One sentence on what went wrong with scene or device.
pub fn run(bench: &TraceBench) -> Result<BenchResult> {
    let mut rows = Vec::new();
    // What decides on the device: a GPU with queries has every kernel of GPUs, others are for threads alone.
    let is_first = |kernel: &&TraceKernel| **kernel == TraceKernel::RayQuery || !kernel.is_for_gpus();
    let kernel = bench.kernels.iter().find(is_first).copied();
    let device = machine::open(&DeviceOptions { trace: kernel, ..bench.run.device.clone() })?;
    let kernels = if bench.kernels.is_empty() { device.kernels() } else { bench.kernels.clone() };
    let bench = &TraceBench { kernels, ..bench.clone() };
    for name in &bench.scenes {
        let scene = scenes::load(name)?;
        let setup = prepared(&device, &scene, &bench.run)?;
        let paths = OverPaths { bench, scene: &scene, setup: &setup };
        let of_kernel = |&kernel: &TraceKernel| Configuration { setup: Arc::clone(&setup), kernel };
        let configurations: Vec<_> = bench.kernels.iter().map(of_kernel).collect();
        rows.extend(measure_all(&device, &scene, &configurations, paths)?);
    }
    Ok(result(&device, Rows::Trace(rows)))
}

/// The queues of paths that the first kernel traces.
struct OverPaths<'a> {
    bench: &'a TraceBench,
    scene: &'a Scene,
    setup: &'a Setup,
}

impl OnBackends for OverPaths<'_> {
    type Output = Vec<TraceRow>;

    fn run<B: Backend>(self, mut backends: Vec<B>) -> Result<Vec<TraceRow>> {
        let Self { bench, scene, setup } = self;
        let mut first = backends.remove(0);
        let mut observer = KernelsAndOrders { bench, scene, setup, others: backends, rows: Vec::new() };
        wavefront::run(&mut first, 0..bench.run.passes, bench.run.bounces, &mut observer)?;
        Ok(observer.rows)
    }
}

/// Measures each queue of the last pass.
struct KernelsAndOrders<'a, B> {
    bench: &'a TraceBench,
    scene: &'a Scene,
    setup: &'a Setup,
    /// The backends of all kernels but the first, which makes the rays.
    others: Vec<B>,
    rows: Vec<TraceRow>,
}

impl<B: Backend> Observer<B> for KernelsAndOrders<'_, B> {
    fn measure(&mut self, backend: &mut B, rays: &B::Rays, hits: &B::Hits) -> Result<()> {
        let id = rays.id();
        if id.pass + 1 != self.bench.run.passes {
            return Ok(());
        }
        let copied = Copied::of(backend, rays)?;
        let cells: Vec<LengthCell> = collected(backend, Array::Lengths(id.kind))?;
        // Keys are made once, by the backend that has the length table as paths made it.
        let methods: Vec<usize> =
            (0..self.setup.methods.len()).filter(|&at| self.setup.methods[at].applies_to(id.kind)).collect();
        let mut kernels = vec![prepare(backend, rays, hits, &methods)?];
        let mut queues = Vec::new();
        for other in &mut self.others {
            let queue = other.upload(copied.queue(Some(&cells)))?;
            let hits = other.trace(&queue, Order::Stored)?;
            kernels.push(prepare(other, &queue, &hits, &methods)?);
            queues.push(queue);
        }
        let (width, run) = (methods.len() + 1, &self.bench.run);
        let seed = seed_of(run.seed, id);
        let mut samples = sampled(kernels.len() * width, run.repeats, seed, |at| {
            let (kernel, order) = (at / width, at % width);
            let permutation = &kernels[kernel][order];
            match kernel.checked_sub(1) {
                None => sample(backend, rays, permutation),
                Some(other) => sample(&mut self.others[other], &queues[other], permutation),
            }
        })?
        .into_iter();
        let mut lanes = Vec::new();
        for (kernel, permutations) in kernels.iter().enumerate() {
            for permutation in permutations {
                lanes.push(match kernel.checked_sub(1) {
                    None => lane_row(backend, rays, permutation)?,
                    Some(other) => lane_row(&mut self.others[other], &queues[other], permutation)?,
                });
            }
        }
        let mut lanes = lanes.into_iter();
        for kernel in &self.bench.kernels {
            let names = methods.iter().map(|&method| self.setup.methods[method].name.as_str());
            let found = (&mut samples).zip(&mut lanes);
            for (order, (samples_ns, lanes)) in [UNSORTED].into_iter().chain(names).zip(found) {
                self.rows.push(TraceRow {
                    scene: self.scene.name.clone(),
                    triangles: self.scene.triangles.len() as u64,
                    kernel: kernel.name().to_owned(),
                    bounce: id.bounce,
                    kind: id.kind,
                    order: order.to_owned(),
                    rays: rays.len() as u64,
                    samples_ns,
                    lanes,
                });
            }
        }
        Ok(())
    }
}

/// Canonical order, and the order of every method.
fn prepare<B: Backend>(
    backend: &mut B,
    rays: &B::Rays,
    hits: &B::Hits,
    methods: &[usize],
) -> Result<Vec<B::Permutation>> {
    let mut orders = vec![backend.upload_permutation(&(0..rays.len() as u32).collect::<Vec<_>>())?];
    for &method in methods {
        let keys = backend.key(rays, Some(hits), method)?;
        orders.push(backend.sort(&keys)?);
    }
    Ok(orders)
}

/// Nanoseconds of a trace of rays that were gathered before, those in canonical order like all others: what was just
/// written is read faster.
fn sample<B: Backend>(backend: &mut B, rays: &B::Rays, permutation: &B::Permutation) -> Result<u64> {
    backend.forget(rays)?;
    let gathered = backend.gather(rays, permutation)?;
    backend.trace(&gathered, Order::Stored)?;
    Ok(backend.elapsed_ns())
}

/// How busy the lanes of a kernel are with rays in an order, if it traces several at once.
fn lane_row<B: Backend>(
    backend: &mut B,
    rays: &B::Rays,
    permutation: &B::Permutation,
) -> Result<Option<LaneRow>> {
    let rays = &backend.gather(rays, permutation)?;
    let found: Vec<[u64; 3]> = collected(backend, Array::LaneUse(rays))?;
    let Some(&[width, work, capacity]) = found.first() else { return Ok(None) };
    let measured = LaneUse { width: width as usize, work, capacity };
    let works: Vec<Work> = collected(backend, Array::Work(rays))?;
    let mut model = LaneUse::new(width as usize);
    model.add(&works.iter().map(work_of).collect::<Vec<_>>());
    let shares = measured.utilisation().zip(model.utilisation());
    Ok(shares.map(|(measured, model)| LaneRow { width, measured, model }))
}
