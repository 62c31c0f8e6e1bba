//! `recorder bench error`.

use clap::Args;
use comfy_table::Table;
use formats::bench_result::error::{ErrorRows, EstimatorRow, ImageRow, KeyBitsRow, PrecisionRow};
use formats::key::{KEY_BITS_MIN, LAYOUT_BITS};

use super::{chosen, milliseconds, table_of};
use crate::bench::error::{Curve, ErrorBench, ImageSize};
use crate::bench::rate;
use crate::options::{DeviceOptions, OptionError, RecordOptions, in_range, parse_methods};
use crate::report::speedup;

#[derive(Debug, Args)]
pub(super) struct ErrorArguments {
    /// .gltf or .glb files, or builtin:NAME.
    #[arg(default_value = "builtin:atrium")]
    scenes: Vec<String>,
    /// Curves to measure; all of them if not given.
    #[arg(long, value_enum, value_delimiter = ',', value_name = "LIST")]
    only: Vec<Curve>,
    /// Most rays of a queue whose errors are looked at, spread evenly over it; for precision, of all of them.
    #[arg(long, default_value_t = 100_000)]
    rays: usize,
    /// Methods of the curves over key bits and over time, `all` or a list.
    #[arg(
        long,
        default_value = "origin,aila,octahedron,two-point,two-point-adaptive,light-octahedron",
        value_name = "LIST"
    )]
    methods: String,
    /// Bits of a key, 8 to 64.
    #[arg(long, value_delimiter = ',', default_value = "8,12,16,20,24,32,48,64")]
    key_bits: Vec<u32>,
    /// Width of the picture whose rays are used, pixels.
    #[arg(long, default_value_t = 480)]
    width: u32,
    /// Height of the picture whose rays are used, pixels.
    #[arg(long, default_value_t = 270)]
    height: u32,
    /// Bounces to trace.
    #[arg(long, default_value_t = 4)]
    bounces: u32,
    /// Width of the pictures of the curve over time, pixels.
    #[arg(long, default_value_t = 160)]
    image_width: u32,
    /// Height of these pictures, pixels.
    #[arg(long, default_value_t = 90)]
    image_height: u32,
    /// Samples per pixel at which they end.
    #[arg(long, default_value_t = 16)]
    image_passes: u32,
    /// Samples per pixel of the reference.
    #[arg(long, default_value_t = 256)]
    reference_passes: u32,
    /// Timed repeats.
    #[arg(long, default_value_t = 3)]
    repeats: u32,
    /// Seed of all random numbers; the reference has another one.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Camera by name; each scene's first if not given.
    #[arg(long)]
    camera: Option<String>,
    #[command(flatten)]
    device: DeviceOptions,
}

impl ErrorArguments {
    pub(super) fn bench(&self) -> Result<ErrorBench, OptionError> {
        for &bits in &self.key_bits {
            in_range("key-bits", bits, KEY_BITS_MIN, LAYOUT_BITS)?;
        }
        in_range("rays", self.rays, 1, 1 << 28)?;
        in_range("image-passes", self.image_passes, 1, 1 << 16)?;
        in_range("reference-passes", self.reference_passes, 1, 1 << 16)?;
        let run = RecordOptions {
            width: self.width,
            height: self.height,
            bounces: self.bounces,
            repeats: self.repeats,
            seed: self.seed,
            camera: self.camera.clone(),
            orders: parse_methods(&self.methods, &[])?.into(),
            device: self.device.clone(),
            ..RecordOptions::base()?
        };
        run.check()?;
        RecordOptions { width: self.image_width, height: self.image_height, ..run.clone() }.check()?;
        let mut key_bits = self.key_bits.clone();
        key_bits.sort_unstable();
        key_bits.dedup();
        let image = ImageSize {
            width: self.image_width,
            height: self.image_height,
            passes: self.image_passes,
            reference_passes: self.reference_passes,
        };
        let (scenes, curves) = (self.scenes.clone(), chosen(&self.only));
        Ok(ErrorBench { scenes, curves, rays: self.rays, key_bits, image, run })
    }
}

