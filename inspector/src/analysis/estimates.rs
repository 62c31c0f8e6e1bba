//! The length table against the lengths that were traced: how many rays have which pair of both.

use formats::length_table::{LengthTable, TABLE_BITS_MIN};
use formats::stored_table::StoredTable;
use formats::traced::Traced;
use rayon::prelude::*;

/// Parts of each axis.
pub const BINS: usize = 96;
/// Shortest length that is told apart, log10 of unit lengths.
const SHORTEST: f64 = -4.0;
/// No length is longer than √3, log10 of unit lengths.
const LONGEST: f64 = 0.25;
/// Rays that a thread takes at a time.
const RAYS_PER_TASK: usize = 16_384;

/// How many rays have which traced length and which estimate of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimates {
    /// Rays by bin of the estimate, then by bin of the traced length; shortest first.
    pub counts: Vec<u32>,
    /// log10 of the shortest length of a bin.
    pub low: f64,
    /// log10 of the longest length of a bin.
    pub high: f64,
    /// Share of the rays whose estimate is at most twice and at least half of their length, 0 to 1.
    pub within_factor_two: f64,
    /// Share of the rays whose cell no ray was added to yet, so that its estimate is the dummy's, 0 to 1.
    pub untouched: f64,
}

/// What a thread counts.
struct Counts {
    pairs: Vec<u32>,
    within: u64,
    untouched: u64,
}

impl Estimates {
    /// Of all rays of a queue with their lengths, by the table that was read for them.
    pub fn of(traced: &Traced, lengths: &[f32], table: &StoredTable) -> Self {
        let rays = traced.rays();
        let dummy = LengthTable::new(TABLE_BITS_MIN).mean(0);
        // From the decade of the shortest per mille, so that a few tiny lengths do not squeeze the rest.
        let low = lowest_decade(lengths);
        let bin = |length: f32| {
            let part = (f64::from(length).max(1e-30).log10() - low) / (LONGEST - low);
            ((part * BINS as f64).max(0.0) as usize).min(BINS - 1)
        };
        let none = || Counts { pairs: vec![0; BINS * BINS], within: 0, untouched: 0 };
        let add = |mut counts: Counts, (&length, ray): (&f32, _)| {
            let estimate = table.estimate(traced.unit(), ray);
            counts.pairs[bin(estimate) * BINS + bin(length)] += 1;
            counts.within += u64::from((0.5..=2.0).contains(&(estimate / length)));
            counts.untouched += u64::from(table.mean(ray).to_bits() == dummy.to_bits());
            counts
        };
        let sum = |mut a: Counts, b: Counts| {
            a.pairs.iter_mut().zip(b.pairs).for_each(|(a, b)| *a += b);
            Counts { within: a.within + b.within, untouched: a.untouched + b.untouched, ..a }
        };
        let counts = lengths.par_iter().zip(rays).with_min_len(RAYS_PER_TASK);
        let counts = counts.fold(none, add).reduce(none, sum);
        let share = |counted: u64| counted as f64 / rays.len().max(1) as f64;
        Self {
            low,
            high: LONGEST,
            within_factor_two: share(counts.within),
            untouched: share(counts.untouched),
            counts: counts.pairs,
        }
    }
}

/// log10 of the power of ten below all but a thousandth of the lengths.
fn lowest_decade(lengths: &[f32]) -> f64 {
    let mut sample: Vec<f32> = lengths.iter().copied().step_by((lengths.len() / 20_000).max(1)).collect();
    sample.sort_by(f32::total_cmp);
    let low = sample.get(sample.len() / 1000).map_or(0.1, |&length| f64::from(length));
    low.max(1e-30).log10().floor().clamp(SHORTEST, -1.0)
}
