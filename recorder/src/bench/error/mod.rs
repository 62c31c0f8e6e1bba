//! Run time against error: what precision, estimates, key bits and sorting cost, and what they buy.
//!
//! - [`precision`]: trace rate against lost and wrong hits
//! - [`estimator`]: cost of the length table against the error of its estimates
//! - `table_costs`: the costs of that
//! - [`key_bits`]: key and sort time against capsule area and trace time
//! - [`image`]: the time of all stages against the noise of the picture

pub mod estimator;
pub mod image;
pub mod key_bits;
pub mod precision;
mod table_costs;

use std::sync::Arc;

use anyhow::Result;
use formats::bench_result::error::ErrorRows;
use formats::bench_result::{BenchResult, Rows};
use formats::unit_space::UnitSpace;
use scenes::Scene;

use super::backends::{self, OnBackend};
use super::result;
use crate::machine::{self, Device};
use crate::options::RecordOptions;
use crate::output::{say, typed};
use crate::recording::prepared;
use crate::stages::setup::Setup;

/// A curve of run time against error.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Curve {
    /// Trace rate against lost and wrong hits, by kernel, triangle test and box test.
    Precision,
    /// Cost of the length table against the error of its estimates, beside a constant length.
    Estimator,
    /// Key and sort time against capsule area and trace time.
    KeyBits,
    /// Wall time against the noise of the picture.
    Image,
}

/// What to measure: scenes one after the other.
#[derive(Clone, Debug)]
pub struct ErrorBench {
    /// Scenes, files or built-in names.
    pub scenes: Vec<String>,
    /// Curves.
    pub curves: Vec<Curve>,
    /// Most rays of a queue whose errors are looked at, and of all secondary rays for precision.
    pub rays: usize,
    /// Key bits of the curve over them.
    pub key_bits: Vec<u32>,
    /// Pictures of the curve over time.
    pub image: ImageSize,
    /// Size of the run that makes the rays, methods, device; what is to be kept is of no interest.
    pub run: RecordOptions,
}

/// Pictures that are compared with a reference.
#[derive(Clone, Copy, Debug)]
pub struct ImageSize {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Samples per pixel at most.
    pub passes: u32,
    /// Samples per pixel of the reference.
    pub reference_passes: u32,
}

/// One scene on one device.
#[derive(Clone, Copy)]
struct Bench<'a> {
    options: &'a ErrorBench,
    device: &'a Device,
    scene: &'a Scene,
}

/// Measures every curve that is asked for.
///
/// # Errors
/// One sentence on what went wrong with scene or device.
pub fn run(options: &ErrorBench) -> Result<BenchResult> {
    let device = machine::open(&options.run.device)?;
    let mut rows = ErrorRows::default();
    for name in &options.scenes {
        let scene = scenes::load(name)?;
        let bench = Bench { options, device: &device, scene: &scene };
        for curve in &options.curves {
            say(format_args!("{}: {}", scene.name, typed(curve)));
            match curve {
                Curve::Precision => rows.precision.extend(precision::run(bench)?),
                Curve::Estimator => rows.estimator.extend(estimator::run(bench)?),
                Curve::KeyBits => rows.key_bits.extend(key_bits::run(bench)?),
                Curve::Image => rows.image.extend(image::run(bench)?),
            }
        }
    }
    Ok(result(&device, Rows::Error(Box::new(rows))))
}

impl Bench<'_> {
    fn setup(&self, run: &RecordOptions) -> Result<Arc<Setup>> {
        prepared(self.device, self.scene, run)
    }

    /// Runs a measurement with the kernel that was asked for.
    fn measure<M: OnBackend + Send>(&self, setup: &Arc<Setup>, measurement: M) -> Result<M::Output> {
        let kernel = self.device.kernel(&self.options.run.device);
        backends::measure(self.device, self.scene, setup, kernel, measurement)
    }

    fn unit(&self) -> UnitSpace {
        let bounds = self.scene.bounds();
        UnitSpace::from_bounds(bounds.min, bounds.max)
    }
}
