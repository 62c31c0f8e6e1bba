//! `recorder import`.

use std::path::PathBuf;

use anyhow::Result;
use clap::{ArgGroup, Args, ValueEnum};
use formats::manifest::check::BOUNCES_MAX;
use formats::ray::Kind;

use super::record::{Shown, show};
use crate::options::{DeviceOptions, Keep, OptionError, RecordOptions, in_range, parse_orders};
use crate::replay::import::{ImportFrom, ImportOptions, import};

pub(super) const EXAMPLES: &str = "\
The file of rays is an NPY file in C order, one of
  <f4 (N, 6)   origin x y z, direction x y z
  <f4 (N, 8)   origin x y z, t_min, direction x y z, t_max
  the dtype of rays.npy in a recording, (N,)
in the world space of the scene. Directions are made unit vectors; t_min and t_max count in lengths of the
direction that was given. Shadow rays go to the light that they pass nearest to.

A folder of queues has for each queue a folder bounce-BB/closest or bounce-BB/shadow with
  rays.npy           as above, in the order of path_ids
  path_ids.npy       <u4 (N,), ascending; 0 to N - 1 if missing
  hits.npy           for closest rays, as in a recording, but t in lengths of the direction that was given:
                     judged against exact arithmetic
  distances.npy      for shadow rays, <f4 (N,), likewise; +inf where the light is seen
  lights.npy         for shadow rays, <u4 (N,)
  NAME/permutation.npy   <u4 (N,), the index of the ray at each place of an order of yours
  NAME/keys.npy          <u4 or <u8 (N,), its keys
and only the rays must be there. What the keys are may be said in orders.txt, which `inspector verify`
holds them to: lines NAME = LAYOUT @ BITS, such as mine = (ox oy oz)*10 @ 32, or mine = aila @ 32.

Examples:
  recorder import --scene sponza.glb --rays rays.npy --out mine.raydump
  recorder import --scene sponza.glb --rays shadow.npy --kind shadow --out shadow.raydump --methods all
  recorder import --scene sponza.glb --queues queues --size 1920x1080 --out theirs.raydump";

/// Most pixels of a picture's side.
const SIDE_MAX: u32 = 1 << 16;

/// [`Kind`] on the command line.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum KindArgument {
    /// The nearest hit.
    Closest,
    /// Any hit up to t_max.
    Shadow,
}

#[derive(Debug, Args)]
#[command(group(ArgGroup::new("input").required(true)))]
pub(super) struct ImportArguments {
    /// A .gltf or .glb file, or builtin:NAME.
    #[arg(long)]
    scene: String,
    /// A file of rays.
    #[arg(long, value_name = "RAYS.npy", group = "input")]
    rays: Option<PathBuf>,
    /// A folder of queues, with the orders that another tracer gave them.
    #[arg(long, value_name = "FOLDER", group = "input")]
    queues: Option<PathBuf>,
    /// What the rays of a file ask for.
    #[arg(long, value_enum, default_value_t = KindArgument::Closest, conflicts_with = "queues")]
    kind: KindArgument,
    /// Bounce that they are recorded as: 0 for camera rays, 1 and more for those that left a surface.
    #[arg(long, default_value_t = 1, conflicts_with = "queues")]
    bounce: u32,
    /// Picture size: path ids number its pixels row by row; one row if not given.
    #[arg(long, value_name = "WxH", value_parser = size)]
    size: Option<[u32; 2]>,
    /// Folder of the recording; `.raydump` is added if missing.
    #[arg(long, value_name = "X.raydump")]
    out: PathBuf,
    /// Methods to compare, `all` or a list such as aila,two-point; unsorted is always measured.
    #[arg(long, default_value = "all", value_name = "LIST")]
    methods: String,
    /// A layout of your own, such as 'mine=(ox oy oz)*4 (u v ex ey ez)*10 @adaptive', in the words of docs/keys.md; may
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
    /// Arrays to keep: rays,hits,keys,permutations,lengths,scene,caches,work,hierarchy, or none.
    #[arg(long, default_value = "rays,hits,keys,permutations,lengths,scene,caches", value_name = "LIST")]
    keep: String,
    /// Replace an existing recording.
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    shown: Shown,
}

fn size(text: &str) -> Result<[u32; 2], String> {
    let numbers =
        text.split_once('x').and_then(|(width, height)| Some([width.parse().ok()?, height.parse().ok()?]));
    let numbers = numbers.filter(|numbers| numbers.iter().all(|number| (1..=SIDE_MAX).contains(number)));
    numbers.ok_or_else(|| format!("expected WIDTHxHEIGHT, such as 640x360, each up to {SIDE_MAX}"))
}

impl ImportArguments {
    fn options(&self) -> Result<ImportOptions, OptionError> {
        in_range("bounce", self.bounce, 0, BOUNCES_MAX - 1)?;
        let keep = Keep::parse(&self.keep)?;
        let lacking = [(keep.throughput, "throughput"), (keep.image, "image")];
        if let Some((_, what)) = lacking.into_iter().find(|(is_asked, _)| *is_asked) {
            return Err(OptionError::conflict(format!(
                "--keep {what}: rays of another tracer come without what their paths carry"
            )));
        }
        let run = RecordOptions {
            scene: self.scene.clone(),
            out: self.out.clone(),
            width: 1,
            height: 1,
            bounces: self.bounce + 1,
            repeats: self.repeats,
            orders: parse_orders(&self.methods, &self.own_methods)?,
            key_bits: self.key_bits,
            device: self.device.clone(),
            keep,
            force: self.force,
            ..RecordOptions::base()?
        };
        run.check()?;
        let kind = match self.kind {
            KindArgument::Closest => Kind::Closest,
            KindArgument::Shadow => Kind::Shadow,
        };
        let from = match (&self.rays, &self.queues) {
            (Some(file), _) => ImportFrom::Rays { file: file.clone(), kind, bounce: self.bounce },
            (None, Some(folder)) => ImportFrom::Queues(folder.clone()),
            (None, None) => return Err(OptionError::conflict("give --rays or --queues")),
        };
        Ok(ImportOptions { from, size: self.size, run })
    }
}

pub(super) fn run(arguments: &ImportArguments) -> Result<()> {
    show(&import(&arguments.options()?)?, &arguments.shown)
}
