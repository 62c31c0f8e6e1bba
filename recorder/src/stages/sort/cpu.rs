//! The sort on the current rayon pool.
//!
//! The order of a stable sort is unique, so it does not depend on how many threads there are.

use std::ops::Range;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering::Relaxed};

use rayon::prelude::*;

use super::{BINS, DIGIT_BITS, Digits};

/// Fewest pairs that are worth a thread of their own.
const SMALLEST_BLOCK: usize = 1 << 14;

/// How often each digit occurs.
type Counts = [u32; BINS];

/// Sorts, and keeps the memory in which it does for the next time: touching 16 bytes per key for
/// the first time can take longer than sorting them.
#[derive(Debug, Default)]
pub struct Sorter {
    /// Pairs, word above index, that passes read and write in turn.
    pairs: [Vec<AtomicU64>; 2],
    digits: Digits,
}

/// Keys in canonical order.
#[derive(Clone, Debug, PartialEq, Eq)]
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
}

impl Sorter {
    /// One that sorts by these digits; the order is the same.
    pub fn by(digits: Digits) -> Self {
        Self { digits, ..Self::default() }
    }

    /// The permutation that sorts keys stably.
    ///
    /// # Panics
    /// If there are 2^32 keys or more.
    pub fn sort(&mut self, keys: &Keys) -> Vec<u32> {
        match &keys.words {
            Words::Narrow(words) => {
                self.sort_words(words.len(), keys.bits, move |index| u64::from(words[index]))
            }
            Words::Wide(words) => self.sort_words(words.len(), keys.bits, move |index| words[index]),
        }
    }

    /// `key` gives the key of a canonical index. It is copied into inner loops, so that what it captures stays
    /// in registers; behind a reference the loops take twice as long.
    fn sort_words(
        &mut self,
        count: usize,
        bits: u32,
        key: impl Fn(usize) -> u64 + Copy + Send + Sync,
    ) -> Vec<u32> {
        assert!(u32::try_from(count).is_ok(), "{count} keys are more than 32-bit indices can name");
        let blocks = Blocks::of(count);
        let varying = self.digits.varying(bits, || varying_bits(&blocks, key));
        let shifts = differing_digits(varying, bits);
        let Some((&last, before)) = shifts.split_last() else {
            return (0..count as u32).collect();
        };
        let pair = move |index: usize, shift: u32| {
            let word = key(index) >> (shift / u32::BITS * u32::BITS);
            word << u32::BITS | index as u64
        };
        let [from, to] = &mut self.pairs;
        for (pass, (&shift, &next_shift)) in before.iter().zip(&shifts[1..]).enumerate() {
            make_room(to, count);
            let (source, target) = (&from[..], &to[..]);
            let write = move |place: usize, moved: u64| target[place].store(moved, Relaxed);
            // The last pass over the low word hands over the high words.
            let change_word = move |place, moved| write(place, pair(moved as u32 as usize, next_shift));
            let read = move |place: usize| source[place].load(Relaxed);
            let read_first = move |place| pair(place, shift);
            match (pass == 0, shift / u32::BITS == next_shift / u32::BITS) {
                (true, true) => blocks.scatter(shift, read_first, write),
                (true, false) => blocks.scatter(shift, read_first, change_word),
                (false, true) => blocks.scatter(shift, read, write),
                (false, false) => blocks.scatter(shift, read, change_word),
            }
            std::mem::swap(from, to);
        }
        let order: Vec<AtomicU32> = (0..count).into_par_iter().map(|_| AtomicU32::new(0)).collect();
        let (source, target) = (&from[..], &order[..]);
        let write = move |place: usize, moved: u64| target[place].store(moved as u32, Relaxed);
        match before {
            [] => blocks.scatter(last, move |place| pair(place, last), write),
            _ => blocks.scatter(last, move |place| source[place].load(Relaxed), write),
        }
        order.into_iter().map(AtomicU32::into_inner).collect()
    }
}

/// Makes an array of pairs large enough; zeros are written by all threads, since it is the first
/// touch of memory that takes its time.
fn make_room(pairs: &mut Vec<AtomicU64>, count: usize) {
    if pairs.len() < count {
        // Given back first: large arrays must not be there twice.
        *pairs = Vec::new();
        *pairs = (0..count).into_par_iter().map(|_| AtomicU64::new(0)).collect();
    }
}

/// The bits that are not the same in all keys.
fn varying_bits(blocks: &Blocks, key: impl Fn(usize) -> u64 + Copy + Send + Sync) -> u64 {
    let of_block = move |range: Range<usize>| {
        range.fold((0, 0), |(ones, zeros), index| (ones | key(index), zeros | !key(index)))
    };
    let ranges = blocks.ranges.par_iter().cloned();
    let (ones, zeros) = ranges.map(of_block).reduce(|| (0, 0), |a, b| (a.0 | b.0, a.1 | b.1));
    ones & zeros
}

/// Shifts of the digits in which some bit varies, lowest first.
fn differing_digits(varying: u64, bits: u32) -> Vec<u32> {
    (0..bits)
        .step_by(DIGIT_BITS as usize)
        .filter(|&shift| !((varying >> shift) as usize).is_multiple_of(BINS))
        .collect()
}

/// Keys cut into stretches, one per thread.
struct Blocks {
    ranges: Vec<Range<usize>>,
}

impl Blocks {
    fn of(count: usize) -> Self {
        let blocks = rayon::current_num_threads().min(count / SMALLEST_BLOCK).max(1);
        let block = count.div_ceil(blocks).max(1);
        Self { ranges: (0..count).step_by(block).map(|first| first..count.min(first + block)).collect() }
    }

    /// One pass: `read` gives the pair at a place, `write` puts it where its digit belongs, pairs
    /// of one digit in the order in which they were.
    fn scatter(
        &self,
        shift: u32,
        read: impl Fn(usize) -> u64 + Copy + Send + Sync,
        write: impl Fn(usize, u64) + Copy + Send + Sync,
    ) {
        let shift_in_pair = u32::BITS + shift % u32::BITS;
        let ranges = self.ranges.par_iter();
        let mut places: Vec<Counts> =
            ranges.clone().map(move |range| count_digits(range.clone(), shift_in_pair, read)).collect();
        counts_to_places(&mut places);
        ranges.zip(places).for_each(move |(range, places)| {
            scatter_block(range.clone(), shift_in_pair, places, read, write);
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
                    let found = pool(threads).install(|| Sorter::default().sort(&Keys::of(&keys, bits)));
                    assert!(found == expected(&keys), "{count} {what} of {bits} bits, {threads} threads");
                }
            }
        }
    }

    #[test]
    fn sixteen_million_keys_and_more() {
        let keys = test_keys::random((1 << 24) + 12_345, 24, 3);
        let found = Sorter::default().sort(&Keys::of(&keys, 24));
        assert!(found == expected(&keys));
    }
}
