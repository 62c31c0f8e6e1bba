//! One pass of all threads: pairs with the same digit end up side by side, in the order in which they were.

use std::ops::Range;

use super::local::{self, Worker};
use super::together::together;

/// Fewest pairs that are worth a thread of their own.
pub(super) const SMALLEST_BLOCK: usize = 1 << 14;
/// Most bits of a digit that others follow: so many stretches of pairs grow at once, each in a page of its own.
pub(super) const MOST_BITS: u32 = 8;
/// Most bits of the last digit, where indices alone are written.
pub(super) const MOST_BITS_OF_LAST: u32 = 15;
/// Fewest bits of a digit, where more are left: threads take stretches in turns.
const FEWEST_BITS: u32 = 4;
/// How long a stretch should be, for what follows, if keys were spread evenly. Those of rays are not: they share
/// their highest bits, so that a few stretches have most of them.
const GOOD_LENGTH: usize = 1 << 11;
/// How many places ahead in a stretch to ask for memory: what is written next there is in another line.
pub(super) const AHEAD: usize = 64 / size_of::<u64>();
const BINS: usize = 1 << MOST_BITS_OF_LAST;
/// Counts of a cache line.
const LINE: usize = 64 / size_of::<u32>();

/// How often each digit occurs in a block, then where its next pair goes.
pub(super) type Places = [u32; BINS];

/// Bits of a pair's word.
#[derive(Clone, Copy, Debug)]
pub(super) struct Digit {
    shift: u32,
    bits: u32,
}

impl Digit {
    /// All bits that vary, if one pass of so many threads sorts `count` pairs by them: one thread adds up what all
    /// counted, which must not take longer than counting.
    pub(super) fn last(varying: u32, count: usize, threads: usize) -> Option<Self> {
        let all = Self::all(varying);
        let blocks = Blocks::number(threads, count);
        let is_short = (blocks << all.bits) * blocks <= 2 * count;
        (all.bits <= MOST_BITS || all.bits <= MOST_BITS_OF_LAST && is_short).then_some(all)
    }

    /// The highest bits that vary, as many as cut `count` pairs into stretches of a good length, or so many that
    /// what is left is one digit of one thread.
    pub(super) fn first(varying: u32, count: usize) -> Self {
        let Self { shift, bits } = Self::all(varying);
        let good = (count / GOOD_LENGTH).max(1).ilog2() + 1;
        let all_but_one = Some(bits.saturating_sub(local::MOST_BITS)).filter(|&bits| bits <= MOST_BITS);
        let first = good.max(all_but_one.unwrap_or(0)).clamp(FEWEST_BITS, MOST_BITS).min(bits);
        Self { shift: shift + bits - first, bits: first }
    }

    fn all(varying: u32) -> Self {
        let top = u32::BITS - varying.leading_zeros();
        let bits = top.saturating_sub(varying.trailing_zeros());
        Self { shift: top - bits, bits }
    }

    /// How many values it has.
    fn values(self) -> usize {
        1 << self.bits
    }

    /// The bits that are lower.
    pub(super) fn below(self) -> u32 {
        (1 << self.shift) - 1
    }

    fn of(self, pair: u64) -> usize {
        ((pair >> u32::BITS) as u32 >> self.shift) as usize & ((self.values() - 1) & (BINS - 1))
    }
}

/// Blocks of pairs that are counted apart, each by a thread.
struct Blocks {
    range: Range<usize>,
    length: usize,
}

impl Blocks {
    fn number(threads: usize, pairs: usize) -> usize {
        threads.min(pairs / SMALLEST_BLOCK).max(1)
    }

    fn get(&self, number: usize) -> Range<usize> {
        let first = self.range.start + number * self.length;
        first..self.range.end.min(first + self.length)
    }
}

/// Pairs of a range that were counted, so that each has a place.
pub(super) struct Split<'a> {
    workers: &'a mut [Worker],
    blocks: Blocks,
    digit: Digit,
    /// How many pairs of a block have the digit of a pair, in the mean of all pairs.
    pub(super) company: u64,
}

impl<'a> Split<'a> {
    /// Counts what `read` gives for the range.
    ///
    /// # Panics
    /// If there are not as many as the range is long.
    pub(super) fn of<P: Iterator<Item = u64>>(
        workers: &'a mut [Worker],
        range: Range<usize>,
        digit: Digit,
        read: impl Fn(Range<usize>) -> P + Copy + Send + Sync,
    ) -> Self {
        let number = Blocks::number(workers.len(), range.len());
        let blocks = Blocks { length: range.len().div_ceil(number), range };
        let workers = &mut workers[..number];
        together(workers, |number, worker| count(read(blocks.get(number)), digit, &mut worker.places));
        let company = to_places(workers, &blocks.range, digit);
        Self { workers, blocks, digit, company }
    }

    /// Where the stretch of each digit is that others follow.
    pub(super) fn stretches(&self) -> Stretches {
        let mut starts = [self.blocks.range.end as u32; _];
        starts[..self.digit.values()].copy_from_slice(&self.workers[0].places[..self.digit.values()]);
        Stretches { starts, number: self.digit.values() }
    }

    /// Hands each pair to `write`, with its place in the range. `read` must give what it gave before, or places are
    /// wrong.
    pub(super) fn scatter<P: Iterator<Item = u64>>(
        self,
        read: impl Fn(Range<usize>) -> P + Copy + Send + Sync,
        write: impl Fn(usize, u64) + Copy + Send + Sync,
    ) {
        let Self { workers, blocks, digit, .. } = self;
        together(workers, |number, worker| {
            scatter(read(blocks.get(number)), digit, &mut worker.places, write)
        });
    }
}

fn count(pairs: impl Iterator<Item = u64>, digit: Digit, counts: &mut Places) {
    counts[..digit.values()].fill(0);
    pairs.for_each(|pair| counts[digit.of(pair)] += 1);
}

fn scatter(pairs: impl Iterator<Item = u64>, digit: Digit, places: &mut Places, write: impl Fn(usize, u64)) {
    pairs.for_each(|pair| {
        let place = &mut places[digit.of(pair)];
        write(*place as usize, pair);
        *place += 1;
    });
}

/// From counts to places; gives a pair's company.
fn to_places(workers: &mut [Worker], range: &Range<usize>, digit: Digit) -> u64 {
    let mut place = range.start as u32;
    let mut company = 0;
    for first in (0..digit.values()).step_by(LINE) {
        let values = first..digit.values().min(first + LINE);
        // Rays start on surfaces, many from the same: few of many values occur.
        let occurs =
            |worker: &Worker| worker.places[values.clone()].iter().fold(0, |all, count| all | count) > 0;
        if digit.bits > MOST_BITS && !workers.iter().any(occurs) {
            continue;
        }
        for value in values {
            for worker in &mut *workers {
                let count = std::mem::replace(&mut worker.places[value], place);
                company += u64::from(count).pow(2);
                place += count;
            }
        }
    }
    assert_eq!(place as usize, range.end, "a place for each pair");
    company / range.len().max(1) as u64
}

/// Where stretches are.
pub(super) struct Stretches {
    /// And at the end, where the last one ends.
    starts: [u32; (1 << MOST_BITS) + 1],
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
