//! `recorder import`.

use std::path::PathBuf;

use anyhow::Result;
use clap::{Args, ValueEnum};
use formats::manifest::check::BOUNCES_MAX;
use formats::ray::Kind;

use super::record::show;
use crate::options::{AskedOrders, DeviceOptions, Keep, OptionError, RecordOptions, in_range, parse_orders};
use crate::replay::import::{ImportOptions, import};

pub(super) const EXAMPLES: &str = "\
The file of rays is an NPY file in C order, one of
  <f4 (N, 6)   origin x y z, direction x y z
  <f4 (N, 8)   origin x y z, t_min, direction x y z, t_max
  the dtype of rays.npy in a recording, (N,)
in the world space of the scene. Directions are made unit vectors; t_min and t_max count in lengths of the
direction that was given. Shadow rays go to the light that they pass nearest to.

Examples:
  recorder import --scene sponza.glb --rays rays.npy --out mine.raydump
  recorder import --scene sponza.glb --rays shadow.npy --kind shadow --out shadow.raydump --methods all";

/// [`Kind`] on the command line.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum KindArgument {
    /// The nearest hit.
    Closest,
    /// Any hit up to t_max.
    Shadow,
}

#[derive(Debug, Args)]
pub(super) struct ImportArguments {
    /// A .gltf or .glb file, or builtin:NAME.
    #[arg(long)]
    scene: String,
    /// The file of rays.
    #[arg(long, value_name = "RAYS.npy")]
    rays: PathBuf,
    /// What the rays ask for.
    #[arg(long, value_enum, default_value_t = KindArgument::Closest)]
    kind: KindArgument,
    /// Bounce that they are recorded as: 0 for camera rays, 1 and more for those that left a surface.
    #[arg(long, default_value_t = 1)]
    bounce: u32,
    /// Folder of the recording; `.raydump` is added if missing.
    #[arg(long, value_name = "X.raydump")]
    out: PathBuf,
    /// Methods to compare, `all` or a list such as aila,two-point; unsorted is always measured.
    #[arg(long, default_value = "all", value_name = "LIST")]
    methods: String,
    /// A layout of your own, such as 'mine=(ox oy oz)*4 (u v ex ey ez)*10 @adaptive', in the words of the README; may
    /// be repeated.
    #[arg(long = "method", value_name = "NAME=LAYOUT")]
    own_methods: Vec<String>,
    /// Bits of a key, 8 to 64.
    #[arg(long, default_value_t = 32)]
    key_bits: u32,
    /// Timed repeats of every method.
    #[arg(long, default_value_t = 3)]
    repeats: u32,
    #[command(flatten)]
    device: DeviceOptions,
    /// Arrays to keep: rays,hits,keys,permutations,lengths,scene,caches,work, or none.
    #[arg(long, default_value = "rays,hits,keys,permutations,lengths,scene,caches", value_name = "LIST")]
    keep: String,
    /// Replace an existing recording.
    #[arg(long)]
    force: bool,
    /// Print the results as one JSON object on stdout.
    #[arg(long)]
    json: bool,
}

impl ImportArguments {
    fn options(&self) -> Result<ImportOptions, OptionError> {
        in_range("bounce", self.bounce, 0, BOUNCES_MAX - 1)?;
        let AskedOrders { methods, control, shuffled, auto } =
            parse_orders(&self.methods, &self.own_methods)?;
        let run = RecordOptions {
            scene: self.scene.clone(),
            out: self.out.clone(),
            width: 1,
            height: 1,
            bounces: self.bounce + 1,
            repeats: self.repeats,
            methods,
            control,
            shuffled,
            auto,
            key_bits: self.key_bits,
            device: self.device.clone(),
            keep: Keep::parse(&self.keep)?,
            force: self.force,
            ..RecordOptions::base()?
        };
        run.check()?;
        let kind = match self.kind {
            KindArgument::Closest => Kind::Closest,
            KindArgument::Shadow => Kind::Shadow,
        };
        Ok(ImportOptions { rays: self.rays.clone(), kind, bounce: self.bounce, run })
    }
}

pub(super) fn run(arguments: &ImportArguments) -> Result<()> {
    show(&import(&arguments.options()?)?, arguments.json)
}
