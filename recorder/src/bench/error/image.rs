//! Pictures: the time of all stages against noise.
//!
//! Hits do not depend on the order in which rays are traced, so after as many passes every method has the
//! same picture, and what sorting buys is time. Each queue is therefore measured in the order of every method
//! as a recording measures it, and what a renderer that keeps to one method would have taken is added up. A
//! pass is a round: the speedup is the median over passes.

use anyhow::Result;
use formats::bench_result::error::ImageRow;
use formats::key::Termination;
use formats::key::method::UNSORTED;
use formats::manifest::{Stage, Way};
use formats::metrics::speedup::Speedup;
use formats::ray::Kind;

use super::super::backends::OnBackend;
use super::Bench;
use crate::backends::{Backend, Queue, picture};
use crate::measure::{Measured, Queued, Subject};
use crate::options::{AskedOrders, RecordOptions};
use crate::stages::setup::Setup;
use crate::wavefront::{self, Observer};

/// Keeps dark pixels from deciding: a part of the reference's mean square.
const DARK: f64 = 0.01;

/// Renders a reference with another seed, then pictures of more and more passes.
pub(super) fn run(bench: Bench<'_>) -> Result<Vec<ImageRow>> {
    let size = bench.options.image;
    let mut run = RecordOptions { width: size.width, height: size.height, ..bench.options.run.clone() };
    // What must be traced before it is sorted cannot win time.
    run.orders.methods.retain(|method| method.termination != Termination::Real);
    let other_seed = RecordOptions { seed: !run.seed, orders: AskedOrders::default(), ..run.clone() };
    let reference = Reference { passes: size.reference_passes, bounces: run.bounces };
    let setup = bench.setup(&other_seed)?;
    let reference = bench.measure(&setup, reference)?;
    let setup = bench.setup(&run)?;
    let passes = || vec![0; size.passes as usize];
    let sorted = || Sorted { ways_ns: [passes(), passes()], trial_ns: [0; 2] };
    let work = Pictures {
        bench,
        setup: &setup,
        seed: run.seed,
        reference,
        shared_ns: passes(),
        unsorted_ns: passes(),
        methods: setup.methods.iter().map(|_| sorted()).collect(),
        noise: Vec::new(),
    };
    bench.measure(&setup, work)
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

impl OnBackend for Reference {
    type Output = Vec<[f32; 3]>;

    fn run<B: Backend>(self, backend: &mut B) -> Result<Vec<[f32; 3]>> {
        wavefront::run(backend, 0..self.passes, self.bounces, &mut ())?;
        picture(backend, self.passes)
    }
}

/// What passes took when traced in the order of a method, nanoseconds each, by [`Way::ALL`].
struct Sorted {
    ways_ns: [Vec<u64>; 2],
    /// The same over all passes, in the trial rounds, which no figure takes.
    trial_ns: [u64; 2],
}

struct Pictures<'a> {
    bench: Bench<'a>,
    setup: &'a Setup,
    seed: u64,
    reference: Vec<[f32; 3]>,
    /// Generating and shading of each pass, the same for all.
    shared_ns: Vec<u64>,
    /// Traces in canonical order of each pass.
    unsorted_ns: Vec<u64>,
    methods: Vec<Sorted>,
    /// Relative mean squared error after each pass.
    noise: Vec<f64>,
}

impl OnBackend for Pictures<'_> {
    type Output = Vec<ImageRow>;

    fn run<B: Backend>(mut self, backend: &mut B) -> Result<Vec<ImageRow>> {
        let passes = self.bench.options.image.passes;
        wavefront::run(backend, 0..passes, self.bench.options.run.bounces, &mut self)?;
        self.look(backend)?;
        Ok(self.rows())
    }
}

impl<B: Backend> Observer<B> for Pictures<'_> {
    fn measure(&mut self, backend: &mut B, rays: &B::Rays, hits: &B::Hits) -> Result<()> {
        let id = rays.id();
        let is_camera = id.bounce == 0 && id.kind == Kind::Closest;
        if is_camera && id.pass > 0 {
            self.look(backend)?;
        }
        let sorted = (0..self.setup.methods.len()).filter(|_| !is_camera).map(Subject::Method);
        let orders = [Subject::Unsorted].into_iter().chain(sorted).collect();
        let measured = Measured { orders, repeats: 1, seed: self.seed };
        let queue = Queued { rays, hits, methods: &self.setup.methods, foreign: &[], auto: None };
        let orders = queue.warm_up(backend, &measured, |_, _, _, _| Ok(()))?;
        let found = queue.measure(backend, &measured, &orders)?;
        let trace_ns = found.first().map_or(0, |unsorted| unsorted.stages.of(Stage::Trace).iter().sum());
        let pass = id.pass as usize;
        self.unsorted_ns[pass] += trace_ns;
        for (number, method) in self.methods.iter_mut().enumerate() {
            let sorted = found.iter().find(|entry| entry.subject == Subject::Method(number));
            for (at, way) in Way::ALL.into_iter().enumerate() {
                // What is not sorted is traced in canonical order.
                let ns = sorted.map_or(trace_ns, |entry| entry.stages.totals(way).iter().sum());
                method.ways_ns[at][pass] += ns;
                method.trial_ns[at] += sorted.map_or(0, |entry| entry.trial_ns[at]);
            }
        }
        Ok(())
    }

    fn ran(&mut self, backend: &B, _: Stage, rays: &B::Rays) -> Result<()> {
        self.shared_ns[rays.id().pass as usize] += backend.elapsed_ns();
        Ok(())
    }
}

impl Pictures<'_> {
    /// Keeps the noise after one pass more.
    fn look<B: Backend>(&mut self, backend: &mut B) -> Result<()> {
        let passes = self.noise.len() as u32 + 1;
        self.noise.push(relative_mse(&picture(backend, passes)?, &self.reference));
        Ok(())
    }

    /// What every method has taken after so many passes; a renderer settles on one way to trace.
    fn rows(&self) -> Vec<ImageRow> {
        let whole = |traced_ns: &[u64]| -> Vec<u64> {
            self.shared_ns.iter().zip(traced_ns).map(|(&shared, &traced)| shared + traced).collect()
        };
        let unsorted = whole(&self.unsorted_ns);
        let sorted = |Sorted { ways_ns, trial_ns: [gathered, indices] }: &Sorted| {
            whole(&ways_ns[usize::from(indices < gathered)])
        };
        let sorted: Vec<Vec<u64>> = self.methods.iter().map(sorted).collect();
        let mut rows = Vec::new();
        for (passes, &relative_mse) in (1..).zip(&self.noise) {
            let row = |method: &str, wall_ns: &[u64], speedup| ImageRow {
                scene: self.bench.scene.name.clone(),
                method: method.to_owned(),
                width: self.setup.width,
                height: self.setup.height,
                passes: passes as u32,
                wall_ns: wall_ns.iter().sum(),
                speedup,
                relative_mse,
                reference_passes: self.bench.options.image.reference_passes,
            };
            let unsorted = &unsorted[..passes];
            rows.push(row(UNSORTED, unsorted, None));
            for (plan, sorted) in self.setup.methods.iter().zip(&sorted) {
                let sorted = &sorted[..passes];
                rows.push(row(&plan.name, sorted, Speedup::of(unsorted, sorted)));
            }
        }
        rows
    }
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
