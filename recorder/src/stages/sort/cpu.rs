//! The sort on the current rayon pool.
//!
//! The order of a stable sort is unique, so it does not depend on how many threads there are.

use std::ops::Range;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering::Relaxed};

use rayon::prelude::*;

use super::{BINS, DIGIT_BITS, Digits};

/// Fewest pairs that are worth a thread of their own.
const SMALLEST_BLOCK: usize = 1 << 14;
/// Digits of the widest keys.
const MOST_DIGITS: usize = (u64::BITS / DIGIT_BITS) as usize;

/// How often each digit occurs.
type Counts = [u32; BINS];

/// The canonical index of the ray at each place, written by many threads, each place once.
pub type Permutation = Vec<AtomicU32>;

/// A permutation of these canonical indices.
pub fn permutation_of(indices: &[u32]) -> Permutation {
    indices.iter().copied().map(AtomicU32::new).collect()
}

/// Sorts, in memory that it keeps for the next time.
#[derive(Debug, Default)]
pub struct Sorter {
    /// Pairs, word above index, that passes read and write in turn.
    pairs: [Vec<AtomicU64>; 2],
    /// Of each block.
    counts: Vec<Counts>,
    digits: Digits,
}

/// Keys in canonical order.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Keys {
    /// Bits of a key, 1 to 64; all above are 0.
    pub bits: u32,
    /// The keys.
    pub words: Words,
}

/// Keys in the width that a dump stores.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Words {
    /// Up to 32 bits.
    Narrow(Vec<u32>),
    /// Up to 64 bits.
    Wide(Vec<u64>),
}

impl Keys {
    /// Keys of `bits` bits in their width.
    pub fn of(keys: &[u64], bits: u32) -> Self {
        let words = if bits <= u32::BITS {
            Words::Narrow(keys.iter().map(|&key| key as u32).collect())
        } else {
            Words::Wide(keys.to_vec())
        };
        Self { bits, words }
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        match &self.words {
            Words::Narrow(words) => words.len(),
            Words::Wide(words) => words.len(),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Makes and touches room for so many keys of any value.
    pub fn make_room(&mut self, count: usize, bits: u32) {
        self.bits = bits;
        match &mut self.words {
            Words::Narrow(words) if bits <= u32::BITS => words.resize(count, 0),
            Words::Wide(words) if bits > u32::BITS => words.resize(count, 0),
            words if bits <= u32::BITS => *words = Words::Narrow(vec![0; count]),
            words => *words = Words::Wide(vec![0; count]),
        }
    }
}

impl Default for Words {
    fn default() -> Self {
        Self::Narrow(Vec::new())
    }
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
        let count = keys.len();
        assert!(u32::try_from(count).is_ok(), "{count} keys are more than 32-bit indices can name");
        permutation.resize_with(count, AtomicU32::default);
        self.counts.resize(Blocks::of(count).number(), [0; BINS]);
        if keys.bits > DIGIT_BITS {
            self.pairs.iter_mut().filter(|pairs| pairs.len() < count).for_each(|pairs| {
                pairs.resize_with(count, AtomicU64::default);
            });
        }
    }

    /// Writes the permutation that sorts keys stably; [`Sorter::make_room`] comes first.
    ///
    /// # Panics
    /// If it did not.
    pub fn sort(&mut self, keys: &Keys, permutation: &mut Permutation) {
        match &keys.words {
            Words::Narrow(words) => {
                self.sort_words(keys.bits, move |index| u64::from(words[index]), permutation);
            }
            Words::Wide(words) => self.sort_words(keys.bits, move |index| words[index], permutation),
        }
    }

    /// The permutation that sorts keys stably, in memory of its own.
    pub fn sorted(&mut self, keys: &Keys) -> Vec<u32> {
        let mut permutation = Permutation::new();
        self.make_room(keys, &mut permutation);
        self.sort(keys, &mut permutation);
        permutation.into_iter().map(AtomicU32::into_inner).collect()
    }

    /// `key` gives the key of a canonical index. It is copied into inner loops, so that what it captures stays
    /// in registers; behind a reference the loops take twice as long.
    fn sort_words(
        &mut self,
        bits: u32,
        key: impl Fn(usize) -> u64 + Copy + Send + Sync,
        permutation: &mut Permutation,
    ) {
        let Self { pairs: [from, to], counts, digits } = self;
        let blocks = Blocks::of(permutation.len());
        let varying = digits.varying(bits, || varying_bits(&blocks, key));
        let mut digits = [0; MOST_DIGITS];
        let shifts = differing_digits(varying, bits, &mut digits);
        let Some((&last, before)) = shifts.split_last() else {
            permutation.iter().zip(0..).for_each(|(place, index)| place.store(index, Relaxed));
            return;
        };
        let pair = move |index: usize, shift: u32| {
            let word = key(index) >> (shift / u32::BITS * u32::BITS);
            word << u32::BITS | index as u64
        };
        for (pass, (&shift, &next_shift)) in before.iter().zip(&shifts[1..]).enumerate() {
            let (source, target) = (&from[..], &to[..]);
            let write = move |place: usize, moved: u64| target[place].store(moved, Relaxed);
            // The last pass over the low word hands over the high words.
            let change_word = move |place, moved| write(place, pair(moved as u32 as usize, next_shift));
            let read = move |place: usize| source[place].load(Relaxed);
            let read_first = move |place| pair(place, shift);
            match (pass == 0, shift / u32::BITS == next_shift / u32::BITS) {
                (true, true) => blocks.scatter(counts, shift, read_first, write),
                (true, false) => blocks.scatter(counts, shift, read_first, change_word),
                (false, true) => blocks.scatter(counts, shift, read, write),
                (false, false) => blocks.scatter(counts, shift, read, change_word),
            }
            std::mem::swap(from, to);
        }
        let (source, target) = (&from[..], &permutation[..]);
        let write = move |place: usize, moved: u64| target[place].store(moved as u32, Relaxed);
        match before {
            [] => blocks.scatter(counts, last, move |place| pair(place, last), write),
            _ => blocks.scatter(counts, last, move |place| source[place].load(Relaxed), write),
        }
    }
}

/// The bits that are not the same in all keys.
fn varying_bits(blocks: &Blocks, key: impl Fn(usize) -> u64 + Copy + Send + Sync) -> u64 {
    let of_block = move |block: usize| {
        let range = blocks.range(block);
        range.fold((0, 0), |(ones, zeros), index| (ones | key(index), zeros | !key(index)))
    };
    let all = (0..blocks.number()).into_par_iter().map(of_block);
    let (ones, zeros) = all.reduce(|| (0, 0), |a, b| (a.0 | b.0, a.1 | b.1));
    ones & zeros
}

/// Shifts of the digits in which some bit varies, lowest first.
fn differing_digits(varying: u64, bits: u32, shifts: &mut [u32; MOST_DIGITS]) -> &[u32] {
    let mut number = 0;
    for shift in (0..bits).step_by(DIGIT_BITS as usize) {
        if !((varying >> shift) as usize).is_multiple_of(BINS) {
            shifts[number] = shift;
            number += 1;
        }
    }
    &shifts[..number]
}

/// Keys cut into stretches, one per thread.
#[derive(Clone, Copy)]
struct Blocks {
    count: usize,
    block: usize,
}

impl Blocks {
    fn of(count: usize) -> Self {
        let blocks = rayon::current_num_threads().min(count / SMALLEST_BLOCK).max(1);
        Self { count, block: count.div_ceil(blocks).max(1) }
    }

