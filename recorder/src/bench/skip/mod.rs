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
use formats::bench_result::skip::{Cost, SkipRow};
use formats::bench_result::{BenchResult, Rows};
use scenes::Scene;

use super::{Runs, result};
use crate::machine::{self, Device};
use crate::options::RecordOptions;
use crate::recording::prepared;
use crate::stages::setup::Setup;

/// One scene on one device.
#[derive(Clone, Copy)]
struct Bench<'a> {
    run: &'a RecordOptions,
    device: &'a Device,
    scene: &'a Scene,
    setup: &'a Arc<Setup>,
}

/// Measures everything that is skipped; methods are of no interest.
///
/// # Errors
/// One sentence on what went wrong with scene, device or disk.
pub fn run(options: &Runs) -> Result<BenchResult> {
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
            skipped: Cost::default(),
            done: Cost::default(),
            same: same.to_owned(),
            is_same: true,
        }
    }
}
