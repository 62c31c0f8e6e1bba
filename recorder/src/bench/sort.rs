//! Sort throughput: random keys with their indices, n and key bits interleaved.

use anyhow::Result;
use formats::bench_result::{BenchResult, Rows, SortRow};
use std::sync::atomic::Ordering::Relaxed;

use super::result;
use crate::clock::Clock;
use crate::machine::{self, Device};
use crate::measure::{in_rounds, sampled};
use crate::options::DeviceOptions;
use crate::stages::sort::cpu::Permutation;
use crate::stages::sort::gpu::Sorter;
use crate::stages::sort::{self, Digits};

/// What to measure.
#[derive(Clone, Debug)]
pub struct SortBench {
    /// Numbers of keys.
    pub counts: Vec<u64>,
    /// Bits of a key, 8 to 64.
    pub key_bits: Vec<u32>,
    /// Timed repeats.
    pub repeats: u32,
    /// Where to run.
    pub device: DeviceOptions,
}

/// Sorts random keys.
///
/// # Errors
/// If there is no such device or the keys do not fit it.
pub fn run(bench: &SortBench) -> Result<BenchResult> {
    let device = machine::open(&bench.device)?;
    let rows = match &device {
        Device::Cpu(cpu) => cpu.pool.install(|| {
            let mut sorter = sort::cpu::Sorter::default();
            let (mut clock, mut order) = (Clock::of_processor(), Permutation::new());
            measure(bench, |keys, bits| {
                Ok(on_threads(
                    &mut clock,
                    &mut sorter,
                    &mut order,
                    &sort::cpu::Keys::of(&cut(keys, bits), bits),
                ))
            })
        })?,
        Device::Gpu(gpu) => {
            let mut sorter = Sorter::new(&gpu.gpu)?;
            let most = bench.counts.iter().max().map_or(0, |&most| most as usize);
            let order = gpu.gpu.array("sort::permutation", most)?;
            // In the same memory each time: drivers clear what is new while it is used.
            let mut uploaded = sort::gpu::Keys::new(&gpu.gpu, most)?;
            measure(bench, |keys, bits| {
                uploaded.fill(&gpu.gpu, &cut(keys, bits), bits)?;
                // They must have arrived before the clock starts.
                let arrived = gpu.gpu.queue().submit([]);
                gpu.gpu.wait("uploading keys", Some(arrived))?;
                Ok(sorter.sort(&gpu.gpu, &uploaded, &order)?)
            })?
        }
    };
    Ok(result(&device, Rows::Sort(rows)))
}

/// Every n, and of each every width in rounds. Keys of one n are made once.
fn measure(bench: &SortBench, mut sort_ns: impl FnMut(&[u64], u32) -> Result<u64>) -> Result<Vec<SortRow>> {
    let mut rows = Vec::new();
    for &n in &bench.counts {
        let (keys, widths) = (random_keys(n as usize), &bench.key_bits);
        let samples = sampled(widths.len(), bench.repeats, n, |at| sort_ns(&keys, widths[at]))?;
        let row = |(&key_bits, samples_ns)| SortRow { n, key_bits, samples_ns };
        rows.extend(widths.iter().zip(samples).map(row));
    }
    Ok(rows)
}

fn on_threads(
    clock: &mut Clock,
    sorter: &mut sort::cpu::Sorter,
    order: &mut Permutation,
    keys: &sort::cpu::Keys,
) -> u64 {
    sorter.make_room(keys, order);
    clock.time(|| sorter.sort(keys, order));
    clock.last().elapsed_ns
}

/// The highest `bits` bits of keys of 64.
fn cut(keys: &[u64], bits: u32) -> Vec<u64> {
    keys.iter().map(|key| key >> (64 - bits)).collect()
}

/// Times of a sort and the order that it gave.
#[derive(Clone, Debug, Default)]
pub(super) struct SortedBy {
    pub(super) samples_ns: Vec<u64>,
    pub(super) order: Vec<u32>,
}

/// Sorts keys of 32 bits by the digits that differ and by all, in rounds.
///
/// # Errors
/// If the keys do not fit the device.
pub(super) fn sorted_by_both(device: &Device, keys: &[u64], repeats: u32) -> Result<[SortedBy; 2]> {
    let choices = [Digits::Differing, Digits::All];
    match device {
        Device::Cpu(cpu) => cpu.pool.install(|| {
            let keys = sort::cpu::Keys::of(keys, u32::BITS);
            let mut sorters = choices.map(sort::cpu::Sorter::by);
            let (mut clock, mut order) = (Clock::of_processor(), Permutation::new());
            sorted_in_rounds(repeats, |at| {
                let elapsed_ns = on_threads(&mut clock, &mut sorters[at], &mut order, &keys);
                Ok((elapsed_ns, order.iter().map(|place| place.load(Relaxed)).collect()))
            })
        }),
        Device::Gpu(device) => {
            let gpu = &device.gpu;
            let keys = sort::gpu::Keys::upload(gpu, keys, u32::BITS)?;
            let [one, other] = choices.map(|digits| Sorter::new(gpu).map(|sorter| sorter.by(digits)));
            let mut sorters = [one?, other?];
            let order = gpu.array("sort::permutation", keys.count)?;
            sorted_in_rounds(repeats, |at| {
                let elapsed_ns = sorters[at].sort(gpu, &keys, &order)?;
                Ok((elapsed_ns, gpu.read_vec(&order)?))
            })
        }
    }
}

fn sorted_in_rounds(
    repeats: u32,
    mut sort: impl FnMut(usize) -> Result<(u64, Vec<u32>)>,
) -> Result<[SortedBy; 2]> {
    let mut sorted = <[SortedBy; 2]>::default();
    in_rounds(sorted.len(), repeats, 0, |at, round| {
        let (elapsed_ns, order) = sort(at)?;
        sorted[at].samples_ns.extend(round.map(|_| elapsed_ns));
        sorted[at].order = order;
        Ok(())
    })?;
    Ok(sorted)
}

/// The same keys on every machine.
pub(super) fn random_keys(count: usize) -> Vec<u64> {
    let mut random = fastrand::Rng::with_seed(0);
    (0..count).map(|_| random.u64(..)).collect()
}
