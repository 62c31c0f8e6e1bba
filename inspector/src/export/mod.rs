//! `inspector export`: rays, hits, orders and capsules for other programs.
//!
//! - `rays`: one queue in one order; `capsule`: two spheres and their hull
//! - `csv`, `ply`: the formats. Everything is written as it is read, nothing is collected.
//! - `parquet`: whole recordings and studies as one dataset

mod capsule;
mod csv;
mod parquet;
mod ply;
mod rays;

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use clap::{Args, ValueEnum};
use formats::files::replace;
use formats::reader::Dump;
use serde::Serialize;

use crate::figures::files::make_folder;
use crate::output::{counted, print, print_json, size};
use rays::{ChosenRays, RayChoice};

/// What files are made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Format {
    /// Rays with their hits as a table.
    Csv,
    /// Rays, hits, curve and capsules as geometry; of a group also its paths through all bounces.
    Ply,
    /// All rays, times and numbers as tables for DuckDB, Polars, Spark and their like.
    Parquet,
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
    /// The recording: a folder NAME.raydump, or NAME.raydump.partial; for parquet also the folder of a study.
    #[arg(value_name = "X.raydump")]
    dump: PathBuf,
    /// The folder for the files; it is made if it is not there.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// What to write.
    #[arg(long, value_enum)]
    format: Format,
    /// Replace the parquet export in the folder, once the new one is complete.
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    choice: RayChoice,
    /// Print one JSON object instead of text.
    #[arg(long)]
    json: bool,
}

/// Writes the files of a format into a folder.
pub(crate) fn run(export: &Export) -> anyhow::Result<()> {
    match export.format {
        Format::Csv => files(export, csv_files),
        Format::Ply => files(export, ply_files),
        Format::Parquet => dataset(export),
    }
}

/// Writes the rays of one queue in one order.
fn files(
    Export { dump, out, choice, json, .. }: &Export,
    write: fn(&Dump, &ChosenRays, &RayChoice, &Path) -> anyhow::Result<Vec<PathBuf>>,
) -> anyhow::Result<()> {
    let dump = Dump::open(dump)?;
    let rays = ChosenRays::open(&dump, choice)?;
    make_folder(out)?;
    let files = write(&dump, &rays, choice, out)?;
    if *json {
        return print_json(&Made { files, rays: rays.len() });
    }
    print(&files.iter().map(|path| path.display().to_string()).collect::<Vec<_>>().join("\n"))
}

fn csv_files(_: &Dump, rays: &ChosenRays, choice: &RayChoice, out: &Path) -> anyhow::Result<Vec<PathBuf>> {
    let name = format!("{}.csv", stem(rays, choice));
    Ok(vec![write(out, &name, |output| csv::write(rays, output))?])
}

fn ply_files(dump: &Dump, rays: &ChosenRays, choice: &RayChoice, out: &Path) -> anyhow::Result<Vec<PathBuf>> {
    let stem = stem(rays, choice);
    let mut files = vec![
        write(out, &format!("{stem}-rays.ply"), |output| ply::rays(rays, output))?,
        write(out, &format!("{stem}-hits.ply"), |output| ply::hits(rays, output))?,
        write(out, &format!("{stem}-curve.ply"), |output| ply::curve(rays, output))?,
    ];
    // Rays that pass a filter are no groups.
    if choice.filter.is_none() {
        let width = choice.group_width.rays();
        let capsules = |output: &mut dyn Write| ply::capsules(rays, width, output);
        files.push(write(out, &format!("{stem}-capsules.ply"), capsules)?);
    }
    // Of all rays, they would be all rays of all bounces.
    if choice.group.is_some() {
        let paths = rays.on_their_paths(dump)?;
        files.push(write(out, &format!("{stem}-paths.ply"), |output| ply::paths(&paths, output))?);
    }
    Ok(files)
}

/// Writes a recording or a study as one dataset.
fn dataset(Export { dump, out, force, choice, json, .. }: &Export) -> anyhow::Result<()> {
    if choice.group.is_some() || choice.filter.is_some() {
        bail!("--group and --filter choose rays for csv and ply; of a parquet export, a query does");
    }
    let written = parquet::write(dump, out, *force, choice)?;
    if *json {
        return print_json(&written);
    }
    let parquet::Written { folder, recordings, ray_files, rays, ray_bytes, samples, summaries, left_out } =
        written;
    let mut lines = vec![format!(
        "{}: {}, {} of rays in {} ({}), {} of times, {} of orders",
        folder.display(),
        counted(recordings as u64, "recording", "recordings"),
        counted(rays, "row", "rows"),
        counted(ray_files as u64, "file", "files"),
        size(ray_bytes),
        counted(samples, "sample", "samples"),
        counted(summaries, "summary", "summaries"),
    )];
    lines.extend(left_out.iter().map(|left_out| format!("left out: {left_out}")));
    print(&lines.join("\n"))
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
