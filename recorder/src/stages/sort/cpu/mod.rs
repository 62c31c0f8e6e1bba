//! The sort on the current rayon pool.
//!
//! Pairs are split by their highest digit, and what is longer than a core's own cache once more (`split`).
//! The rest one thread sorts there, lowest digit first (`local`). So memory beyond that cache is written
//! twice, where a sort by lowest digits alone writes it once for each; and once where so few bits are left that
//! a split writes the indices in order. A pair is one number, a word above its
//! index, and no two are equal: their order is that of a stable sort, which does not depend on threads.
//!
//! Of keys beyond 32 bits the word starts at the highest bit that differs. The rest of the bits are looked up
//! where words are equal.

use std::ops::Range;
use std::sync::atomic::{AtomicU32, AtomicU64, AtomicUsize, Ordering::Relaxed};

use formats::pages::{make_room, on_huge_pages};
use formats::prefetch::prefetch_to_write;
use rayon::prelude::*;

use super::Digits;
pub use keys::{Keys, Words};

mod keys;
mod local;
mod split;
mod together;

use local::Worker;
use split::{Digit, Split};

/// Indices of a cache line.
const LINE: usize = 64 / size_of::<u32>();
/// So many pairs of a thread must share a digit for what lies a line ahead in their stretch to be written soon.
const COMPANY: u64 = 100;

/// The canonical index of the ray at each place, written by many threads, each place once.
pub type Permutation = Vec<AtomicU32>;

/// A permutation of these canonical indices.
pub fn permutation_of(indices: &[u32]) -> Permutation {
    on_huge_pages(indices.iter().copied().map(AtomicU32::new))
}

/// Sorts, in memory that it keeps for the next time.
#[derive(Debug, Default)]
pub struct Sorter {
    /// Pairs, word above index, that splits read and write in turn.
    pairs: [Vec<AtomicU64>; 2],
    /// One for each thread.
    workers: Vec<Worker>,
    digits: Digits,
}

impl Sorter {
    /// One that sorts by these digits; the order is the same.
    pub fn by(digits: Digits) -> Self {
        Self { digits, ..Self::default() }
    }

    /// Makes and touches the memory that sorting such keys takes, and the permutation: the first touch of
    /// memory can take longer than the sort.
    ///
    /// # Panics
    /// If there are 2^32 keys or more.
    pub fn make_room(&mut self, keys: &Keys, permutation: &mut Permutation) {
        let count = keys.words.len();
        assert!(u32::try_from(count).is_ok(), "{count} keys are more than 32-bit indices can name");
        make_room(permutation, count);
        self.workers.resize_with(rayon::current_num_threads(), Worker::default);
        self.pairs.iter_mut().filter(|pairs| pairs.len() < count).for_each(|pairs| make_room(pairs, count));
    }

    /// Writes the permutation that sorts keys stably; [`Sorter::make_room`] comes first.
    ///
    /// # Panics
    /// If it did not.
    pub fn sort(&mut self, keys: &Keys, permutation: &mut Permutation) {
        let Self { pairs: [one, other], workers, digits } = self;
        let count = permutation.len();
        let memory = [&one[..count], &other[..count]];
        match &keys.words {
            Words::Narrow(words) => {
                // A look takes as long as it may save where one pass sorts all.
                let digits = if keys.bits <= split::MOST_BITS_OF_LAST { Digits::All } else { *digits };
                let varying = digits.varying(keys.bits, || varying_bits(words));
                let pairs = move |range: Range<usize>| {
                    words[range.clone()].iter().zip(range).map(|(&word, index)| pair(word, index))
                };
                let sort = Sort { pairs: memory, permutation, rest: None::<fn(usize) -> u32> };
                sort.all(workers, pairs, varying as u32);
            }
            Words::Wide(words) => {
                let varying = digits.varying(keys.bits, || varying_bits(words));
                let shift = (u64::BITS - varying.leading_zeros()).saturating_sub(u32::BITS);
                let pairs = move |range: Range<usize>| {
                    words[range.clone()]
                        .iter()
                        .zip(range)
                        .map(move |(&key, index)| pair((key >> shift) as u32, index))
                };
                let below = (1 << shift) - 1;
                let rest = move |index: usize| (words[index] & below) as u32;
                let rest = (varying & below != 0).then_some(rest);
                Sort { pairs: memory, permutation, rest }.all(workers, pairs, (varying >> shift) as u32);
            }
        }
    }
}

