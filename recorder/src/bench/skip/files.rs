//! What is not written, and what need not be built again.

use std::path::Path;

use anyhow::{Context, Result};
use formats::bench_result::skip::{Cost, SkipRow};
use formats::manifest::check::KEEP_WORDS;
use formats::reader::Dump;
use scenes::bvh::{self, Source};

use super::super::folder_bytes;
use super::Bench;
use crate::clock::Clock;
use crate::measure::sampled;
use crate::options::{AskedOrders, Keep, KeepPasses, RecordOptions};
use crate::recording::record;

/// Recordings of two passes with fewer and more arrays; the hierarchy built and loaded.
pub(super) fn rows(bench: Bench<'_>) -> Result<Vec<SkipRow>> {
    let folder = tempfile::tempdir().context("cannot make a temporary folder")?;
    let nothing = Keep::default();
    let everything = Keep::parse(&KEEP_WORDS.join(","))?;
    let kept =
        [(nothing, KeepPasses::Measured), (everything, KeepPasses::Measured), (everything, KeepPasses::All)];
    let out = folder.path().join("skip.raydump");
    let recordings =
        sampled(kept.len(), bench.run.repeats, bench.run.seed, |at| recording(bench, &out, kept[at]))?;
    let pair = |what: &str, skipped: usize, done: usize| {
        let (skipped, done) = (&recordings[skipped], &recordings[done]);
        let row = bench.row(what, "a recording of two passes", "picture");
        let is_same = skipped.iter().zip(done).all(|(one, other)| one.picture == other.picture);
        SkipRow { skipped: cost(skipped), done: cost(done), is_same, ..row }
    };
    let mut rows = vec![
        pair("arrays that nobody asked for", 0, 1),
        pair("arrays of passes that are not measured", 1, 2),
    ];
    rows.extend(hierarchy(bench, &folder.path().join("bvh"))?);
    Ok(rows)
}

/// A recording without methods.
struct Recording {
    wall_ns: u64,
    bytes: u64,
    /// Hash of its picture.
    picture: Option<[u8; 32]>,
}

fn cost(recordings: &[Recording]) -> Cost {
    let samples_ns = recordings.iter().map(|recording| recording.wall_ns).collect();
    Cost { samples_ns, bytes: recordings.last().map_or(0, |recording| recording.bytes) }
}

fn recording(bench: Bench<'_>, out: &Path, (keep, keep_passes): (Keep, KeepPasses)) -> Result<Recording> {
    let options = RecordOptions {
        out: out.to_owned(),
        passes: 2,
        orders: AskedOrders::default(),
        repeats: 1,
        keep,
        keep_passes,
        force: true,
        ..bench.run.clone()
    };
    let recorded = record(&options)?;
    let end = Dump::open(&recorded.path)?.manifest().end;
    let end = end.context("the recording that was just made has no end")?;
    let picture = end.image.map(|image| image.sha256);
    Ok(Recording { wall_ns: end.wall_ns, bytes: folder_bytes(&recorded.path)?, picture })
}

/// The hierarchy from the cache, and built.
fn hierarchy(bench: Bench<'_>, cache: &Path) -> Result<Option<SkipRow>> {
    let Some(kind) = bench.device.kernel(&bench.run.device).bvh_kind() else { return Ok(None) };
    let mut row = bench.row("a hierarchy that was built before", "start", "hierarchy");
    let (kept, _) = bvh::load_or_build(bench.scene, kind, Some(cache))?;
    let mut clock = Clock::of_processor();
    let mut samples = sampled(2, bench.run.repeats, bench.run.seed, |at| {
        let is_loaded = at == 0;
        let (found, was_cached) = if is_loaded {
            let (loaded, source) = clock.time(|| bvh::load_or_build(bench.scene, kind, Some(cache)))?;
            (loaded, source == Source::Cached)
        } else {
            (clock.time(|| bench.device.install(|| bvh::build(bench.scene, kind)))?, false)
        };
        row.is_same &= found == kept && was_cached == is_loaded;
        Ok(clock.last().elapsed_ns)
    })?;
    row.done.samples_ns = samples.pop().unwrap_or_default();
    row.skipped.samples_ns = samples.pop().unwrap_or_default();
    row.skipped.bytes = folder_bytes(cache)?;
    Ok(Some(row))
}
