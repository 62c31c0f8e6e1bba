//! One pass of all threads: pairs with the same digit end up side by side, in the order in which they were.

use std::ops::Range;

use rayon::prelude::*;

use super::local::{self, Worker};

/// Fewest pairs that are worth a thread of their own.
pub(super) const SMALLEST_BLOCK: usize = 1 << 14;
/// Most bits of a digit that others follow: so many stretches of pairs grow at once, each in a page of its own.
pub(super) const MOST_BITS: u32 = 8;
/// Most bits of the last digit, where indices alone are written.
pub(super) const MOST_BITS_OF_LAST: u32 = 12;
/// Fewest bits of a digit, where more are left: threads take stretches in turns.
const FEWEST_BITS: u32 = 4;
/// How long a stretch should be, for what follows, if keys were spread evenly. Those of rays are not: they share
/// their highest bits, so that a few stretches have most of them.
const GOOD_LENGTH: usize = 1 << 11;
/// How many places ahead in a stretch to ask for memory: what is written next there is in another line.
pub(super) const AHEAD: usize = 64 / size_of::<u64>();
const BINS: usize = 1 << MOST_BITS_OF_LAST;

/// How often each digit occurs in a block, then where its next pair goes.
pub(super) type Places = [u32; BINS];

/// Bits of a pair's word.
#[derive(Clone, Copy, Debug)]
pub(super) struct Digit {
    shift: u32,
    bits: u32,
}

impl Digit {
    /// The highest bits that vary: as many as cut `count` pairs into stretches of a good length, or so many that
    /// what is left is one digit of one thread; or all that are left if those are at most `most_at_once`.
    pub(super) fn highest(varying: u32, count: usize, most_at_once: u32) -> Self {
        let top = u32::BITS - varying.leading_zeros();
        let left = top.saturating_sub(varying.trailing_zeros());
        let good = (count / GOOD_LENGTH).max(1).ilog2() + 1;
        let all_but_one = Some(left.saturating_sub(local::MOST_BITS)).filter(|&bits| bits <= MOST_BITS);
        let wanted = good.max(all_but_one.unwrap_or(0)).clamp(FEWEST_BITS, MOST_BITS);
        let bits = if left <= most_at_once { left } else { wanted };
        Self { shift: top - bits, bits }
    }

    /// How many values it has.
    pub(super) fn values(self) -> usize {
        1 << self.bits
    }

    /// The bits that are lower.
    pub(super) fn below(self) -> u32 {
        (1 << self.shift) - 1
    }

    fn of(self, pair: u64) -> usize {
        (pair >> (u32::BITS + self.shift)) as usize & (self.values() - 1) & (BINS - 1)
    }
}

/// Where the stretch of each digit is.
pub(super) struct Stretches {
    /// And at the end, where the last one ends.
    starts: [u32; BINS + 1],
    number: usize,
}

impl Stretches {
    /// That of a digit, as long as there are more.
    pub(super) fn range(&self, digit: usize) -> Option<Range<usize>> {
        (digit < self.number).then(|| self.starts[digit] as usize..self.starts[digit + 1] as usize)
    }

    pub(super) fn ranges(&self) -> impl Iterator<Item = Range<usize>> {
        (0..).map_while(|digit| self.range(digit))
    }
}

/// Blocks of pairs that are counted apart, each by a thread.
fn blocks(threads: usize, pairs: usize) -> usize {
    threads.min(pairs / SMALLEST_BLOCK).max(1)
}

/// Most bits of the last digit: one thread adds up what all blocks counted, which must not be more than a block
/// has pairs.
pub(super) fn most_bits_of_last(threads: usize, pairs: usize) -> u32 {
    let blocks = blocks(threads, pairs);
    if (blocks << MOST_BITS_OF_LAST) * blocks <= pairs { MOST_BITS_OF_LAST } else { MOST_BITS }
}

/// Hands each pair that `read` gives for a range to `write`, with its place in that range.
///
/// # Panics
/// If there are not as many as the range is long. `read` must give the same pairs twice, or places are wrong.
pub(super) fn split<P: Iterator<Item = u64>>(
    workers: &mut [Worker],
    range: Range<usize>,
    digit: Digit,
    read: impl Fn(Range<usize>) -> P + Copy + Send + Sync,
    write: impl Fn(usize, u64) + Copy + Send + Sync,
) -> Stretches {
    let blocks = blocks(workers.len(), range.len());
    let block = range.len().div_ceil(blocks);
    let block = |number: usize| {
        let first = range.start + number * block;
        first..range.end.min(first + block)
    };
    let workers = &mut workers[..blocks];
    workers.par_iter_mut().enumerate().for_each(|(number, worker)| {
        count(read(block(number)), digit, &mut worker.places);
    });
    let mut starts = [range.end as u32; BINS + 1];
    let mut place = range.start as u32;
    for (value, start) in starts.iter_mut().enumerate().take(digit.values()) {
        *start = place;
        for worker in &mut *workers {
            place += std::mem::replace(&mut worker.places[value], place);
        }
    }
    assert_eq!(place as usize, range.end, "a place for each pair");
    workers.par_iter_mut().enumerate().for_each(|(number, worker)| {
        scatter(read(block(number)), digit, &mut worker.places, write);
    });
    Stretches { starts, number: digit.values() }
}

fn count(pairs: impl Iterator<Item = u64>, digit: Digit, counts: &mut Places) {
    counts.fill(0);
    pairs.for_each(|pair| counts[digit.of(pair)] += 1);
}

fn scatter(pairs: impl Iterator<Item = u64>, digit: Digit, places: &mut Places, write: impl Fn(usize, u64)) {
    pairs.for_each(|pair| {
        let place = &mut places[digit.of(pair)];
        write(*place as usize, pair);
        *place += 1;
    });
}