/// One table per curve that was measured.
pub(super) fn tables(rows: &ErrorRows) -> Vec<Table> {
    let tables = [
        precision(&rows.precision),
        estimator(&rows.estimator),
        key_bits(&rows.key_bits),
        image(&rows.image),
    ];
    tables.into_iter().filter(|table| !table.is_empty()).collect()
}

fn mega_per_second(items: u64, samples_ns: &[u64], digits: usize) -> String {
    rate(items, samples_ns).map_or(String::new(), |(rate, spread)| format!("{rate:.digits$} ±{spread:.0} %"))
}

fn precision(rows: &[PrecisionRow]) -> Table {
    let mut table = table_of(
        "scene | kernel | triangle test | box test | Mrays/s | rays | missed | false | \
         wrong triangle | tied | t error, relative: median, 99.9 %, max | \
         ulp: median, 99.9 %, max",
    );
    for row in rows {
        let (relative, ulp) = (row.errors.relative, row.errors.ulp);
        table.add_row([
            row.scene.clone(),
            row.kernel.clone(),
            row.triangle_test.clone(),
            row.box_test.clone(),
            mega_per_second(row.rays_timed, &row.samples_ns, 2),
            row.errors.rays.to_string(),
            row.errors.missed.to_string(),
            row.errors.false_hits.to_string(),
            row.errors.wrong_triangles.to_string(),
            row.errors.tied.to_string(),
            format!("{:.1e}, {:.1e}, {:.1e}", relative.median, relative.p999, relative.max),
            format!("{:.2}, {:.1}, {:.0}", ulp.median, ulp.p999, ulp.max),
        ]);
    }
    table
}

fn estimator(rows: &[EstimatorRow]) -> Table {
    let mut table = table_of(
        "scene | kind | table method | bits | pass | cells touched | mean error | \
         median error | accumulate Mrays/s | key Mrays/s",
    );
    for row in rows.iter().filter(|row| row.rays_timed > 0 || (row.table_bits == 20 && row.pass < 8)) {
        table.add_row([
            row.scene.clone(),
            row.kind.to_string(),
            row.table_method.clone(),
            if row.table_bits > 0 { row.table_bits.to_string() } else { String::new() },
            row.pass.to_string(),
            row.cells_touched.to_string(),
            format!("{:.4}", row.error.mean_absolute),
            format!("{:.4}", row.error.median_absolute),
            mega_per_second(row.rays_timed, &row.accumulate_ns, 1),
            mega_per_second(row.rays_timed, &row.key_ns, 1),
        ]);
    }
    table
}

fn key_bits(rows: &[KeyBitsRow]) -> Table {
    let mut table = table_of(
        "scene | bounce | kind | rays | method | bits | key ms | sort ms | capsule area | \
         trace ms",
    );
    for row in rows {
        table.add_row([
            row.scene.clone(),
            row.bounce.to_string(),
            row.kind.to_string(),
            row.rays.to_string(),
            row.method.clone(),
            if row.key_bits > 0 { row.key_bits.to_string() } else { String::new() },
            milliseconds(&row.key_ns),
            milliseconds(&row.sort_ns),
            format!("{:.4}", row.capsule_area),
            milliseconds(&row.trace_ns),
        ]);
    }
    table
}

/// The last picture of each scene and method; the ones before are in the JSON.
fn image(rows: &[ImageRow]) -> Table {
    let mut table = table_of("scene | method | samples | ms | relative MSE | times faster than unsorted");
    for row in rows {
        let of_scene = || rows.iter().filter(|other| other.scene == row.scene);
        if of_scene().any(|other| other.passes > row.passes) {
            continue;
        }
        table.add_row([
            row.scene.clone(),
            row.method.clone(),
            row.passes.to_string(),
            format!("{:.1}", row.wall_ns as f64 / 1e6),
            format!("{:.5}", row.relative_mse),
            speedup(row.speedup),
        ]);
    }
    table
}
