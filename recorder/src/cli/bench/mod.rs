//! `recorder bench`: one file per benchmark with many options.

mod capture;
mod error;
mod growth;
mod instrument;
mod render;
mod skip;

use anyhow::Result;
use clap::{Args, Subcommand, ValueEnum};
use comfy_table::Table;
use comfy_table::presets::UTF8_BORDERS_ONLY;
use formats::bench_result::{BenchResult, Rows};

use crate::output::{print, print_json};
use formats::key::{KEY_BITS_MIN, LAYOUT_BITS};
use formats::metrics::speedup::median;

use crate::bench::rate;
use crate::bench::sort::{self, SortBench};
use crate::bench::trace::{self, TraceBench};
use crate::options::{DeviceOptions, OptionError, RecordOptions, in_range, parse_methods};
use crate::report::instrument_line;
use crate::stages::sort::COUNT_BITS;
use crate::stages::trace::TraceKernel;
use capture::CaptureArguments;
use error::ErrorArguments;
use growth::GrowthArguments;
use instrument::InstrumentArguments;
use render::RenderArguments;
use skip::SkipArguments;

pub(super) const EXAMPLES: &str = "\
Examples:
  recorder bench sort
  recorder bench sort --backend cpu --threads 1 --key-bits 16,32 --json > sort.json
  recorder bench trace builtin:atrium sponza.glb --methods two-point,costa --json > trace.json
  recorder bench error sponza.glb --json > error.json
  recorder bench error builtin:atrium --only image --methods two-point,costa --image-passes 32
  recorder bench skip builtin:cornell builtin:apartment
  recorder bench render builtin:atrium sponza.glb --methods aila,two-point
  recorder bench capture scene.glb --folder /data/recordings
  recorder bench growth --only triangles --triangles 1000,10000,100000 --json > growth.json
  recorder bench startup scene.glb --backend gpu
  recorder bench instrument builtin:atrium --backend cpu --pin --json > instrument.json
  inspector plot sort.json trace.json error.json --out figures/";

#[derive(Debug, Args)]
pub(super) struct BenchArguments {
    #[command(subcommand)]
    what: What,
    /// Print the results as one JSON object on stdout.
    #[arg(long, global = true)]
    json: bool,
}

#[derive(Debug, Subcommand)]
enum What {
    /// Sort throughput over the number of keys and their bits.
    Sort(SortArguments),
    /// Trace rate per scene, kernel, bounce, kind and order.
    Trace(Box<TraceArguments>),
    /// Run time against error: triangle and box tests, length tables, key bits, pictures.
    Error(Box<ErrorArguments>),
    /// What skipping saves: time, memory and bytes of each thing that is left out, on and off.
    Skip(Box<SkipArguments>),
    /// What the clock misses by: orders whose speedup is known, on every queue.
    Instrument(Box<InstrumentArguments>),
    /// Frames as a renderer makes them that keeps to one order: what sorting costs and buys from end to end.
    Render(Box<RenderArguments>),
    /// What keeping everything costs, beside tracing alone and beside writing the same bytes alone.
    Capture(Box<CaptureArguments>),
    /// How time and memory grow with triangles, rays, bounces, lights and threads, as exponents.
    Growth(Box<GrowthArguments>),
    /// What happens before the first ray: reading the scene, hierarchy, upload, pipelines.
    Startup(Box<SkipArguments>),
}

#[derive(Debug, Args)]
struct SortArguments {
    /// Numbers of keys, as powers of two, 0 to 29.
    #[arg(long, value_delimiter = ',', default_value = "10,12,14,16,18,20,21,22,24")]
    log2_n: Vec<u32>,
    /// Bits of a key, 8 to 64.
    #[arg(long, value_delimiter = ',', default_value = "8,16,24,32,48,64")]
    key_bits: Vec<u32>,
    /// Timed repeats.
    #[arg(long, default_value_t = 5)]
    repeats: u32,
    #[command(flatten)]
    device: DeviceOptions,
}

