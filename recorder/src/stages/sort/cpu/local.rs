//! What one thread sorts in its core's own cache.

use std::sync::atomic::{AtomicU32, AtomicU64, Ordering::Relaxed};

use formats::prefetch::{prefetch_at, prefetch_to_write};

use super::split::Places;
use super::{pair, put, put_index, stored};

/// Most pairs: twice as many fit the cache.
pub(super) const MOST: usize = 1 << 16;
/// Most pairs that are compared: counting digits would take longer.
const FEW: usize = 64;
/// Fewest pairs for which wide digits pay, which take fewer passes and more counting.
const MANY: usize = 1 << 12;
/// Most bits of a digit, of many pairs.
pub(super) const MOST_BITS: u32 = 12;
/// Most bits of a digit, of fewer.
const MOST_BITS_OF_FEWER: u32 = 9;
const BINS: usize = 1 << MOST_BITS;
/// Passes of a word.
const MOST_DIGITS: usize = u32::BITS.div_ceil(MOST_BITS_OF_FEWER) as usize;
/// How many pairs ahead memory is asked for: a page, since processors look no further by themselves.
const AHEAD: usize = 4096 / size_of::<u64>();

/// How often each digit occurs, then where its next pair goes.
type Counts = [u32; BINS];

/// The memory of one thread.
#[derive(Debug)]
pub(super) struct Worker {
    /// Of its block in a split.
    pub(super) places: Box<Places>,
    by_digits: LowestFirst,
    /// The words of pairs in order.
    words: Vec<AtomicU32>,
}

impl Default for Worker {
    fn default() -> Self {
        Self {
            places: Box::new([0; _]),
            by_digits: LowestFirst::default(),
            words: (0..MOST).map(|_| AtomicU32::default()).collect(),
        }
    }
}

impl Worker {
    /// Writes the indices of `pairs` in order, where no bits of a word beyond those of `varying` differ and
    /// `rest` gives a second word of an index. What lies in `spare` is lost; pairs may come from there.
    pub(super) fn sort(
        &mut self,
        pairs: impl Iterator<Item = u64> + Clone,
        varying: u32,
        rest: Option<impl Fn(usize) -> u32 + Copy>,
        spare: &[AtomicU64],
        permutation: &[AtomicU32],
    ) {
        let Self { by_digits, words, .. } = self;
        assert_eq!(spare.len(), permutation.len(), "room for all pairs");
        // SAFETY: `by_digits` gives places of `spare`, and the permutation is as long.
        let write = |place, pair| unsafe { put_index(permutation, place, pair) };
        let Some(rest) = rest else {
            by_digits.sort(pairs, varying, spare, permutation, write);
            return;
        };
        let words = &words[..permutation.len()];
        by_digits.sort(pairs, varying, spare, permutation, |place, pair| {
            write(place, pair);
            // SAFETY: the same, and there are as many words.
            unsafe { put_index(words, place, pair >> u32::BITS) };
        });
        let mut start = 0;
        for equal in words.chunk_by(|a, b| a.load(Relaxed) == b.load(Relaxed)) {
            let range = start..start + equal.len();
            start = range.end;
            if equal.len() > 1 {
                let (spare, permutation) = (&spare[range.clone()], &permutation[range]);
                for (spare, index) in spare.iter().zip(permutation) {
                    let index = index.load(Relaxed);
                    spare.store(pair(rest(index as usize), index as usize), Relaxed);
                }
                by_digits.sort(stored(spare), u32::MAX, spare, permutation, |place, pair| {
                    permutation[place].store(pair as u32, Relaxed);
                });
            }
        }
    }
}

/// Sorts by digits, lowest first.
#[derive(Debug)]
struct LowestFirst {
    counts: [Counts; MOST_DIGITS],
    pairs: Vec<AtomicU64>,
}

impl Default for LowestFirst {
    fn default() -> Self {
        Self { counts: [[0; _]; _], pairs: (0..MOST).map(|_| AtomicU64::default()).collect() }
    }
}

