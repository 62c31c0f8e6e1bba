//! `recorder bench render`.

use clap::Args;
use comfy_table::Table;
use formats::bench_result::RenderRow;
use formats::key::method::CONTROL;
use formats::metrics::speedup::{Speedup, median};

use super::{milliseconds, table_of};
use crate::bench::Runs;
use crate::options::{DeviceOptions, OptionError, RecordOptions, parse_orders};
use crate::report::speedup;

#[derive(Debug, Args)]
pub(super) struct RenderArguments {
    /// .gltf or .glb files, or builtin:NAME.
    #[arg(default_value = "builtin:atrium")]
    scenes: Vec<String>,
    /// Methods to render with, `all` or a list such as aila,two-point; those that need the length of a ray
    /// before it is traced are left out.
    #[arg(
        long,
        default_value = "origin,aila,octahedron,two-point,two-point-adaptive,light-octahedron,auto",
        value_name = "LIST"
    )]
    methods: String,
    /// Picture width in pixels.
    #[arg(long, default_value_t = 640)]
    width: u32,
    /// Picture height in pixels.
    #[arg(long, default_value_t = 360)]
    height: u32,
    /// Bounces to trace.
    #[arg(long, default_value_t = 5)]
    bounces: u32,
    /// Samples per pixel of a frame, whose length tables begin empty.
    #[arg(long, default_value_t = 2)]
    passes: u32,
    /// Timed frames of each order.
    #[arg(long, default_value_t = 9)]
    repeats: u32,
    /// Seed of all random numbers.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Bits of a key, 8 to 64.
    #[arg(long, default_value_t = 32)]
    key_bits: u32,
    /// Camera by name; each scene's first if not given.
    #[arg(long)]
    camera: Option<String>,
    #[command(flatten)]
    device: DeviceOptions,
}

impl RenderArguments {
    pub(super) fn bench(&self) -> Result<Runs, OptionError> {
        let orders = parse_orders(&self.methods, &[])?;
        if orders.shuffled {
            let message = "a renderer has no reason to trace in a random order; leave out shuffled";
            return Err(OptionError::conflict(message));
        }
        let run = RecordOptions {
            width: self.width,
            height: self.height,
            bounces: self.bounces,
            passes: self.passes,
            repeats: self.repeats,
            seed: self.seed,
            camera: self.camera.clone(),
            orders,
            key_bits: self.key_bits,
            device: self.device.clone(),
            ..RecordOptions::base()?
        };
        run.check()?;
        Ok(Runs { scenes: self.scenes.clone(), run })
    }
}

pub(super) fn table(rows: &[RenderRow]) -> Table {
    let mut table = table_of(
        "scene | order | frame ms | tracing | reordering | shading | faster than unsorted | sorting | \
         shading alone | materials, branches of 32",
    );
    for row in rows {
        let share = |part_ns: Option<f64>| match (part_ns, median(&row.frame_ns)) {
            (Some(part_ns), Some(frame_ns)) => format!("{:.0} %", part_ns / frame_ns.max(1.0) * 100.0),
            _ => String::new(),
        };
        let shading: Vec<u64> = row.shade_ns().collect();
        table.add_row([
            row.scene.clone(),
            row.method.clone(),
            milliseconds(&row.frame_ns),
            share(median(&row.trace_ns)),
            share(median(&row.reorder_ns)),
            share(median(&shading)),
            speedup(row.speedup),
            row.speedup.filter(|_| row.method != CONTROL).map_or("", verdict).to_owned(),
            speedup(row.shade_speedup),
            row.coherence.map_or(String::new(), |of| format!("{:.1}, {:.1}", of.materials, of.branches)),
        ]);
    }
    table
}

/// What an interval says of paying for an order.
fn verdict(speedup: Speedup) -> &'static str {
    match speedup.interval {
        Some((low, _)) if low > 1.0 => "pays",
        Some((_, high)) if high < 1.0 => "does not pay",
        _ => "not shown",
    }
}
