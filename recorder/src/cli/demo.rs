//! `recorder demo`: a first recording without having to know anything.

use std::ffi::OsString;
use std::path::PathBuf;

use anyhow::{Context, Result, bail};
use clap::Args;
use formats::reader::Dump;

use super::parse_words;
use super::record::RecordArguments;
use crate::options::DeviceOptions;
use crate::output::{print, print_json};
use crate::recording;
use crate::report;

/// The built-in scene.
const SCENE: &str = "builtin:atrium";
/// A size that takes seconds on two cores, and what each picture of the window is made of.
const SIZE: &str = "--width 400 --height 225 --bounces 4 --passes 2 --repeats 7 \
    --keep rays,hits,keys,permutations,lengths,scene,image,caches,work --force --out";

#[derive(Debug, Args)]
pub(super) struct DemoArguments {
    /// Folder that the recording, demo.raydump, is put into.
    #[arg(long, default_value = ".", value_name = "DIR")]
    out: PathBuf,
    #[command(flatten)]
    device: DeviceOptions,
    /// Print the results as one JSON object on stdout.
    #[arg(long)]
    json: bool,
}

pub(super) fn run(arguments: &DemoArguments) -> Result<()> {
    std::fs::create_dir_all(&arguments.out)
        .with_context(|| format!("cannot make the folder {}", arguments.out.display()))?;
    let out = arguments.out.join("demo.raydump");
    // An earlier demo is replaced without a word, and nothing else that has its name.
    let is_demo = |dump: Dump| dump.manifest().header.scene.name == SCENE;
    if Dump::open(&out).is_ok_and(|dump| !is_demo(dump)) {
        bail!("{} holds a recording of something else; choose another folder with --out", out.display());
    }
    let words =
        [SCENE].into_iter().chain(SIZE.split_whitespace()).map(OsString::from).chain([out.into_os_string()]);
    let mut record = parse_words::<RecordArguments>("record", words)?;
    record.device = arguments.device.clone();
    let recorded = recording::record(&record.options()?)?;
    if arguments.json {
        return print_json(&recorded.summary()?);
    }
    print(report::text(&recorded, false)?)?;
    let path = recorded.path.display();
    print(format_args!(
        "\nWhere to look next:\n  \
         inspector {path}            the window: orders, capsules, tables, times\n  \
         inspector info {path}       what was recorded\n  \
         inspector verify {path}     check every key, permutation and hit of it\n  \
         recorder record SCENE.glb --out NAME.raydump     the same for a scene of your own"
    ))
}