impl LowestFirst {
    /// Hands each pair to `write`, with its place, which writes to the permutation. There are as many as `spare`
    /// is long.
    ///
    /// # Panics
    /// If there are not. Each run over `pairs` must give the same, or places are wrong.
    fn sort(
        &mut self,
        pairs: impl Iterator<Item = u64> + Clone,
        varying: u32,
        spare: &[AtomicU64],
        permutation: &[AtomicU32],
        write: impl Fn(usize, u64) + Copy,
    ) {
        let count = spare.len();
        if count <= FEW {
            sort_few(pairs, count, write);
            return;
        }
        let Self { counts, pairs: own } = self;
        let passes = Passes::of(varying, count);
        match passes.number {
            0 => {}
            1 => passes.count::<1>(counts, pairs.clone(), spare, permutation),
            2 => passes.count::<2>(counts, pairs.clone(), spare, permutation),
            3 => passes.count::<3>(counts, pairs.clone(), spare, permutation),
            _ => passes.count::<4>(counts, pairs.clone(), spare, permutation),
        }
        let mut differing = [0; MOST_DIGITS];
        let differing = passes.to_places(counts, pairs.clone().next().unwrap_or(0), count, &mut differing);
        let Some((&last, before)) = differing.split_last() else {
            pairs.take(count).enumerate().for_each(|(place, pair)| write(place, pair));
            return;
        };
        let (mut from, mut to) = (spare, &own[..count]);
        for (pass, &number) in before.iter().enumerate() {
            let target = to;
            // SAFETY: places were counted from these pairs, and are as many as there are in `spare` and here.
            let write = move |place, pair| unsafe { put(target, place, pair) };
            match pass {
                0 => passes.scatter(counts, number, pairs.clone(), write),
                _ => passes.scatter(counts, number, stored(from), write),
            }
            (from, to) = (to, from);
        }
        match before {
            [] => passes.scatter(counts, last, pairs, write),
            _ => passes.scatter(counts, last, stored(from), write),
        }
    }
}

fn sort_few(pairs: impl Iterator<Item = u64>, count: usize, write: impl Fn(usize, u64)) {
    let mut few = [0; FEW];
    let few = &mut few[..count];
    few.iter_mut().zip(pairs).for_each(|(place, pair)| *place = pair);
    few.sort_unstable();
    few.iter().enumerate().for_each(|(place, &pair)| write(place, pair));
}

/// A word cut into digits of one width.
#[derive(Clone, Copy)]
struct Passes {
    number: u32,
    width: u32,
    /// Of the lowest one, in a pair.
    shift: u32,
}

impl Passes {
    /// Those of the bits that vary.
    fn of(varying: u32, count: usize) -> Self {
        let most = if count < MANY { MOST_BITS_OF_FEWER } else { MOST_BITS };
        let low = varying.trailing_zeros();
        let bits = u32::BITS.saturating_sub(varying.leading_zeros() + low);
        let number = bits.div_ceil(most);
        Self { number, width: bits.div_ceil(number.max(1)), shift: u32::BITS + low }
    }

    fn mask(self) -> usize {
        (1 << self.width) - 1
    }

    /// Counts all digits at once, and asks for what is read and written next.
    fn count<const NUMBER: usize>(
        self,
        counts: &mut [Counts; MOST_DIGITS],
        pairs: impl Iterator<Item = u64>,
        spare: &[AtomicU64],
        permutation: &[AtomicU32],
    ) {
        let Some(counts) = counts.first_chunk_mut::<NUMBER>() else {
            unreachable!("a word has no more digits")
        };
        counts.iter_mut().for_each(|counts| counts[..=self.mask()].fill(0));
        pairs.enumerate().for_each(|(place, pair)| {
            prefetch_at(spare, place + AHEAD);
            prefetch_to_write(permutation, place);
            let mut bits = pair >> self.shift;
            for counts in &mut *counts {
                counts[bits as usize & self.mask() & (BINS - 1)] += 1;
                bits >>= self.width;
            }
        });
    }

    /// From counts to places; gives the digits that are not those of `first` in all `count` pairs.
    fn to_places<'a>(
        self,
        counts: &mut [Counts; MOST_DIGITS],
        first: u64,
        count: usize,
        differing: &'a mut [u32; MOST_DIGITS],
    ) -> &'a [u32] {
        let mut number = 0;
        for (digit, counts) in (0..self.number).zip(counts) {
            if counts[self.value(first, digit)] as usize != count {
                let counts = counts[..=self.mask()].iter_mut();
                let end = counts.fold(0, |place, count| place + std::mem::replace(count, place));
                assert_eq!(end as usize, count, "a place for each pair");
                differing[number] = digit;
                number += 1;
            }
        }
        &differing[..number]
    }

    fn value(self, pair: u64, digit: u32) -> usize {
        (pair >> (self.shift + digit * self.width)) as usize & self.mask() & (BINS - 1)
    }

    fn scatter(
        self,
        counts: &mut [Counts; MOST_DIGITS],
        digit: u32,
        pairs: impl Iterator<Item = u64>,
        write: impl Fn(usize, u64),
    ) {
        let places = &mut counts[digit as usize];
        pairs.for_each(|pair| {
            let place = &mut places[self.value(pair, digit)];
            write(*place as usize, pair);
            *place += 1;
        });
    }
}
