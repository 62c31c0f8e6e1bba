//! What keeping everything costs: recordings with all arrays and with none, and the same bytes written alone.
//!
//! Tracing and writing overlap, so a recording can take no less than the longer of the two; what it takes beyond
//! that is the cost of capture. What comes before the first ray is the same for all and is not timed.

use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use anyhow::{Context, Result};
use formats::bench_result::{BenchResult, CaptureRow, Rows};
use formats::metrics::speedup::{Instrument, Speedup, median};
use formats::reader::Dump;
use formats::writer::WriteError;
use scenes::Scene;

use super::backends::{self, OnBackend};
use super::{folder_bytes, result};
use crate::backends::Backend;
use crate::capture::BUFFER_BYTES;
use crate::clock::Clock;
use crate::machine::{self, Device};
use crate::measure::sampled;
use crate::options::{Keep, RecordOptions};
use crate::output::say;
use crate::recording::{Run, prepared};
use crate::stages::setup::Setup;

/// What to measure.
#[derive(Clone, Debug)]
pub struct CaptureBench {
    /// Scenes, files or built-in names.
    pub scenes: Vec<String>,
    /// Where recordings and bytes are written, in a folder that is removed at the end.
    pub folder: PathBuf,
    /// Size of the run, methods, device, what is kept where everything is.
    pub run: RecordOptions,
}

/// Records each scene with and without its arrays, in rounds.
///
/// # Errors
/// One sentence on what went wrong with scene, device or disk.
pub fn run(bench: &CaptureBench) -> Result<BenchResult> {
    let device = machine::open(&bench.run.device)?;
    let folder = tempfile::Builder::new().prefix("bench-capture-").tempdir_in(&bench.folder);
    let folder = folder.with_context(|| format!("cannot make a folder in {}", bench.folder.display()))?;
    let (mut rows, mut controls) = (Vec::new(), Vec::new());
    for name in &bench.scenes {
        let out = folder.path().join("capture.raydump");
        let options = RecordOptions { scene: name.clone(), out, ..bench.run.clone() };
        let scene = scenes::load(name)?;
        let setup = prepared(&device, &scene, &options)?;
        say(&scene.name);
        let turns = Turns { device: &device, scene: &scene, setup: &setup, options: &options };
        let row = backends::measure(&device, &scene, &setup, device.kernel(&options.device), turns);
        let row = row.map_err(nothing_kept)?;
        controls.push(row.control);
        rows.push(row);
    }
    Ok(BenchResult { instrument: Instrument::of(controls), ..result(&device, Rows::Capture(rows)) })
}

/// What could be recovered goes with the folder.
fn nothing_kept(error: anyhow::Error) -> anyhow::Error {
    match error.downcast::<WriteError>() {
        Ok(error) => error.with_nothing_kept().into(),
        Err(error) => error,
    }
}

/// Recordings, and writing alone, that take turns in each round.
struct Turns<'a> {
    device: &'a Device,
    scene: &'a Scene,
    setup: &'a Arc<Setup>,
    options: &'a RecordOptions,
}

impl OnBackend for Turns<'_> {
    type Output = CaptureRow;

    fn run<B: Backend>(self, backend: &mut B) -> Result<CaptureRow> {
        let Self { setup, options, .. } = self;
        let mut clock = Clock::of_processor();
        // The first recording says how many bytes there are.
        let (rays, bytes) = self.record(backend, &mut clock, options.keep)?;
        let alone = options.out.with_extension("bytes");
        // Nothing kept, twice: what these times differ by is the clock's error; everything kept; its bytes alone.
        let samples = sampled(4, options.repeats, options.seed, |turn| {
            match turn {
                0 | 1 => drop(self.record(backend, &mut clock, Keep::default())?),
                2 => drop(self.record(backend, &mut clock, options.keep)?),
                _ => write_alone(&alone, bytes, &mut clock)?,
            }
            Ok(clock.last().elapsed_ns)
        })?;
        let [nothing_ns, control_ns, everything_ns, alone_ns] =
            <[Vec<u64>; 4]>::try_from(samples).ok().context("a turn has no samples")?;
        let larger = if median(&alone_ns) > median(&nothing_ns) { &alone_ns } else { &nothing_ns };
        Ok(CaptureRow {
            scene: self.scene.name.clone(),
            width: setup.width,
            height: setup.height,
            bounces: setup.bounces,
            methods: setup.methods.iter().map(|method| method.name.clone()).collect(),
            rays,
            bytes,
            cost: Speedup::of(&everything_ns, larger).context("nothing was measured")?,
            control: Speedup::of(&nothing_ns, &control_ns).context("nothing was measured")?,
            nothing_ns,
            everything_ns,
            alone_ns,
        })
    }
}

impl Turns<'_> {
    /// Rays of a recording and the bytes of its files, which are removed again; only the recording is timed.
    fn record<B: Backend>(&self, backend: &mut B, clock: &mut Clock, keep: Keep) -> Result<(u64, u64)> {
        let Self { device, scene, setup, .. } = *self;
        // The fewest rounds of measuring, beside which nothing is written.
        let options = &RecordOptions { keep, repeats: 1, ..self.options.clone() };
        // Of no interest here: the time that the recording itself will say.
        let start = Instant::now();
        let run = Run::of_paths(device, scene, Arc::clone(setup), options, Vec::new(), start);
        backend.restart()?;
        let (path, _) = clock.time(|| run.with(backend, None))?;
        let rays = Dump::open(&path)?.manifest().queues.iter().map(|queue| queue.rays).sum();
        let bytes = folder_bytes(&path)?;
        fs::remove_dir_all(&path).with_context(|| format!("cannot remove {}", path.display()))?;
        Ok((rays, bytes))
    }
}

/// Writes so many bytes to a file, brings them to the disk and removes it; the removal is not timed.
fn write_alone(path: &Path, bytes: u64, clock: &mut Clock) -> Result<()> {
    let mut piece = vec![0; BUFFER_BYTES];
    // Zeros are what some disks do not write.
    fastrand::Rng::with_seed(0).fill(&mut piece);
    let write = || {
        let mut file = File::create(path)?;
        let mut left = bytes;
        while left > 0 {
            let part = &piece[..left.min(BUFFER_BYTES as u64) as usize];
            file.write_all(part)?;
            left -= part.len() as u64;
        }
        file.sync_all()
    };
    clock.time(write).with_context(|| format!("cannot write {}", path.display()))?;
    fs::remove_file(path).with_context(|| format!("cannot remove {}", path.display()))
}
