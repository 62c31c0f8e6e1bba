//! What is skipped of queues, keys and tables.

use anyhow::Result;
use formats::bench_result::skip::{Cost, SkipRow};
use formats::length_table::LengthCell;
use formats::manifest::QueueId;
use formats::ray::Kind;

use super::super::backends::{self, OnBackend};
use super::super::sort::{random_keys, sorted_by_both};
use super::Bench;
use crate::backends::{Array, Backend, RecordedRays, Table, collected, picture};
use crate::clock::Clock;
use crate::measure::sampled;
use crate::stages::trace::Order;
use crate::wavefront;

/// Keys that are sorted.
const KEYS: usize = 1 << 18;
/// Keys of 32 bits in which only the first and the third digit differ.
const DIFFERING: u64 = 0xff00_ff00;

/// What is skipped in every scene, on its paths.
pub(super) fn rows(bench: Bench<'_>) -> Result<Vec<SkipRow>> {
    let kernel = bench.device.kernel(&bench.run.device);
    let paths = OverPaths { bench };
    let mut rows = backends::measure(bench.device, bench.scene, bench.setup, kernel, paths)?;
    let random = random_keys(KEYS);
    let constant_digits: Vec<u64> = random.iter().map(|key| (key >> 32) & DIFFERING).collect();
    let (skipped, done, is_same) = sorts(bench, &constant_digits)?;
    let row = bench.row("radix passes over constant digits", "sort of 2^18 keys, 2 of 4 digits", "order");
    rows.push(SkipRow { skipped, done, is_same, ..row });
    // What `unsorted` would need if it were a method like the others.
    let (_, mut done, is_same) = sorts(bench, &vec![0; KEYS])?;
    done.bytes = 2 * (KEYS * size_of::<u32>()) as u64;
    let row = bench.row("keys and order of unsorted", "sort of 2^18 equal keys", "order");
    rows.push(SkipRow { done, is_same, ..row });
    Ok(rows)
}

/// Costs with the differing digits and with all, in turns, and whether the order is the same.
fn sorts(bench: Bench<'_>, keys: &[u64]) -> Result<(Cost, Cost, bool)> {
    let [differing, all] = sorted_by_both(bench.device, keys, bench.run.repeats)?;
    let cost = |samples_ns| Cost { samples_ns, bytes: 0 };
    Ok((cost(differing.samples_ns), cost(all.samples_ns), differing.order == all.order))
}

struct OverPaths<'a> {
    bench: Bench<'a>,
}

impl OnBackend for OverPaths<'_> {
    type Output = Vec<SkipRow>;

    fn run<B: Backend>(self, backend: &mut B) -> Result<Vec<SkipRow>> {
        wavefront::run(backend, 0..1, self.bench.run.bounces, &mut ())?;
        let bounce = self.empty_bounce(backend)?;
        let mut rows = vec![bounce];
        for kind in Kind::ALL {
            rows.push(self.untouched_cells(backend, kind)?);
        }
        Ok(rows)
    }
}

/// A queue without rays, with the length table of its kind or without.
fn no_rays(bounce: u32, kind: Kind, lengths: Option<&[LengthCell]>) -> RecordedRays<'_> {
    RecordedRays { id: QueueId { pass: 0, bounce, kind }, rays: &[], path_ids: &[], lights: &[], lengths }
}

impl OverPaths<'_> {
    /// The verbs of a bounce to which no ray has come, which the loop does not run.
    fn empty_bounce<B: Backend>(&self, backend: &mut B) -> Result<SkipRow> {
        let mut row = self.bench.row("a bounce without live rays", "all stages of the bounce", "picture");
        let before = picture(backend, 1)?;
        // On the processor's clock: what no ray needs is the way to the device and back.
        let mut clock = Clock::of_processor();
        let samples = sampled(1, self.bench.run.repeats, 0, |_| {
            let rays = backend.upload(no_rays(self.bench.run.bounces, Kind::Closest, None))?;
            clock.time(|| {
                let hits = backend.trace(&rays, Order::Stored)?;
                backend.accumulate(&rays, &hits, Table::Learnt)?;
                let shadow = backend.shade(&rays, &hits)?.shadow;
                let occlusion = backend.trace(&shadow, Order::Stored)?;
                backend.accumulate(&shadow, &occlusion, Table::Learnt)?;
                backend.add_light(&shadow, &occlusion)
            })?;
            Ok(clock.last().elapsed_ns)
        })?;
        row.done.samples_ns = samples.concat();
        row.is_same = picture(backend, 1)? == before;
        Ok(row)
    }

    /// A table that is stored by its touched cells, and is the same when it is loaded.
    fn untouched_cells<B: Backend>(&self, backend: &mut B, kind: Kind) -> Result<SkipRow> {
        let what = format!("untouched cells of the {kind} table");
        let mut row = self.bench.row(&what, "lengths.npy", "table");
        let touched: Vec<LengthCell> = collected(backend, Array::Lengths(kind))?;
        row.skipped.bytes = size_of_val(&*touched) as u64;
        row.done.bytes = (size_of::<LengthCell>() as u64) << self.bench.setup.table_bits;
        backend.upload(no_rays(0, kind, Some(&touched)))?;
        row.is_same = collected::<LengthCell, B>(backend, Array::Lengths(kind))? == touched;
        Ok(row)
    }
}
