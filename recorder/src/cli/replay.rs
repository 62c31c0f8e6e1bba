//! `recorder replay`.

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;
use formats::key::Method;
use formats::key::method::UNSORTED;
use formats::length_table::TABLE_BITS_DEFAULT;
use formats::manifest::check::REPEATS_MAX;

use super::record::{Shown, show};
use crate::options::{DeviceOptions, Keep, OptionError, check_table, in_range, parse_orders};
use crate::replay::variants::Sweep;
use crate::replay::{ReplayOptions, replay};

pub(super) const EXAMPLES: &str = "\
Examples:
  recorder replay sponza.raydump --out again.raydump
  recorder replay sponza.raydump --out bits.raydump --methods two-point --key-bits 8,16,24,32,48,64
  recorder replay sponza.raydump --out length.raydump --methods two-point --two-point-length 0.05..0.4:8
  recorder replay sponza.raydump --out split.raydump --methods octahedron,two-point --split 4..28:7
  recorder replay sponza.raydump --out table.raydump --methods two-point-adaptive --table-method octahedron
  recorder replay sponza.raydump --out bvh2.raydump --trace bvh2 --backend gpu

The new recording holds what differs and names the first one, which readers look for in the same folder.
What is not given is as it was recorded, but for the device.";

#[derive(Debug, Args)]
pub(super) struct ReplayArguments {
    /// The recording whose rays are measured again.
    #[arg(value_name = "X.raydump")]
    source: PathBuf,
    /// Folder of the new recording; `.raydump` is added if missing.
    #[arg(long, value_name = "Y.raydump")]
    out: PathBuf,
    /// Methods to compare, `all` or a list such as aila,two-point,auto; auto chooses by the recording's calibration
    /// if that is of this device and kernel, else by a new one; control is always measured, shuffled (a random order)
    /// and rows of others such as hilbert-origin if they are named.
    #[arg(long, value_name = "LIST")]
    methods: Option<String>,
    /// A layout of your own, such as 'mine=(ox oy oz)*4 (u v ex ey ez)*10 @adaptive', in the words of docs/keys.md; may
    /// be repeated.
    #[arg(long = "method", value_name = "NAME=LAYOUT")]
    own_methods: Vec<String>,
    /// Bits of a key, 8 to 64: one number, or several to sweep over.
    #[arg(long, value_name = "LIST")]
    key_bits: Option<String>,
    /// Length that two-point assumes, unit lengths: one number, a list, or a range such as 0.05..0.4:8.
    #[arg(long, value_name = "LIST")]
    two_point_length: Option<String>,
    /// Bits of a key that are the origin's, the rest for the direction or end point, in turn: one number, a list, or
    /// a range such as 4..28:7; for methods that have both.
    #[arg(long, value_name = "LIST")]
    split: Option<String>,
    /// Address bits of the length tables, 8 to 24; other tables than recorded learn from the recorded rays.
    #[arg(long)]
    table_bits: Option<u32>,
    /// Method whose key addresses the length tables.
    #[arg(long, value_name = "METHOD")]
    table_method: Option<String>,
    /// Timed repeats of every method.
    #[arg(long)]
    repeats: Option<u32>,
    #[command(flatten)]
    device: DeviceOptions,
    /// Arrays to keep: keys,permutations,work,caches, or none.
    #[arg(long, default_value = "keys,permutations,caches", value_name = "LIST")]
    keep: String,
    /// Replace an existing recording.
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    shown: Shown,
}

impl ReplayArguments {
    pub(super) fn options(&self) -> Result<ReplayOptions, OptionError> {
        let keep = Keep::parse(&self.keep)?;
        let allowed = Keep { keys: true, permutations: true, work: true, caches: true, ..Keep::default() };
        if let Some(word) = keep.words().into_iter().find(|word| !allowed.words().contains(word)) {
            return Err(OptionError::conflict(format!(
                "--keep {word}: a replay keeps what differs, {}; the rest is in the recording it refers to",
                allowed.words().join(", ")
            )));
        }
        self.repeats.map(|repeats| in_range("repeats", repeats, 1, REPEATS_MAX)).transpose()?;
        let table_method = self.table_method.as_deref().map(Method::builtin).transpose()?;
        // What is not given is as it was recorded, and checked with the recording.
        let default = Method::builtin("aila")?;
        check_table(
            self.table_bits.unwrap_or(TABLE_BITS_DEFAULT),
            table_method.as_ref().unwrap_or(&default),
        )?;
        let wants_methods = self.methods.is_some() || !self.own_methods.is_empty();
        let list = self.methods.as_deref().unwrap_or(UNSORTED);
        Ok(ReplayOptions {
            source: self.source.clone(),
            out: self.out.clone(),
            orders: wants_methods.then(|| parse_orders(list, &self.own_methods)).transpose()?,
            sweep: Sweep::parse(
                self.key_bits.as_deref(),
                self.two_point_length.as_deref(),
                self.split.as_deref(),
            )?,
            table_bits: self.table_bits,
            table_method,
            repeats: self.repeats,
            device: self.device.clone(),
            keep,
            force: self.force,
        })
    }
}

pub(super) fn run(arguments: &ReplayArguments) -> Result<()> {
    show(&replay(&arguments.options()?)?, &arguments.shown)
}