/// A word above the lower 32 bits of its index. All of them are there; cut off, they tell the compiler that the
/// higher half is the word alone, so that a loop over words makes no pairs.
fn pair(word: u32, index: usize) -> u64 {
    u64::from(word) << u32::BITS | u64::from(index as u32)
}

/// Puts a pair where it belongs. Checking every place would take up to a tenth of a sort's time.
///
/// # Safety
/// There is such a place.
unsafe fn put(pairs: &[AtomicU64], place: usize, pair: u64) {
    debug_assert!(place < pairs.len(), "place {place} of {}", pairs.len());
    // SAFETY: as above.
    unsafe { pairs.get_unchecked(place) }.store(pair, Relaxed);
}

/// The same for its index alone.
///
/// # Safety
/// There is such a place.
unsafe fn put_index(indices: &[AtomicU32], place: usize, pair: u64) {
    debug_assert!(place < indices.len(), "place {place} of {}", indices.len());
    // SAFETY: as above.
    unsafe { indices.get_unchecked(place) }.store(pair as u32, Relaxed);
}

fn stored(pairs: &[AtomicU64]) -> impl Iterator<Item = u64> + Clone {
    pairs.iter().map(|pair| pair.load(Relaxed))
}

/// The bits that are not the same in all keys.
fn varying_bits<T: Copy + Into<u64> + Sync>(keys: &[T]) -> u64 {
    let of_block =
        |keys: &[T]| keys.iter().fold((0, 0), |(ones, zeros), &key| (ones | key.into(), zeros | !key.into()));
    let all = keys.par_chunks(split::SMALLEST_BLOCK).map(of_block);
    let (ones, zeros) = all.reduce(|| (0, 0), |a, b| (a.0 | b.0, a.1 | b.1));
    ones & zeros
}

/// The bits that are not the same in the words of all pairs.
fn varying_bits_of(pairs: &[AtomicU64]) -> u32 {
    let of_block = |pairs: &[AtomicU64]| {
        let pairs = pairs.iter().map(|pair| pair.load(Relaxed));
        pairs.fold((0, 0), |(ones, zeros), pair| (ones | pair, zeros | !pair))
    };
    let all = pairs.par_chunks(split::SMALLEST_BLOCK).map(of_block);
    let (ones, zeros) = all.reduce(|| (0, 0), |a, b| (a.0 | b.0, a.1 | b.1));
    ((ones & zeros) >> u32::BITS) as u32
}

/// A sort under way.
#[derive(Clone, Copy)]
struct Sort<'a, R> {
    /// A split reads one of them and writes the other.
    pairs: [&'a [AtomicU64]; 2],
    permutation: &'a [AtomicU32],
    /// The word that an index is sorted by where the first one is the same.
    rest: Option<R>,
}