#[derive(Debug, Args)]
struct TraceArguments {
    /// .gltf or .glb files, or builtin:NAME.
    #[arg(default_value = "builtin:atrium")]
    scenes: Vec<String>,
    /// Trace kernels to compare; those of the device that trace rays one by one if not given.
    #[arg(long, value_delimiter = ',')]
    kernels: Vec<TraceKernel>,
    /// Orders to compare beside unsorted, `all` or a list of methods.
    #[arg(long, default_value = "two-point", value_name = "LIST")]
    methods: String,
    /// Picture width in pixels.
    #[arg(long, default_value_t = 640)]
    width: u32,
    /// Picture height in pixels.
    #[arg(long, default_value_t = 360)]
    height: u32,
    /// Bounces to trace.
    #[arg(long, default_value_t = 3)]
    bounces: u32,
    /// Samples per pixel; the last pass is measured.
    #[arg(long, default_value_t = 1)]
    passes: u32,
    /// Timed repeats.
    #[arg(long, default_value_t = 5)]
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

impl SortArguments {
    fn bench(&self) -> Result<SortBench, OptionError> {
        for &power in &self.log2_n {
            in_range("log2-n", power, 0, COUNT_BITS - 1)?;
        }
        for &bits in &self.key_bits {
            in_range("key-bits", bits, KEY_BITS_MIN, LAYOUT_BITS)?;
        }
        in_range("repeats", self.repeats, 1, 10_000)?;
        Ok(SortBench {
            counts: self.log2_n.iter().map(|&power| 1 << power).collect(),
            key_bits: self.key_bits.clone(),
            repeats: self.repeats,
            device: DeviceOptions { trace: None, ..self.device.clone() },
        })
    }
}

impl TraceArguments {
    fn bench(&self) -> Result<TraceBench, OptionError> {
        if self.device.trace.is_some() {
            let message = "--trace: a benchmark of tracing takes its kernels from --kernels";
            return Err(OptionError::conflict(message));
        }
        let run = RecordOptions {
            width: self.width,
            height: self.height,
            bounces: self.bounces,
            passes: self.passes,
            repeats: self.repeats,
            camera: self.camera.clone(),
            orders: parse_methods(&self.methods, &[])?.into(),
            key_bits: self.key_bits,
            device: DeviceOptions { trace: self.kernels.first().copied(), ..self.device.clone() },
            ..RecordOptions::base()?
        };
        run.check()?;
        Ok(TraceBench { scenes: self.scenes.clone(), kernels: once(&self.kernels), run })
    }
}

/// What was listed, without what was listed before.
fn once<T: Copy + PartialEq>(list: &[T]) -> Vec<T> {
    let is_first = |(at, item): &(usize, &T)| !list[..*at].contains(item);
    list.iter().enumerate().filter(is_first).map(|(_, &item)| item).collect()
}

/// What `--only` lists; all if it lists nothing.
fn chosen<T: ValueEnum + Copy + PartialEq>(only: &[T]) -> Vec<T> {
    if only.is_empty() { T::value_variants().to_vec() } else { once(only) }
}

pub(super) fn run(arguments: &BenchArguments) -> Result<()> {
    let result = match &arguments.what {
        What::Sort(arguments) => sort::run(&arguments.bench()?)?,
        What::Trace(arguments) => trace::run(&arguments.bench()?)?,
        What::Error(arguments) => crate::bench::error::run(&arguments.bench()?)?,
        What::Skip(arguments) => crate::bench::skip::run(&arguments.bench()?)?,
        What::Instrument(arguments) => crate::bench::instrument::run(&arguments.bench()?)?,
        What::Render(arguments) => crate::bench::render::run(&arguments.bench()?)?,
        What::Capture(arguments) => crate::bench::capture::run(&arguments.bench()?)?,
        What::Growth(arguments) => crate::bench::growth::run(&arguments.bench()?)?,
        What::Startup(arguments) => crate::bench::startup::run(&arguments.bench()?)?,
    };
    if arguments.json {
        return print_json(&result);
    }
    let shown = match &result.rows {
        Rows::Growth(_) => "least samples, exponents with 95 % intervals",
        _ => "medians and interquartile ranges",
    };
    print(format_args!("{} ({}), {shown}", result.adapter, result.backend))?;
    tables(&result).into_iter().try_for_each(print)?;
    // What all experiments come to, in a sentence.
    result.instrument.as_ref().map(instrument_line).map_or(Ok(()), print)
}

fn tables(result: &BenchResult) -> Vec<Table> {
    let shown = |items, samples: &[u64]| match rate(items, samples) {
        Some((rate, spread)) => [format!("{rate:.2}"), format!("{spread:.0} %")],
        None => [String::new(), String::new()],
    };
    match &result.rows {
        Rows::Sort(rows) => {
            let mut table = table_of("keys | key bits | Mkeys/s | spread");
            for row in rows {
                let [rate, spread] = shown(row.n, &row.samples_ns);
                table.add_row([row.n.to_string(), row.key_bits.to_string(), rate, spread]);
            }
            vec![table]
        }
        Rows::Trace(rows) => {
            let header = "scene | bounce | kind | rays | kernel | order | Mrays/s | spread | lanes busy | by the model";
            let mut table = table_of(header);
            for row in rows {
                let [rate, spread] = shown(row.rays, &row.samples_ns);
                let share = |share: f64| format!("{:.0} %", 100.0 * share);
                let [measured, model] = match row.lanes {
                    Some(lanes) => [share(lanes.measured), share(lanes.model)],
                    None => [String::new(), String::new()],
                };
                table.add_row([
                    row.scene.clone(),
                    row.bounce.to_string(),
                    row.kind.to_string(),
                    row.rays.to_string(),
                    row.kernel.clone(),
                    row.order.clone(),
                    rate,
                    spread,
                    measured,
                    model,
                ]);
            }
            vec![table]
        }
        Rows::Error(rows) => error::tables(rows),
        Rows::Skip(rows) => vec![skip::skip_table(rows)],
        Rows::Instrument(rows) => vec![instrument::table(rows)],
        Rows::Render(rows) => vec![render::table(rows)],
        Rows::Capture(rows) => vec![capture::table(rows)],
        Rows::Growth(rows) => vec![growth::table(rows)],
        Rows::Startup(rows) => vec![skip::startup_table(rows)],
    }
}

/// An empty table; its header is written as one, `column | column`.
fn table_of(header: &str) -> Table {
    let mut table = Table::new();
    table.load_style(UTF8_BORDERS_ONLY).set_header(header.split(" | "));
    table
}

/// Median in milliseconds and interquartile range in percent; empty without samples.
fn milliseconds(samples_ns: &[u64]) -> String {
    // One item in so many nanoseconds.
    match (median(samples_ns), rate(1, samples_ns)) {
        (Some(median_ns), Some((_, spread))) => format!("{:.3} ±{spread:.0} %", median_ns / 1e6),
        _ => String::new(),
    }
}
