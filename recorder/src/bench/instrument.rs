//! What the instrument misses by: orders whose speedup is known, measured like any method (A/A).

use anyhow::{Context, Result};
use formats::bench_result::{BenchResult, InstrumentRow, Rows};
use formats::manifest::Stage;
use formats::metrics::speedup::{Instrument, Speedup};
use scenes::Scene;

use super::backends::{self, OnBackend};
use super::result;
use crate::backends::{Backend, Queue};
use crate::machine;
use crate::measure::{Measured, QueueMeasurement, Queued, Subject};
use crate::options::RecordOptions;
use crate::recording::prepared;
use crate::wavefront;

/// What to measure.
#[derive(Clone, Debug)]
pub struct InstrumentBench {
    /// Scenes, files or built-in names.
    pub scenes: Vec<String>,
    /// Queues to measure of each, at least.
    pub experiments: u32,
    /// Size of the run and device.
    pub run: RecordOptions,
}

/// Measures the control and a random order on every queue of as many passes as it takes.
///
/// # Errors
/// One sentence on what went wrong with scene or device.
pub fn run(bench: &InstrumentBench) -> Result<BenchResult> {
    let device = machine::open(&bench.run.device)?;
    let mut rows = Vec::new();
    for name in &bench.scenes {
        let scene = scenes::load(name)?;
        let setup = prepared(&device, &scene, &bench.run)?;
        let paths = OverPaths { bench, scene: &scene };
        rows.extend(backends::measure(&device, &scene, &setup, device.kernel(&bench.run.device), paths)?);
    }
    let instrument = Instrument::of(rows.iter().map(|row| row.control));
    Ok(BenchResult { instrument, ..result(&device, Rows::Instrument(rows)) })
}

struct OverPaths<'a> {
    bench: &'a InstrumentBench,
    scene: &'a Scene,
}

impl OnBackend for OverPaths<'_> {
    type Output = Vec<InstrumentRow>;

    fn run<B: Backend>(self, backend: &mut B) -> Result<Vec<InstrumentRow>> {
        let run = &self.bench.run;
        let mut queues: u32 = 0;
        let mut count = |_: &mut B, _: &B::Rays, _: &B::Hits| {
            queues += 1;
            Ok(())
        };
        wavefront::run(backend, 0..1, run.bounces, &mut count)?;
        let passes = self.bench.experiments.div_ceil(queues.max(1));
        let orders = vec![Subject::Unsorted, Subject::Control, Subject::Shuffled];
        let measured = Measured { orders, repeats: run.repeats, seed: run.seed };
        let mut rows = Vec::new();
        let mut experiment = |backend: &mut B, rays: &B::Rays, hits: &B::Hits| {
            let queue = Queued { rays, hits, methods: &[], foreign: &[], auto: None };
            let orders = queue.warm_up(backend, &measured, |_, _, _, _| Ok(()))?;
            let found = queue.measure(backend, &measured, &orders)?;
            let id = rays.id();
            rows.push(InstrumentRow {
                scene: self.scene.name.clone(),
                pass: id.pass,
                bounce: id.bounce,
                kind: id.kind,
                rays: rays.len() as u64,
                control: trace_speedup(&found, Subject::Control)?,
                shuffled: trace_speedup(&found, Subject::Shuffled)?,
            });
            Ok(())
        };
        wavefront::run(backend, 0..passes, run.bounces, &mut experiment)?;
        Ok(rows)
    }
}

/// Of gathered rays over canonical order.
fn trace_speedup(found: &QueueMeasurement, subject: Subject) -> Result<Speedup> {
    let samples = |wanted| {
        let entry = found.iter().find(|entry| entry.subject == wanted);
        entry.map_or(&[][..], |entry| entry.stages.of(Stage::Trace))
    };
    Speedup::of(samples(Subject::Unsorted), samples(subject)).context("nothing was measured")
}