impl<R: Fn(usize) -> u32 + Copy + Send + Sync> Sort<'_, R> {
    /// Sorts what `pairs` gives for ranges of all indices.
    fn all<P: Iterator<Item = u64> + Clone>(
        &self,
        workers: &mut [Worker],
        pairs: impl Fn(Range<usize>) -> P + Copy + Send + Sync,
        varying: u32,
    ) {
        let all = 0..self.permutation.len();
        // A split is a pass more, which one thread does not win back.
        let most = if workers.len() == 1 { local::MOST } else { 2 * split::SMALLEST_BLOCK };
        match workers {
            [worker, ..] if all.len() <= most => {
                worker.sort(pairs(all), varying, self.rest, self.pairs[0], self.permutation)
            }
            _ => self.long(workers, all, 0, pairs, varying),
        }
    }

    /// Sorts the pairs that `read` gives for a range, by way of `self.pairs[target]`, from which they do not come.
    fn long<P: Iterator<Item = u64>>(
        &self,
        workers: &mut [Worker],
        range: Range<usize>,
        target: usize,
        read: impl Fn(Range<usize>) -> P + Copy + Send + Sync,
        varying: u32,
    ) {
        let (pairs, permutation) = (self.pairs[target], self.permutation);
        assert!(range.end <= pairs.len() && range.end <= permutation.len(), "room for all pairs");
        // What is read stays as it is: keys are borrowed, and pairs belong to the sorter, which writes the others.
        if self.rest.is_none()
            && let Some(digit) = Digit::last(varying, range.len(), workers.len())
        {
            let split = Split::of(workers, range, digit, read);
            let is_near = split.company >= COMPANY;
            split.scatter(read, move |place, pair| {
                if is_near {
                    prefetch_to_write(permutation, place + LINE);
                }
                // SAFETY: a split gives places of the range, which ends within the permutation.
                unsafe { put_index(permutation, place, pair) };
            });
            return;
        }
        let digit = Digit::first(varying, range.len());
        let below = varying & digit.below();
        let split = Split::of(workers, range, digit, read);
        let stretches = split.stretches();
        split.scatter(read, move |place, pair| {
            prefetch_to_write(pairs, place + split::AHEAD);
            // SAFETY: a split gives places of the range, which ends within the pairs.
            unsafe { put(pairs, place, pair) };
        });
        for range in stretches.ranges().filter(|range| range.len() > local::MOST) {
            self.long_again(workers, range, target);
        }
        let next = AtomicUsize::new(0);
        workers.par_iter_mut().for_each(|worker| {
            while let Some(range) = stretches.range(next.fetch_add(1, Relaxed)) {
                if (1..=local::MOST).contains(&range.len()) {
                    let (pairs, permutation) = (&pairs[range.clone()], &permutation[range]);
                    worker.sort(stored(pairs), below, self.rest, pairs, permutation);
                }
            }
        });
    }

    /// Sorts a range of the pairs in `self.pairs[source]`, which share all digits so far.
    fn long_again(&self, workers: &mut [Worker], range: Range<usize>, source: usize) {
        let pairs = self.pairs[source];
        let read = move |range: Range<usize>| stored(&pairs[range]);
        let varying = varying_bits_of(&pairs[range.clone()]);
        match self.rest {
            Some(rest) if varying == 0 => {
                pairs[range.clone()].par_iter().with_min_len(split::SMALLEST_BLOCK).for_each(|place| {
                    let index = place.load(Relaxed) as u32 as usize;
                    place.store(pair(rest(index), index), Relaxed);
                });
                Self { rest: None, ..*self }.long_again(workers, range, source);
            }
            _ => self.long(workers, range, 1 - source, read, varying),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stages::sort::test_keys::{self, expected};

    fn pool(threads: usize) -> rayon::ThreadPool {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap()
    }

    fn sorted(keys: &[u64], bits: u32) -> Vec<u32> {
        let (mut sorter, keys, mut permutation) = (Sorter::default(), Keys::of(keys, bits), Vec::new());
        sorter.make_room(&keys, &mut permutation);
        sorter.sort(&keys, &mut permutation);
        permutation.into_iter().map(AtomicU32::into_inner).collect()
    }

    #[test]
    fn keys_of_any_width_sort_like_the_standard_stable_sort() {
        let counts =
            [0, 1, 2, 3, 255, 256, 257, split::SMALLEST_BLOCK - 1, 2 * split::SMALLEST_BLOCK + 1, 100_003];
        for threads in [1, 2, 5] {
            for count in counts {
                for (what, bits, keys) in test_keys::cases(count) {
                    let found = pool(threads).install(|| sorted(&keys, bits));
                    assert!(found == expected(&keys), "{count} {what} of {bits} bits, {threads} threads");
                }
            }
        }
    }

    /// Longer than a core's cache, so that stretches are split again, by one word and by the other.
    #[test]
    fn keys_of_which_many_share_their_highest_bits() {
        const COUNT: usize = 3 * local::MOST;
        let low = test_keys::random(COUNT, 24, 1);
        let of = |high: fn(u64) -> u64| low.iter().zip(0..).map(|(low, at)| high(at) << 40 | low).collect();
        let cases: [(&str, Vec<u64>); 4] = [
            ("two values of the highest bits", of(|at| at % 2 * 0xFF_FFFF)),
            ("one of them nearly everywhere", of(|at| u64::from(at % 1000 == 0))),
            ("pairs", of(|at| at / 2)),
            ("runs of hundreds", of(|at| at / 700)),
        ];
        for threads in [1, 3] {
            for (what, keys) in &cases {
                let found = pool(threads).install(|| sorted(keys, 64));
                assert!(found == expected(keys), "{what}, {threads} threads");
            }
        }
    }

    #[test]
    fn sixteen_million_keys_and_more() {
        for bits in [15, 24] {
            let keys = test_keys::random((1 << 24) + 12_345, bits, 3);
            assert!(sorted(&keys, bits) == expected(&keys), "{bits} bits");
        }
    }
}
