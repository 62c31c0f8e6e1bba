//! What is not written, and what need not be built again.

use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result};
use formats::bench_result::skip::{Cost, SkipRow};
use formats::reader::Dump;
use scenes::bvh::{self, Source};

use super::Bench;
use crate::machine::Device;
use crate::options::{Keep, KeepPasses, RecordOptions};
use crate::recording::record;

/// Recordings of two passes with fewer and more arrays; the hierarchy built and loaded.
pub(super) fn rows(bench: Bench<'_>) -> Result<Vec<SkipRow>> {
    let folder = tempfile::tempdir().context("cannot make a temporary folder")?;
    let nothing = Keep::default();
    let everything = Keep::parse(&Keep::WORDS.join(","))?;
    let [none, measured, all] =
        [(nothing, KeepPasses::Measured), (everything, KeepPasses::Measured), (everything, KeepPasses::All)];
    let mut recordings = Vec::new();
    for (keep, keep_passes) in [none, measured, all] {
        recordings.push(recording(bench, &folder.path().join("skip.raydump"), keep, keep_passes)?);
    }
    let pair = |what: &str, skipped: usize, done: usize| {
        let [(skipped, one), (done, other)] = [recordings[skipped].clone(), recordings[done].clone()];
        let row = bench.row(what, "a recording of two passes", "picture");
        SkipRow { skipped, done, is_same: one == other, ..row }
    };
    let mut rows = vec![
        pair("arrays that nobody asked for", 0, 1),
        pair("arrays of passes that are not measured", 1, 2),
    ];
    rows.extend(hierarchy(bench, &folder.path().join("bvh"))?);
    Ok(rows)
}

/// Time and bytes of a recording without methods, and the hash of its picture.
fn recording(
    bench: Bench<'_>,
    out: &Path,
    keep: Keep,
    keep_passes: KeepPasses,
) -> Result<(Cost, Option<[u8; 32]>)> {
    let options = RecordOptions {
        out: out.to_owned(),
        passes: 2,
        methods: Vec::new(),
        repeats: 1,
        keep,
        keep_passes,
        force: true,
        ..bench.run.clone()
    };
    let mut cost = Cost::default();
    let mut digest = None;
    for _ in 0..bench.run.repeats {
        let recorded = record(&options)?;
        let end = Dump::open(&recorded.path)?.manifest().end;
        let end = end.context("the recording that was just made has no end")?;
        cost.samples_ns.push(end.wall_ns);
        cost.bytes = folder_bytes(&recorded.path)?;
        digest = end.image.map(|image| image.sha256);
    }
    Ok((cost, digest))
}

fn folder_bytes(folder: &Path) -> Result<u64> {
    let mut bytes = 0;
    for entry in std::fs::read_dir(folder)? {
        let entry = entry?;
        let metadata = entry.metadata()?;
        bytes += if metadata.is_dir() { folder_bytes(&entry.path())? } else { metadata.len() };
    }
    Ok(bytes)
}

/// The hierarchy from the cache, and built.
fn hierarchy(bench: Bench<'_>, cache: &Path) -> Result<Option<SkipRow>> {
    let Some(kind) = bench.device.kernel(&bench.run.device).bvh_kind() else { return Ok(None) };
    let mut row = bench.row("a hierarchy that was built before", "start", "hierarchy");
    let (kept, _) = bvh::load_or_build(bench.scene, kind, Some(cache))?;
    for _ in 0..bench.run.repeats {
        let start = Instant::now();
        let (loaded, source) = bvh::load_or_build(bench.scene, kind, Some(cache))?;
        row.skipped.samples_ns.push(start.elapsed().as_nanos() as u64);
        let start = Instant::now();
        let built = on_threads_of(bench.device, || bvh::build(bench.scene, kind))?;
        row.done.samples_ns.push(start.elapsed().as_nanos() as u64);
        row.is_same &= source == Source::Cached && loaded == built && built == kept;
    }
    row.skipped.bytes = folder_bytes(cache)?;
    Ok(Some(row))
}

fn on_threads_of<T: Send>(device: &Device, work: impl FnOnce() -> T + Send) -> T {
    match device {
        Device::Cpu(cpu) => cpu.pool.install(work),
        Device::Gpu(_) => work(),
    }
}
