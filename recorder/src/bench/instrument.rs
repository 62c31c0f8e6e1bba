//! What the instrument misses by: orders whose speedup is known, measured like any method (A/A).

use anyhow::{Context, Result};
use formats::bench_result::{BenchResult, InstrumentRow, Rows};
use formats::manifest::Stage;
use formats::metrics::speedup::{Instrument, Speedup};
use scenes::Scene;

use super::backends::{self, OnBackends};
use super::result;
use crate::backends::{Backend, Queue};
use crate::machine;
use crate::measure::{Measured, QueueMeasurement, Queued, Subject};
use crate::options::RecordOptions;
use crate::recording::prepared;
use crate::wavefront::{self, Observer};

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
        rows.extend(backends::measure(&device, &scene, &setup, &[device.kernel(&bench.run.device)], paths)?);
    }
    let instrument = Instrument::of(rows.iter().map(|row| row.control));
    Ok(BenchResult { instrument, ..result(&device, Rows::Instrument(rows)) })
}

struct OverPaths<'a> {
    bench: &'a InstrumentBench,
    scene: &'a Scene,
}

impl OnBackends for OverPaths<'_> {
    type Output = Vec<InstrumentRow>;

    fn run<B: Backend>(self, mut backends: Vec<B>) -> Result<Vec<InstrumentRow>> {
        let backend = backends.first_mut().context("there is no backend")?;
        let run = &self.bench.run;
        let mut counted = Counted(0);
        wavefront::run(backend, 0..1, run.bounces, &mut counted)?;
        let passes = self.bench.experiments.div_ceil(counted.0.max(1));
        let mut experiments = Experiments {
            scene: self.scene,
            measured: Measured {
                orders: vec![Subject::Unsorted, Subject::Control, Subject::Shuffled],
                repeats: run.repeats,
                seed: run.seed,
            },
            rows: Vec::new(),
        };
        wavefront::run(backend, 0..passes, run.bounces, &mut experiments)?;
        Ok(experiments.rows)
    }
}

/// How many queues a pass has.
struct Counted(u32);

impl<B: Backend> Observer<B> for Counted {
    fn measure(&mut self, _: &mut B, _: &B::Rays, _: &B::Hits) -> Result<()> {
        self.0 += 1;
        Ok(())
    }
}

struct Experiments<'a> {
    scene: &'a Scene,
    measured: Measured,
    rows: Vec<InstrumentRow>,
}

impl<B: Backend> Observer<B> for Experiments<'_> {
    fn measure(&mut self, backend: &mut B, rays: &B::Rays, hits: &B::Hits) -> Result<()> {
        let queue = Queued { rays, hits, methods: &[], foreign: &[], auto: None };
        let orders = queue.warm_up(backend, &self.measured, |_, _, _, _| Ok(()))?;
        let found = queue.measure(backend, &self.measured, &orders)?;
        let (id, count) = (rays.id(), rays.len() as u64);
        self.rows.push(InstrumentRow {
            scene: self.scene.name.clone(),
            pass: id.pass,
            bounce: id.bounce,
            kind: id.kind,
            rays: count,
            control: trace_speedup(&found, Subject::Control)?,
            shuffled: trace_speedup(&found, Subject::Shuffled)?,
        });
        Ok(())
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
