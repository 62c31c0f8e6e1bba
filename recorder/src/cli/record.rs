//! `recorder record`.

use std::path::PathBuf;

use anyhow::Result;
use clap::{Args, ValueEnum};

use crate::options::{DeviceOptions, Keep, KeepPasses, OptionError, RecordOptions, parse_orders};
use crate::output::{print, print_json};
use crate::recording::{self, Recorded};
use crate::report;
use formats::key::Method;

/// Sets of defaults.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Preset {
    /// 960×540, 5 bounces, 2 passes, 7 repeats.
    Quick,
    /// 1920×1080, 8 bounces, 32-bit keys as in the paper; 4 passes and 15 repeats are ours.
    Paper,
}

impl Preset {
    /// Width, height, bounces, passes and repeats.
    fn values(self) -> [u32; 5] {
        match self {
            Self::Quick => [960, 540, 5, 2, 7],
            Self::Paper => [1920, 1080, 8, 4, 15],
        }
    }
}

#[derive(Debug, Args)]
pub(super) struct RecordArguments {
    /// A .gltf or .glb file, or builtin:NAME (see `recorder scenes`).
    scene: String,
    /// Folder of the recording; `.raydump` is added if missing.
    #[arg(long, value_name = "X.raydump")]
    out: PathBuf,
    /// Defaults for the size of the run; each value also by its own flag.
    #[arg(long, value_enum, default_value_t = Preset::Quick)]
    preset: Preset,
    /// Picture width in pixels.
    #[arg(long)]
    width: Option<u32>,
    /// Picture height in pixels.
    #[arg(long)]
    height: Option<u32>,
    /// Bounces to trace: 1 is camera rays alone.
    #[arg(long)]
    bounces: Option<u32>,
    /// Samples per pixel; methods are measured in the last pass.
    #[arg(long)]
    passes: Option<u32>,
    /// Timed repeats of every method.
    #[arg(long)]
    repeats: Option<u32>,
    /// Seed of all random numbers.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Camera by name; the scene's first if not given.
    #[arg(long)]
    camera: Option<String>,
    /// Radius of lights that the scene file makes points, world units: 0.05 in the paper; points if not given.
    #[arg(long, allow_negative_numbers = true)]
    light_radius: Option<f32>,
    /// Methods to compare, `all` or a list such as aila,two-point,auto; auto is what a calibration finds best for
    /// each queue; unsorted and control (canonical order, measured like a method) are always measured, shuffled (a
    /// random order) and rows of others such as hilbert-origin if they are named.
    #[arg(long, default_value = "all", value_name = "LIST")]
    methods: String,
    /// A layout of your own, such as 'mine=(ox oy oz)*4 (u v ex ey ez)*10 @adaptive', in the words of docs/keys.md; may
    /// be repeated.
    #[arg(long = "method", value_name = "NAME=LAYOUT")]
    own_methods: Vec<String>,
    /// Bits of a key, 8 to 64.
    #[arg(long, default_value_t = 32, value_parser = one_number)]
    key_bits: u32,
    /// Length that two-point assumes, in units of the scene's largest extent.
    #[arg(long, default_value_t = 0.25, allow_negative_numbers = true)]
    two_point_length: f32,
    /// Address bits of the length tables, 8 to 24.
    #[arg(long, default_value_t = 20)]
    table_bits: u32,
    /// Method whose key addresses the length tables.
    #[arg(long, default_value = "aila", value_name = "METHOD")]
    table_method: String,
    #[command(flatten)]
    pub(super) device: DeviceOptions,
    /// Arrays to keep: rays,hits,keys,permutations,lengths,scene,image,caches,work,hierarchy,throughput, or none.
    #[arg(
        long,
        default_value = "rays,hits,keys,permutations,lengths,scene,image,caches",
        value_name = "LIST"
    )]
    keep: String,
    /// Passes to keep arrays of.
    #[arg(long, value_enum, default_value_t = KeepPasses::Measured)]
    keep_passes: KeepPasses,
    /// End paths at random by their throughput from the third bounce on.
    #[arg(long)]
    russian_roulette: bool,
    /// Replace an existing recording.
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    shown: Shown,
}

/// Of an option that `recorder replay` takes a list for.
fn one_number(text: &str) -> Result<u32, String> {
    text.parse().map_err(|error| match text.contains(',') {
        true => "expected one number; `recorder replay` sweeps over several".to_owned(),
        false => format!("{error}"),
    })
}

impl RecordArguments {
    pub(super) fn options(&self) -> Result<RecordOptions, OptionError> {
        let [width, height, bounces, passes, repeats] = self.preset.values();
        let options = RecordOptions {
            scene: self.scene.clone(),
            out: self.out.clone(),
            width: self.width.unwrap_or(width),
            height: self.height.unwrap_or(height),
            bounces: self.bounces.unwrap_or(bounces),
            passes: self.passes.unwrap_or(passes),
            repeats: self.repeats.unwrap_or(repeats),
            seed: self.seed,
            camera: self.camera.clone(),
            light_radius: self.light_radius,
            orders: parse_orders(&self.methods, &self.own_methods)?,
            key_bits: self.key_bits,
            two_point_length: self.two_point_length,
            table_bits: self.table_bits,
            table_method: Method::builtin(&self.table_method)?,
            device: self.device.clone(),
            keep: Keep::parse(&self.keep)?,
            keep_passes: self.keep_passes,
            russian_roulette: self.russian_roulette,
            force: self.force,
        };
        options.check()?;
        Ok(options)
    }
}

pub(super) fn run(arguments: &RecordArguments) -> Result<()> {
    show(&recording::record(&arguments.options()?)?, &arguments.shown)
}

/// How results are shown.
#[derive(Debug, Args)]
pub(super) struct Shown {
    /// Also show the time of every stage, by bounce, kind of rays and method.
    #[arg(long, conflicts_with = "json")]
    details: bool,
    /// Print the results as one JSON object on stdout.
    #[arg(long)]
    json: bool,
}

/// Prints what was recorded, as a table or as JSON.
pub(super) fn show(recorded: &Recorded, shown: &Shown) -> Result<()> {
    if shown.json { print_json(&recorded.summary()?) } else { print(report::text(recorded, shown.details)?) }
}
