//! What each bit of an order's keys is worth: how coherent the order is that keys have which end there.

use std::ops::Range;

use formats::metrics::order::{Keys, Places};
use formats::traced::Traced;

use super::coherence::coherence;

/// The share of the whole gain that is called enough.
const ENOUGH: f64 = 0.9;

/// What the bits of an order's keys are worth.
#[derive(Clone, Debug, PartialEq)]
pub struct KeyBits {
    /// Rays.
    pub rays: usize,
    /// Mean capsule area of canonical order, unit space.
    pub unsorted_area: f64,
    /// The bits, most significant first.
    pub bits: Vec<KeyBit>,
}

/// One bit of the keys.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KeyBit {
    /// Rays in whose keys it is set.
    pub ones: usize,
    /// Mean capsule area of the order by it and all bits before it, unit space.
    pub mean_capsule_area: f64,
}

impl KeyBits {
    /// Of these bits, counted from the lowest, of the keys of a queue's rays, in groups of `width` rays; `lengths` are
    /// the traced lengths of all rays in canonical order. `None` for no rays, and where an area is not finite.
    pub fn of(
        traced: &Traced,
        lengths: &[f32],
        (keys, bits): (&Keys, Range<u32>),
        width: usize,
    ) -> Option<Self> {
        let rays = keys.len();
        let mean_area = |order: &[u32]| {
            let of = coherence(traced, lengths, &Places::Made(order.to_vec()), width)?;
            Some(of.mean_capsule_area).filter(|area| area.is_finite())
        };
        let mut order: Vec<u32> = (0..rays as u32).collect();
        let unsorted_area = mean_area(&order)?;
        let mut runs = vec![rays];
        let mut mean_capsule_area = unsorted_area;
        let mut found = Vec::with_capacity(bits.len());
        for below in bits.rev() {
            let is_set = |ray: u32| keys.at(ray as usize) >> below & 1 == 1;
            let ones = (0..rays as u32).filter(|&ray| is_set(ray)).count();
            if (1..rays).contains(&ones) {
                (order, runs) = split(&order, &runs, is_set);
                mean_capsule_area = mean_area(&order)?;
            }
            found.push(KeyBit { ones, mean_capsule_area });
        }
        Some(Self { rays, unsorted_area, bits: found })
    }

    /// Whether all keys have the same value of a bit.
    pub fn is_idle(&self, bit: &KeyBit) -> bool {
        bit.ones == 0 || bit.ones == self.rays
    }

    /// How many bits give nine tenths of what all of them take from the capsule area of canonical order; `None` if
    /// they take nothing.
    pub fn enough(&self) -> Option<usize> {
        let gain = |bit: &KeyBit| self.unsorted_area - bit.mean_capsule_area;
        let all = self.bits.last().map(gain).filter(|all| *all > 0.0)?;
        self.bits.iter().position(|bit| gain(bit) >= ENOUGH * all).map(|at| at + 1)
    }
}

/// Splits each run of equal keys, given by where it ends, into rays without and with one more bit; rays stay in the
/// order in which they were.
fn split(order: &[u32], runs: &[usize], is_set: impl Fn(u32) -> bool) -> (Vec<u32>, Vec<usize>) {
    let (mut split, mut ends) = (Vec::with_capacity(order.len()), Vec::with_capacity(2 * runs.len()));
    let mut with = Vec::new();
    let mut start = 0;
    for &end in runs {
        for &ray in &order[start..end] {
            if is_set(ray) { with.push(ray) } else { split.push(ray) }
        }
        if split.len() > start {
            ends.push(split.len());
        }
        if !with.is_empty() {
            split.append(&mut with);
            ends.push(end);
        }
        start = end;
    }
    (split, ends)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_are_enough_when_nine_tenths_of_the_gain_are_there() {
        let with = |areas: &[f64]| {
            let bit = |&mean_capsule_area| KeyBit { ones: 1, mean_capsule_area };
            KeyBits { rays: 2, unsorted_area: 11.0, bits: areas.iter().map(bit).collect() }
        };
        assert_eq!(with(&[6.0, 2.5, 2.0, 1.0]).enough(), Some(3));
        assert_eq!(with(&[1.0, 1.0]).enough(), Some(1));
        assert_eq!(with(&[11.0, 12.0]).enough(), None);
        assert_eq!(with(&[]).enough(), None);
    }

    #[test]
    fn runs_are_split_as_a_stable_sort_orders_them() {
        let keys = [0b101, 0b011, 0b001, 0b111, 0b011, 0b000, 0b100];
        let (mut order, mut runs) = ((0..7).collect::<Vec<u32>>(), vec![7]);
        for below in (0..3).rev() {
            (order, runs) = split(&order, &runs, |ray| keys[ray as usize] >> below & 1 == 1);
            let mut sorted: Vec<u32> = (0..7).collect();
            sorted.sort_by_key(|&ray| keys[ray as usize] >> below);
            assert_eq!(order, sorted, "after bit {below}");
        }
        assert_eq!(runs, [1, 2, 4, 5, 6, 7]);
    }
}
