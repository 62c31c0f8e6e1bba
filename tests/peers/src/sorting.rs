//! Our sort beside crates, on random keys with 32-bit values: their canonical indices.

use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use rayon::prelude::*;
use rdst::tuner::{Algorithm, Tuner, TuningParams};
use rdst::{RadixKey, RadixSort as _};
use recorder::stages::sort::cpu::{Keys, Permutation, Sorter};
use voracious_radix_sort::{RadixSort as _, Radixable};

use crate::contest::{Contest, Row, Side};

/// A key and its value. Pairs are ordered by both, so that a comparison sort of them is stable.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
struct Pair<K> {
    key: K,
    index: u32,
}

impl RadixKey for Pair<u32> {
    const LEVELS: usize = 4;

    #[inline]
    fn get_level(&self, level: usize) -> u8 {
        (self.key >> (8 * level)) as u8
    }
}

impl RadixKey for Pair<u64> {
    const LEVELS: usize = 8;

    #[inline]
    fn get_level(&self, level: usize) -> u8 {
        (self.key >> (8 * level)) as u8
    }
}

impl Radixable<u32> for Pair<u32> {
    type Key = u32;

    #[inline]
    fn key(&self) -> u32 {
        self.key
    }
}

impl Radixable<u64> for Pair<u64> {
    type Key = u64;

    #[inline]
    fn key(&self) -> u64 {
        self.key
    }
}

/// Sorts pairs in place on the threads of the current pool, or as many of its own.
type PairSort<K> = fn(&mut [Pair<K>]);

/// Sorts so many random keys of 64 bits, and the higher 32 of each.
pub fn compare(count: usize, is_wanted: &dyn Fn(&str) -> bool, rounds: usize) -> Vec<Row> {
    let mut random = fastrand::Rng::with_seed(0);
    let keys: Vec<u64> = (0..count).map(|_| random.u64(..)).collect();
    compare_on(&keys, is_wanted, rounds)
}

fn compare_on(keys: &[u64], is_wanted: &dyn Fn(&str) -> bool, rounds: usize) -> Vec<Row> {
    let narrow: Vec<u64> = keys.iter().map(|key| key >> 32).collect();
    let pair = |(key, index): (&u64, u32)| Pair { key: *key as u32, index };
    let narrow_pairs: Vec<Pair<u32>> = narrow.iter().zip(0..).map(pair).collect();
    let wide_pairs: Vec<Pair<u64>> = keys.iter().zip(0..).map(|(&key, index)| Pair { key, index }).collect();
    let mut rows = sort(Keys::of(&narrow, u32::BITS), &narrow_pairs, is_wanted, rounds);
    rows.extend(sort(Keys::of(keys, u64::BITS), &wide_pairs, is_wanted, rounds));
    rows
}

/// Those of other people, by crate or function.
fn peers<K>() -> [(&'static str, PairSort<K>); 4]
where
    K: voracious_radix_sort::RadixKey + Ord + Copy + Send,
    Pair<K>: RadixKey + Radixable<K> + Send + Sync,
{
    [
        ("rdst", by_rdst),
        ("rdst, stable", by_stable_rdst),
        ("voracious", by_voracious),
        ("sort_unstable", by_comparison),
    ]
}

fn by_rdst<K>(pairs: &mut [Pair<K>])
where
    Pair<K>: RadixKey + Copy + Send + Sync,
{
    let sort = pairs.radix_sort_builder();
    match rayon::current_num_threads() {
        1 => sort.with_single_threaded_tuner().with_parallel(false).sort(),
        _ => sort.sort(),
    }
}

/// rdst kept from its sorts that are not stable.
fn by_stable_rdst<K>(pairs: &mut [Pair<K>])
where
    Pair<K>: RadixKey + Copy + Send + Sync,
{
    let is_parallel = rayon::current_num_threads() > 1;
    pairs.radix_sort_builder().with_tuner(&StableTuner).with_parallel(is_parallel).sort();
}

/// Least significant digit first, whatever rdst would choose.
struct StableTuner;

impl Tuner for StableTuner {
    fn pick_algorithm(&self, _: &TuningParams, _: &[usize]) -> Algorithm {
        if rayon::current_num_threads() > 1 { Algorithm::MtLsb } else { Algorithm::Lsb }
    }
}

fn by_voracious<K: voracious_radix_sort::RadixKey>(pairs: &mut [Pair<K>])
where
    Pair<K>: Radixable<K>,
{
    match rayon::current_num_threads() {
        1 => pairs.voracious_stable_sort(),
        threads => pairs.voracious_mt_sort(threads),
    }
}

fn by_comparison<K: Ord + Copy + Send>(pairs: &mut [Pair<K>]) {
    match rayon::current_num_threads() {
        1 => pairs.sort_unstable(),
        _ => pairs.par_sort_unstable(),
    }
}

/// Ours takes keys and gives a permutation, theirs take pairs that were copied before the clock starts.
fn sort<K>(keys: Keys, pairs: &[Pair<K>], is_wanted: &dyn Fn(&str) -> bool, rounds: usize) -> Vec<Row>
where
    K: voracious_radix_sort::RadixKey + Ord + Copy + Send,
    Pair<K>: RadixKey + Radixable<K> + Send + Sync,
{
    let sorts: Vec<_> = peers::<K>().into_iter().filter(|(name, _)| is_wanted(name)).collect();
    let (mut sorter, mut order) = (Sorter::default(), Permutation::new());
    sorter.make_room(&keys, &mut order);
    sorter.sort(&keys, &mut order);
    let mut sorted = pairs.to_vec();
    let out_of_order = |(_, sort): &(&str, PairSort<K>)| {
        sorted.copy_from_slice(pairs);
        sort(&mut sorted);
        let is_elsewhere = |(pair, place): &(&Pair<K>, &AtomicU32)| pair.index != place.load(Relaxed);
        sorted.iter().zip(&order).filter(is_elsewhere).count()
    };
    let differing = std::iter::once(0).chain(sorts.iter().map(out_of_order)).collect();
    let ours = std::iter::once(("ours".to_owned(), Side::Ours));
    let contest = Contest {
        subject: "sorting",
        task: format!("{} bits", keys.bits),
        items: pairs.len(),
        contestants: ours.chain(sorts.iter().map(|(name, _)| ((*name).to_owned(), Side::Peer))).collect(),
        differing,
    };
    contest.rows(rounds, |at, clock| match at.checked_sub(1) {
        None => clock.time(|| sorter.sort(&keys, &mut order)),
        Some(peer) => {
            sorted.copy_from_slice(pairs);
            clock.time(|| (sorts[peer].1)(&mut sorted));
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Few values, so that there are equal keys; on one thread the crates are asked for stable sorts.
    #[test]
    fn stable_sorts_come_to_our_order() {
        let mut random = fastrand::Rng::with_seed(1);
        let keys: Vec<u64> = (0..30_000).map(|_| random.u64(..100) << 32 | 7).collect();
        for threads in [1, 2] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let rows = pool.install(|| compare_on(&keys, &|_| true, 1));
            assert_eq!(rows.len(), 2 * 6, "ours, four others and the control, keys of 32 and 64 bits");
            let is_stable =
                |name: &str| threads == 1 || ["ours", "rdst, stable", "sort_unstable"].contains(&name);
            let wrong: Vec<&Row> =
                rows.iter().filter(|row| is_stable(&row.name) && row.differing > 0).collect();
            assert!(wrong.is_empty(), "{threads} threads: {wrong:?}");
        }
    }
}
