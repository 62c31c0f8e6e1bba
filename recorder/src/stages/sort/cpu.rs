//! The sort on the current rayon pool.
//!
//! The order of a stable sort is unique, so it does not depend on how many threads there are.

use std::sync::atomic::{AtomicU32, AtomicU64, Ordering::Relaxed};

use rayon::prelude::*;

use super::{BINS, DIGIT_BITS, DIGITS_PER_WORD};

/// Fewest pairs that are worth a thread of their own.
const SMALLEST_BLOCK: usize = 1 << 14;

/// How often each digit occurs.
type Counts = [u32; BINS];

/// The permutation that sorts keys of `bits` bits (1 to 32); higher bits must be 0.
///
/// # Panics
/// If there are 2^32 keys or more.
pub fn sort_u32(keys: &[u32], bits: u32) -> Vec<u32> {
    sort_words(keys.len(), bits, |index| u64::from(keys[index]))
}

/// The permutation that sorts keys of `bits` bits (1 to 64); higher bits must be 0.
///
/// # Panics
/// If there are 2^32 keys or more.
pub fn sort_u64(keys: &[u64], bits: u32) -> Vec<u32> {
    sort_words(keys.len(), bits, |index| keys[index])
}

fn sort_words(count: usize, bits: u32, key: impl Fn(usize) -> u64 + Sync) -> Vec<u32> {
    assert!(u32::try_from(count).is_ok(), "{count} keys are more than 32-bit indices can name");
    let varying = varying_bits(count, &key);
    let low = digits(varying as u32);
    let high = if bits > u32::BITS { digits((varying >> u32::BITS) as u32) } else { Vec::new() };
    let mut sorter = Sorter::new(count);
    sorter.sort_by_word(&low, |index| key(index) as u32);
    sorter.sort_by_word(&high, |index| (key(index) >> u32::BITS) as u32);
    sorter.permutation.unwrap_or_else(|| (0..count as u32).collect())
}

/// The bits that are not the same in all keys.
fn varying_bits(count: usize, key: &(impl Fn(usize) -> u64 + Sync)) -> u64 {
    let fold = |(ones, zeros): (u64, u64), index| (ones | key(index), zeros | !key(index));
    let (ones, zeros) = (0..count)
        .into_par_iter()
        .with_min_len(SMALLEST_BLOCK)
        .fold(|| (0, 0), fold)
        .reduce(|| (0, 0), |a, b| (a.0 | b.0, a.1 | b.1));
    ones & zeros
}

/// Shifts of the digits of a word in which some bit varies.
fn digits(varying: u32) -> Vec<u32> {
    (0..DIGITS_PER_WORD)
        .map(|digit| digit * DIGIT_BITS)
        .filter(|&shift| digit_of(varying, shift) != 0)
        .collect()
}

fn digit_of(word: u32, shift: u32) -> usize {
    (word >> shift) as usize % BINS
}

/// The order so far and the room to make a new one in.
struct Sorter {
    count: usize,
    /// Pairs per block; every block is one thread's work.
    block: usize,
    /// None before the first pass: canonical order.
    permutation: Option<Vec<u32>>,
    /// Pairs, key above index, that passes read and write in turn.
    pairs: [Vec<AtomicU64>; 2],
}

impl Sorter {
    fn new(count: usize) -> Self {
        let blocks = rayon::current_num_threads().min(count / SMALLEST_BLOCK).max(1);
        Self {
            count,
            block: count.div_ceil(blocks).max(1),
            permutation: None,
            pairs: [Vec::new(), Vec::new()],
        }
    }

    /// Sorts the order so far by the digits at these shifts, lowest first.
    fn sort_by_word(&mut self, shifts: &[u32], word: impl Fn(usize) -> u32 + Sync) {
        let Some((&last, before)) = shifts.split_last() else {
            return;
        };
        let canonical = |place: usize| match &self.permutation {
            None => place as u32,
            Some(permutation) => permutation[place],
        };
        let first_pair = |place: usize| {
            let index = canonical(place);
            u64::from(word(index as usize)) << u32::BITS | u64::from(index)
        };
        let [from, to] = &mut self.pairs;
        for (pass, &shift) in before.iter().enumerate() {
            if to.len() < self.count {
                *to = zeros(self.count);
            }
            let write = |place: usize, pair: u64| to[place].store(pair, Relaxed);
            if pass == 0 {
                scatter(self.count, self.block, shift, first_pair, write);
            } else {
                scatter(self.count, self.block, shift, |place| from[place].load(Relaxed), write);
            }
            std::mem::swap(from, to);
        }
        let order: Vec<AtomicU32> = (0..self.count).into_par_iter().map(|_| AtomicU32::new(0)).collect();
        let write = |place: usize, pair: u64| order[place].store(pair as u32, Relaxed);
        if before.is_empty() {
            scatter(self.count, self.block, last, first_pair, write);
        } else {
            scatter(self.count, self.block, last, |place| from[place].load(Relaxed), write);
        }
        self.permutation = Some(order.into_iter().map(AtomicU32::into_inner).collect());
    }
}

fn zeros(count: usize) -> Vec<AtomicU64> {
    (0..count).into_par_iter().map(|_| AtomicU64::new(0)).collect()
}

/// One pass: `read` gives the pair at a place, `write` puts it where its digit belongs, pairs of
/// one digit in the order in which they were.
fn scatter(
    count: usize,
    block: usize,
    shift: u32,
    read: impl Fn(usize) -> u64 + Sync,
    write: impl Fn(usize, u64) + Sync,
) {
    let digit = |pair: u64| digit_of((pair >> u32::BITS) as u32, shift);
    let range = |index: usize| index * block..count.min((index + 1) * block);
    let blocks = count.div_ceil(block);
    let mut places: Vec<Counts> = (0..blocks)
        .into_par_iter()
        .map(|index| {
            let mut counts = [0; BINS];
            range(index).for_each(|place| counts[digit(read(place))] += 1);
            counts
        })
        .collect();
    counts_to_places(&mut places);
    places.into_par_iter().enumerate().for_each(|(index, mut next)| {
        for place in range(index) {
            let pair = read(place);
            let target = &mut next[digit(pair)];
            write(*target as usize, pair);
            *target += 1;
        }
    });
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
                    let found = pool(threads).install(|| {
                        if bits <= 32 {
                            let keys: Vec<u32> = keys.iter().map(|&key| key as u32).collect();
                            sort_u32(&keys, bits)
                        } else {
                            sort_u64(&keys, bits)
                        }
                    });
                    assert!(found == expected(&keys), "{count} {what} of {bits} bits, {threads} threads");
                }
            }
        }
    }

    #[test]
    #[ignore = "a measurement: run it alone, in a release build"]
    fn speed() {
        for threads in [1, 2] {
            for bits in [16, 32, 64] {
                let keys = test_keys::random(2_000_000, bits, 1);
                let narrow: Vec<u32> = keys.iter().map(|&key| key as u32).collect();
                let mut times: Vec<f64> = (0..9)
                    .map(|_| {
                        let start = std::time::Instant::now();
                        pool(threads).install(|| {
                            if bits <= 32 { sort_u32(&narrow, bits) } else { sort_u64(&keys, bits) }
                        });
                        start.elapsed().as_secs_f64()
                    })
                    .collect();
                times.sort_by(f64::total_cmp);
                println!("{threads} threads, {bits} bits: {:.1} Mkeys/s", 2.0 / times[4]);
            }
        }
    }
}