    fn number(&self) -> usize {
        self.count.div_ceil(self.block)
    }

    fn range(&self, block: usize) -> Range<usize> {
        let first = block * self.block;
        first..self.count.min(first + self.block)
    }

    /// One pass: `read` gives the pair at a place, `write` puts it where its digit belongs, pairs
    /// of one digit in the order in which they were. `counts` has room for each block.
    fn scatter(
        &self,
        counts: &mut [Counts],
        shift: u32,
        read: impl Fn(usize) -> u64 + Copy + Send + Sync,
        write: impl Fn(usize, u64) + Copy + Send + Sync,
    ) {
        let shift_in_pair = u32::BITS + shift % u32::BITS;
        let counts = &mut counts[..self.number()];
        counts.par_iter_mut().enumerate().for_each(|(block, counts)| {
            *counts = count_digits(self.range(block), shift_in_pair, read);
        });
        counts_to_places(counts);
        // Each thread counts in a copy of its own, which no other one's stores can be in the way of.
        counts.par_iter().enumerate().for_each(|(block, places)| {
            scatter_block(self.range(block), shift_in_pair, *places, read, write);
        });
    }
}

fn count_digits(range: Range<usize>, shift: u32, read: impl Fn(usize) -> u64) -> Counts {
    let mut counts = [0; BINS];
    for place in range {
        counts[digit_of(read(place), shift)] += 1;
    }
    counts
}

fn scatter_block(
    range: Range<usize>,
    shift: u32,
    mut places: Counts,
    read: impl Fn(usize) -> u64,
    write: impl Fn(usize, u64),
) {
    for place in range {
        let pair = read(place);
        let slot = &mut places[digit_of(pair, shift)];
        write(*slot as usize, pair);
        *slot += 1;
    }
}

fn digit_of(pair: u64, shift: u32) -> usize {
    (pair >> shift) as usize % BINS
}

/// From counts per block to the place of each block's first pair of each digit.
fn counts_to_places(blocks: &mut [Counts]) {
    let mut place = 0;
    for digit in 0..BINS {
        for block in &mut *blocks {
            place += std::mem::replace(&mut block[digit], place);
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

    #[test]
    fn keys_of_any_width_sort_like_the_standard_stable_sort() {
        let counts = [0, 1, 2, 3, 255, 256, 257, SMALLEST_BLOCK - 1, 2 * SMALLEST_BLOCK + 1, 100_003];
        for threads in [1, 2, 5] {
            for count in counts {
                for (what, bits, keys) in test_keys::cases(count) {
                    let found = pool(threads).install(|| Sorter::default().sorted(&Keys::of(&keys, bits)));
                    assert!(found == expected(&keys), "{count} {what} of {bits} bits, {threads} threads");
                }
            }
        }
    }

    #[test]
    fn sixteen_million_keys_and_more() {
        let keys = test_keys::random((1 << 24) + 12_345, 24, 3);
        let found = Sorter::default().sorted(&Keys::of(&keys, 24));
        assert!(found == expected(&keys));
    }
}
