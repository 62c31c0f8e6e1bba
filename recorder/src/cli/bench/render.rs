//! `recorder bench render`.

use clap::Args;
use comfy_table::Table;
use formats::bench_result::RenderRow;
use formats::key::method::CONTROL;
use formats::metrics::speedup::median;

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
        "scene | order | frame ms | faster than unsorted | sorting | tracing, reordering, shading | shading alone",
    );
    for row in rows {
        let shading: Vec<u64> = row.shade_ns().collect();
        let share = |part_ns: &[u64]| {
            let (part_ns, frame_ns) = (median(part_ns)?, median(&row.frame_ns)?);
            Some(format!("{:.0}", part_ns / frame_ns.max(1.0) * 100.0))
        };
        let shares: Option<Vec<String>> =
            [&row.trace_ns, &row.reorder_ns, &shading].map(|part_ns| share(part_ns)).into_iter().collect();
        // The control moves paths, which is no error of the clock.
        let net = row.speedup.filter(|_| row.method != CONTROL);
        table.add_row([
            row.scene.clone(),
            row.method.clone(),
            milliseconds(&row.frame_ns),
            speedup(row.speedup),
            net.map_or("", |net| net.verdict(0.0).on_sorting()).to_owned(),
            shares.map_or(String::new(), |shares| shares.join(", ") + " %"),
            speedup(row.shade_speedup),
        ]);
    }
    table
}
