//! `recorder bench instrument`.

use std::collections::BTreeMap;

use clap::Args;
use comfy_table::Table;
use formats::bench_result::InstrumentRow;
use formats::metrics::speedup::geometric_mean;
use formats::ray::Kind;

use super::table_of;
use crate::bench::instrument::InstrumentBench;
use crate::options::{DeviceOptions, OptionError, RecordOptions, in_range};

#[derive(Debug, Args)]
pub(super) struct InstrumentArguments {
    /// .gltf or .glb files, or builtin:NAME.
    #[arg(default_value = "builtin:atrium")]
    scenes: Vec<String>,
    /// Picture width in pixels.
    #[arg(long, default_value_t = 640)]
    width: u32,
    /// Picture height in pixels.
    #[arg(long, default_value_t = 360)]
    height: u32,
    /// Bounces to trace.
    #[arg(long, default_value_t = 5)]
    bounces: u32,
    /// Queues to measure of each scene, at least: as many passes as that takes.
    #[arg(long, default_value_t = 100)]
    experiments: u32,
    /// Timed repeats.
    #[arg(long, default_value_t = 15)]
    repeats: u32,
    /// Camera by name; each scene's first if not given.
    #[arg(long)]
    camera: Option<String>,
    #[command(flatten)]
    device: DeviceOptions,
}

impl InstrumentArguments {
    pub(super) fn bench(&self) -> Result<InstrumentBench, OptionError> {
        in_range("experiments", self.experiments, 1, 10_000)?;
        let run = RecordOptions {
            width: self.width,
            height: self.height,
            bounces: self.bounces,
            repeats: self.repeats,
            camera: self.camera.clone(),
            device: self.device.clone(),
            ..RecordOptions::base()?
        };
        run.check()?;
        Ok(InstrumentBench { scenes: self.scenes.clone(), experiments: self.experiments, run })
    }
}

/// A line for the queues of each bounce and kind.
pub(super) fn table(rows: &[InstrumentRow]) -> Table {
    let mut table =
        table_of("scene | bounce | kind | queues | rays | control | from | to | hold 1 | shuffled");
    let mut groups: BTreeMap<(&str, u32, Kind), Vec<&InstrumentRow>> = BTreeMap::new();
    for row in rows {
        groups.entry((&row.scene, row.bounce, row.kind)).or_default().push(row);
    }
    for ((scene, bounce, kind), rows) in groups {
        let mean = |ratios: &mut dyn Iterator<Item = f64>| {
            geometric_mean(ratios).map_or(String::new(), |mean| format!("{mean:.3}"))
        };
        let ratios = || rows.iter().map(|row| row.control.ratio);
        let rays: u64 = rows.iter().map(|row| row.rays).sum();
        let holds_one = |&(low, high): &(f64, f64)| (low..=high).contains(&1.0);
        let holds = rows.iter().filter_map(|row| row.control.interval).filter(holds_one).count();
        table.add_row([
            scene.to_owned(),
            bounce.to_string(),
            kind.to_string(),
            rows.len().to_string(),
            (rays / rows.len() as u64).to_string(),
            mean(&mut ratios()),
            format!("{:.3}", ratios().fold(f64::INFINITY, f64::min)),
            format!("{:.3}", ratios().fold(0.0, f64::max)),
            holds.to_string(),
            mean(&mut rows.iter().map(|row| row.shuffled.ratio)),
        ]);
    }
    table
}
