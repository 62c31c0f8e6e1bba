//! Pictures: wall time, overhead included, against noise.
//!
//! Hits do not depend on the order in which rays are traced, so after as many passes every method has the
//! same picture, and what sorting buys is time. Each queue is therefore traced once in the order of every
//! method, in turns, and what a renderer that keeps to one method would have waited for is added up.

use std::time::Instant;

use anyhow::Result;
use formats::bench_result::error::ImageRow;
use formats::key::Termination;
use formats::key::method::UNSORTED;
use formats::manifest::Stage;
use formats::ray::Kind;

use super::super::backends::{self, Measurement};
use super::Bench;
use crate::backends::{Backend, Queue, Table, picture};
use crate::options::RecordOptions;
use crate::stages::setup::{MethodPlan, Setup};
use crate::stages::trace::Order;
use crate::wavefront::{self, Observer};

/// Keeps dark pixels from deciding: a part of the reference's mean square.
const DARK: f64 = 0.01;

/// Renders a reference with another seed, then pictures of more and more passes.
pub(super) fn run(bench: Bench<'_>) -> Result<Vec<ImageRow>> {
    let size = bench.options.image;
    let mut run = RecordOptions { width: size.width, height: size.height, ..bench.options.run.clone() };
    // What must be traced before it is sorted cannot win time.
    run.methods.retain(|method| method.termination != Termination::Real);
    let other_seed = RecordOptions { seed: !run.seed, methods: Vec::new(), ..run.clone() };
    let kernels = [bench.device.kernel(&run.device)];
    let reference = Reference { passes: size.reference_passes, bounces: run.bounces };
    let setup = bench.setup(&other_seed)?;
    let reference = backends::measure(bench.device, bench.scene, &setup, &kernels, reference)?;
    let setup = bench.setup(&run)?;
    let clocks = vec![Clock::default(); setup.methods.len()];
    let work =
        Pictures { bench, setup: &setup, reference, shared_ns: 0, unsorted_ns: 0, clocks, rows: Vec::new() };
    backends::measure(bench.device, bench.scene, &setup, &kernels, work)
}

/// Mean over all pixels and channels of the squared difference, each over the reference's square.
pub fn relative_mse(picture: &[[f32; 3]], reference: &[[f32; 3]]) -> f64 {
    let channels = |image: &[[f32; 3]]| image.iter().flatten().copied().map(f64::from).collect::<Vec<_>>();
    let (found, exact) = (channels(picture), channels(reference));
    let count = exact.len().max(1) as f64;
    let floor = DARK * exact.iter().map(|value| value * value).sum::<f64>() / count;
    let error = |(found, exact): (&f64, &f64)| {
        let square = exact * exact + floor;
        if square > 0.0 { (found - exact).powi(2) / square } else { 0.0 }
    };
    found.iter().zip(&exact).map(error).sum::<f64>() / count
}

struct Reference {
    passes: u32,
    bounces: u32,
}

impl Measurement for Reference {
    type Output = Vec<[f32; 3]>;

    fn run<B: Backend>(self, mut backends: Vec<B>) -> Result<Vec<[f32; 3]>> {
        wavefront::run(&mut backends[0], self.passes, self.bounces, &mut ())?;
        picture(&mut backends[0], self.passes)
    }
}

/// What the queues so far took when traced in the order of a method, nanoseconds.
#[derive(Clone, Debug, Default)]
struct Clock {
    gathered_ns: u64,
    indirect_ns: u64,
}

struct Pictures<'a> {
    bench: Bench<'a>,
    setup: &'a Setup,
    reference: Vec<[f32; 3]>,
    /// Generating and shading, the same for all.
    shared_ns: u64,
    unsorted_ns: u64,
    /// By method.
    clocks: Vec<Clock>,
    rows: Vec<ImageRow>,
}

impl Measurement for Pictures<'_> {
    type Output = Vec<ImageRow>;

    fn run<B: Backend>(mut self, mut backends: Vec<B>) -> Result<Vec<ImageRow>> {
        let passes = self.bench.options.image.passes;
        let backend = &mut backends[0];
        wavefront::run(backend, passes, self.bench.options.run.bounces, &mut self)?;
        self.look(backend, passes)?;
        Ok(self.rows)
    }
}

