//! `inspector export`: rays, hits, orders and capsules for other programs.
//!
//! - `rays`: one queue in one order; `capsule`: two spheres and their hull
//! - `csv`, `ply`: the formats. Everything is written as it is read, nothing is collected.

mod capsule;
mod csv;
mod ply;
mod rays;

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::{Args, ValueEnum};
use formats::files::replace;
use formats::reader::Dump;
use serde::Serialize;

use crate::figures::files::make_folder;
use crate::output::{print, print_json};
use rays::{ChosenRays, RayChoice};

/// What files are made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Format {
    /// Rays with their hits as a table.
    Csv,
    /// Rays, hits, curve and capsules as geometry.
    Ply,
}

/// What `--json` prints.
#[derive(Serialize)]
struct Made {
    files: Vec<PathBuf>,
    rays: usize,
}

/// Rays as files.
#[derive(Debug, Args)]
pub(crate) struct Export {
    /// The recording: a folder NAME.raydump, or NAME.raydump.partial.
    #[arg(value_name = "X.raydump")]
    dump: PathBuf,
    /// The folder for the files; it is made if it is not there.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// What to write.
    #[arg(long, value_enum)]
    format: Format,
    #[command(flatten)]
    choice: RayChoice,
    /// Print one JSON object instead of text.
    #[arg(long)]
    json: bool,
}

/// Writes the files of a format into a folder.
pub(crate) fn run(Export { dump, out, format, choice, json }: &Export) -> anyhow::Result<()> {
    let rays = ChosenRays::open(&Dump::open(dump)?, choice)?;
    make_folder(out)?;
    let stem = stem(&rays, choice);
    let files = match format {
        Format::Csv => vec![write(out, &format!("{stem}.csv"), |output| csv::write(&rays, output))?],
        Format::Ply => {
            let mut files = vec![
                write(out, &format!("{stem}-rays.ply"), |output| ply::rays(&rays, output))?,
                write(out, &format!("{stem}-hits.ply"), |output| ply::hits(&rays, output))?,
                write(out, &format!("{stem}-curve.ply"), |output| ply::curve(&rays, output))?,
            ];
            // Rays that pass a filter are no groups.
            if choice.filter.is_none() {
                let width = choice.group_width.rays();
                let capsules = |output: &mut dyn Write| ply::capsules(&rays, width, output);
                files.push(write(out, &format!("{stem}-capsules.ply"), capsules)?);
            }
            files
        }
    };
    if *json {
        return print_json(&Made { files, rays: rays.len() });
    }
    print(&files.iter().map(|path| path.display().to_string()).collect::<Vec<_>>().join("\n"))
}

/// Names of the files up to what each holds.
fn stem(rays: &ChosenRays, choice: &RayChoice) -> String {
    let id = rays.queue().id;
    let group = choice.group.map_or(String::new(), |group| format!("-group-{group}"));
    let filtered = if choice.filter.is_some() { "-filtered" } else { "" };
    format!("pass-{:03}-bounce-{:02}-{}-{}{group}{filtered}", id.pass, id.bounce, id.kind, rays.method())
}

/// Writes a file whole or not at all.
fn write(
    folder: &Path,
    name: &str,
    fill: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> anyhow::Result<PathBuf> {
    let path = folder.join(name);
    replace(&path, fill).with_context(|| format!("cannot write {}", path.display()))?;
    Ok(path)
}
