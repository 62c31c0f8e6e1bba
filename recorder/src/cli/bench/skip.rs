//! `recorder bench skip` and `recorder bench startup`.

use clap::Args;
use comfy_table::Table;
use formats::bench_result::skip::{SkipRow, StartupRow};
use formats::metrics::speedup::Speedup;

use super::{milliseconds, table_of};
use crate::bench::Runs;
use crate::options::{DeviceOptions, OptionError, RecordOptions};
use crate::report::speedup;

#[derive(Debug, Args)]
pub(super) struct SkipArguments {
    /// .gltf or .glb files, or builtin:NAME.
    #[arg(default_values = ["builtin:cornell", "builtin:apartment"])]
    scenes: Vec<String>,
    /// Picture width in pixels.
    #[arg(long, default_value_t = 320)]
    width: u32,
    /// Picture height in pixels.
    #[arg(long, default_value_t = 180)]
    height: u32,
    /// Bounces to trace.
    #[arg(long, default_value_t = 4)]
    bounces: u32,
    /// Timed repeats.
    #[arg(long, default_value_t = 7)]
    repeats: u32,
    /// Camera by name; each scene's first if not given.
    #[arg(long)]
    camera: Option<String>,
    #[command(flatten)]
    device: DeviceOptions,
}

impl SkipArguments {
    pub(super) fn bench(&self) -> Result<Runs, OptionError> {
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
        Ok(Runs { scenes: self.scenes.clone(), run })
    }
}

pub(super) fn skip_table(rows: &[SkipRow]) -> Table {
    let mut table = table_of(
        "scene | skipped | time and bytes of | skipped ms | done ms | done / skipped | \
         skipped bytes | done bytes | same",
    );
    for row in rows {
        table.add_row([
            row.scene.clone(),
            row.what.clone(),
            row.of.clone(),
            milliseconds(&row.skipped.samples_ns),
            milliseconds(&row.done.samples_ns),
            speedup(Speedup::of(&row.done.samples_ns, &row.skipped.samples_ns)),
            bytes(row.skipped.bytes),
            bytes(row.done.bytes),
            format!("{}{}", row.same, if row.is_same { "" } else { ": DIFFERS" }),
        ]);
    }
    table
}

fn bytes(bytes: u64) -> String {
    if bytes == 0 { String::new() } else { bytes.to_string() }
}

pub(super) fn startup_table(rows: &[StartupRow]) -> Table {
    let mut table = table_of("scene | triangles | kernel | step | ms");
    for row in rows {
        table.add_row([
            row.scene.clone(),
            row.triangles.to_string(),
            row.kernel.clone(),
            row.step.clone(),
            milliseconds(&row.samples_ns),
        ]);
    }
    table
}