impl<B: Backend> Observer<B> for Pictures<'_> {
    fn measure(&mut self, backend: &mut B, rays: &B::Rays, hits: &B::Hits) -> Result<()> {
        let id = rays.id();
        let is_camera = id.bounce == 0 && id.kind == Kind::Closest;
        if is_camera && id.pass > 0 {
            self.look(backend, id.pass)?;
        }
        let unsorted_ns = waited(|| backend.trace(rays, Order::Stored).map(drop))?;
        self.unsorted_ns += unsorted_ns;
        let count = self.clocks.len();
        for turn in 0..count {
            let method = (turn + id.pass as usize) % count;
            let plan = &self.setup.methods[method];
            let clock = &mut self.clocks[method];
            if is_camera || !plan.applies_to(id.kind) {
                clock.gathered_ns += unsorted_ns;
                clock.indirect_ns += unsorted_ns;
            } else {
                sorted(backend, rays, hits, method, plan, clock)?;
            }
        }
        Ok(())
    }

    fn ran(&mut self, backend: &B, _: Stage, _: &B::Rays) -> Result<()> {
        self.shared_ns += backend.elapsed_ns();
        Ok(())
    }
}

impl Pictures<'_> {
    /// Records what every method has taken after so many passes.
    fn look<B: Backend>(&mut self, backend: &mut B, passes: u32) -> Result<()> {
        let Self { bench, setup, .. } = self;
        let relative_mse = relative_mse(&picture(backend, passes)?, &self.reference);
        let row = |method: &str, traced_ns: u64| ImageRow {
            scene: bench.scene.name.clone(),
            method: method.to_owned(),
            width: setup.width,
            height: setup.height,
            passes,
            wall_ns: self.shared_ns + traced_ns,
            relative_mse,
            reference_passes: bench.options.image.reference_passes,
        };
        self.rows.push(row(UNSORTED, self.unsorted_ns));
        for (plan, clock) in setup.methods.iter().zip(&self.clocks) {
            // A renderer settles on one way to trace.
            self.rows.push(row(&plan.name, clock.gathered_ns.min(clock.indirect_ns)));
        }
        Ok(())
    }
}

fn sorted<B: Backend>(
    backend: &mut B,
    rays: &B::Rays,
    hits: &B::Hits,
    method: usize,
    plan: &MethodPlan,
    clock: &mut Clock,
) -> Result<()> {
    let start = Instant::now();
    let keys = backend.key(rays, hits, method)?;
    let order = backend.sort(&keys)?;
    let mut before_ns = start.elapsed().as_nanos() as u64;
    if plan.termination == Termination::Adaptive {
        before_ns += waited(|| backend.accumulate(rays, hits, Table::Scratch))?;
    }
    clock.gathered_ns += before_ns
        + waited(|| {
            let gathered = backend.gather(rays, &order)?;
            let found = backend.trace(&gathered, Order::Stored)?;
            backend.scatter(&found, &order).map(drop)
        })?;
    clock.indirect_ns += before_ns + waited(|| backend.trace(rays, Order::Indirect(&order)).map(drop))?;
    Ok(())
}

/// Nanoseconds on the wall that something takes.
fn waited(work: impl FnOnce() -> Result<()>) -> Result<u64> {
    let start = Instant::now();
    work()?;
    Ok(start.elapsed().as_nanos() as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn relative_errors_by_hand() {
        let reference = [[1.0, 1.0, 1.0], [0.0, 0.0, 0.0]];
        assert_eq!(relative_mse(&reference, &reference), 0.0);
        // Mean square 0.5, floor 0.005: half of the channels are off by 0.5 of 1.
        let found = relative_mse(&[[1.5, 1.5, 1.5], [0.0, 0.0, 0.0]], &reference);
        assert!((found - 0.5 * 0.25 / 1.005).abs() < 1e-12, "{found}");
        // In the dark only the floor keeps it finite.
        let found = relative_mse(&[[1.0, 1.0, 1.0], [0.0, 0.1, 0.0]], &reference);
        assert!((found - 0.01 / 0.005 / 6.0).abs() < 1e-6, "{found}");
        assert_eq!(relative_mse(&[[0.0; 3]], &[[0.0; 3]]), 0.0);
    }
}
