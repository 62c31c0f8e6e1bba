//! `recorder bench capture`.

use std::path::PathBuf;

use clap::Args;
use comfy_table::Table;
use formats::bench_result::CaptureRow;
use formats::metrics::speedup::{Speedup, median};

use super::{milliseconds, table_of};
use crate::bench::capture::CaptureBench;
use crate::options::{DeviceOptions, Keep, OptionError, RecordOptions, parse_methods};
use crate::report::speedup;

/// All arrays that a recording can keep without tracing its rays once more.
const KEPT: &str = "rays,hits,keys,permutations,lengths,scene,image";
/// What keeping everything may cost: so many times the longer of tracing and writing.
const COST_MAX: f64 = 1.15;

#[derive(Debug, Args)]
pub(super) struct CaptureArguments {
    /// .gltf or .glb files, or builtin:NAME.
    #[arg(default_value = "builtin:atrium")]
    scenes: Vec<String>,
    /// Folder on the disk to write to; what is written is removed again.
    #[arg(long, default_value = ".", value_name = "DIR")]
    folder: PathBuf,
    /// Methods to measure and keep keys and permutations of, `all` or a list. Without any there is only tracing
    /// to write beside.
    #[arg(long, default_value = "unsorted", value_name = "LIST")]
    methods: String,
    /// Picture width in pixels.
    #[arg(long, default_value_t = 960)]
    width: u32,
    /// Picture height in pixels.
    #[arg(long, default_value_t = 540)]
    height: u32,
    /// Bounces to trace.
    #[arg(long, default_value_t = 5)]
    bounces: u32,
    /// Timed repeats.
    #[arg(long, default_value_t = 7)]
    repeats: u32,
    /// Camera by name; each scene's first if not given.
    #[arg(long)]
    camera: Option<String>,
    /// Bits of a key, 8 to 64.
    #[arg(long, default_value_t = 32)]
    key_bits: u32,
    #[command(flatten)]
    device: DeviceOptions,
}

impl CaptureArguments {
    pub(super) fn bench(&self) -> Result<CaptureBench, OptionError> {
        let run = RecordOptions {
            width: self.width,
            height: self.height,
            bounces: self.bounces,
            repeats: self.repeats,
            camera: self.camera.clone(),
            orders: parse_methods(&self.methods, &[])?.into(),
            key_bits: self.key_bits,
            keep: Keep::parse(KEPT)?,
            device: self.device.clone(),
            ..RecordOptions::base()?
        };
        run.check()?;
        Ok(CaptureBench { scenes: self.scenes.clone(), folder: self.folder.clone(), run })
    }
}

pub(super) fn table(rows: &[CaptureRow]) -> Table {
    let mut table = table_of(
        "scene | rays | MB | nothing kept ms | everything kept ms | written alone ms | MB/s alone | \
         everything / larger | at most 1.15",
    );
    for row in rows {
        let rate = median(&row.alone_ns).map(|ns| row.bytes as f64 * 1e3 / ns.max(1.0));
        table.add_row([
            row.scene.clone(),
            row.rays.to_string(),
            format!("{:.1}", row.bytes as f64 / 1e6),
            milliseconds(&row.nothing_ns),
            milliseconds(&row.everything_ns),
            milliseconds(&row.alone_ns),
            rate.map_or(String::new(), |rate| format!("{rate:.0}")),
            speedup(Some(row.cost)),
            verdict(row.cost).to_owned(),
        ]);
    }
    table
}

/// What an interval says of the cost.
fn verdict(cost: Speedup) -> &'static str {
    match cost.interval {
        Some((_, high)) if high <= COST_MAX => "yes",
        Some((low, _)) if low > COST_MAX => "no",
        _ => "not shown",
    }
}
