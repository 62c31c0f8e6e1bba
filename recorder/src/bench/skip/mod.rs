//! What skipping saves: each thing that is left out where it is not needed, as it is and turned on, with
//! proof that nothing else changes.
//!
//! - `features`: what a scene does not have, in shading and tracing
//! - `queues`: empty bounces, constant digits, keys of the unsorted order, untouched cells
//! - `files`: arrays and passes that nobody asked for, hierarchies that are there already

mod features;
mod files;
mod queues;

use std::sync::Arc;

use anyhow::Result;
use formats::bench_result::skip::SkipRow;
use formats::bench_result::{BenchResult, Rows};
use scenes::Scene;

use super::result;
use crate::machine::{self, Device};
use crate::options::RecordOptions;
use crate::recording::prepared;
use crate::stages::setup::Setup;

/// What to measure: scenes one after the other.
#[derive(Clone, Debug)]
pub struct SkipBench {
    /// Scenes, files or built-in names.
    pub scenes: Vec<String>,
    /// Size of the runs, device; methods and what is to be kept are of no interest.
    pub run: RecordOptions,
}

/// One scene on one device.
#[derive(Clone, Copy)]
struct Bench<'a> {
    run: &'a RecordOptions,
    device: &'a Device,
    scene: &'a Scene,
    setup: &'a Arc<Setup>,
}

/// Measures everything that is skipped.
///
/// # Errors
/// One sentence on what went wrong with scene, device or disk.
pub fn run(options: &SkipBench) -> Result<BenchResult> {
    let device = machine::open(&options.run.device)?;
    let mut rows = Vec::new();
    for name in &options.scenes {
        let run = RecordOptions { scene: name.clone(), ..options.run.clone() };
        let scene = scenes::load(name)?;
        let setup = prepared(&device, &scene, &run)?;
        let bench = Bench { run: &run, device: &device, scene: &scene, setup: &setup };
        for part in [features::rows, queues::rows, files::rows] {
            rows.extend(part(bench)?);
        }
    }
    Ok(result(&device, Rows::Skip(rows)))
}

impl Bench<'_> {
    /// A row without its costs; what is compared is the same until it is found not to be.
    fn row(&self, what: &str, of: &str, same: &str) -> SkipRow {
        SkipRow {
            scene: self.scene.name.clone(),
            what: what.to_owned(),
            of: of.to_owned(),
            skipped: formats::bench_result::skip::Cost::default(),
            done: formats::bench_result::skip::Cost::default(),
            same: same.to_owned(),
            is_same: true,
        }
    }
}
