//! From coordinates to the place along a Hilbert curve, and back.
//!
//! The curve is Skilling's ("Programming the Hilbert curve", AIP Conference Proceedings 707, 2004), here without
//! branches: coordinates of n bits become as many words of n bits, and the place is the words' highest bits in turn,
//! then the next lower ones. A bit of a word depends on bits of coordinates that are no lower, so that a short key
//! is a prefix of a long one.

/// Turns coordinates of `bits` bits, each of `N` rays, into the words of their places along the curve.
#[inline(always)]
pub fn to_curve<const N: usize>(axes: &mut [[u32; N]], bits: u32) {
    let Some((first, others)) = axes.split_first_mut() else { return };
    // In a cell of any level the curve lies mirrored or with two axes exchanged, and so do the bits below.
    for level in (1..bits).rev() {
        first.iter_mut().for_each(|first| *first = mirrored(*first, level));
        for other in others.iter_mut() {
            for (first, other) in first.iter_mut().zip(other) {
                (*first, *other) = turned(*first, *other, level);
            }
        }
    }
    for axis in 1..axes.len() {
        let before = axes[axis - 1];
        axes[axis].iter_mut().zip(before).for_each(|(word, before)| *word ^= before);
    }
    let turns = axes[axes.len() - 1].map(parity_above);
    for axis in axes {
        axis.iter_mut().zip(&turns).for_each(|(word, turns)| *word ^= turns);
    }
}

/// The coordinates of words that [`to_curve`] made.
pub fn from_curve(words: &mut [u32], bits: u32) {
    let Some(turns) = words.last().map(|last| last >> 1) else { return };
    for axis in (1..words.len()).rev() {
        words[axis] ^= words[axis - 1];
    }
    words[0] ^= turns;
    for level in 1..bits {
        for axis in (1..words.len()).rev() {
            (words[0], words[axis]) = turned(words[0], words[axis], level);
        }
        words[0] = mirrored(words[0], level);
    }
}

/// The first axis: its bits below `level` inverted if it has a bit there.
#[inline(always)]
fn mirrored(first: u32, level: u32) -> u32 {
    first ^ (below(level) & is_set(first, level))
}

/// The first axis and another one: the first one's bits below `level` inverted if the other has a bit there; if
/// not, those of both exchanged.
#[inline(always)]
fn turned(first: u32, other: u32, level: u32) -> (u32, u32) {
    let is_set = is_set(other, level);
    let exchanged = (first ^ other) & below(level) & !is_set;
    (first ^ exchanged ^ (below(level) & is_set), other ^ exchanged)
}

#[inline(always)]
fn below(level: u32) -> u32 {
    (1 << level) - 1
}

/// All bits, or none.
#[inline(always)]
fn is_set(word: u32, level: u32) -> u32 {
    (word >> level & 1).wrapping_neg()
}

/// For each bit, whether an odd number of higher ones are set.
#[inline(always)]
fn parity_above(word: u32) -> u32 {
    let mut parity = word >> 1;
    for shift in [1, 2, 4, 8, 16] {
        parity ^= parity >> shift;
    }
    parity
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All cells in the order of the curve.
    fn curve(dimensions: usize, bits: u32) -> Vec<Vec<u32>> {
        let places = 0..1u32 << (bits * dimensions as u32);
        places
            .map(|place| {
                let word = |axis: usize| {
                    let bit = |level: u32| {
                        place >> (level * dimensions as u32 + (dimensions - 1 - axis) as u32) & 1
                    };
                    (0..bits).map(|level| bit(level) << level).sum::<u32>()
                };
                let mut words: Vec<u32> = (0..dimensions).map(word).collect();
                let back = words.clone();
                from_curve(&mut words, bits);
                let mut axes: Vec<[u32; 1]> = words.iter().map(|&word| [word]).collect();
                to_curve(&mut axes, bits);
                assert_eq!(axes.concat(), back, "place {place}");
                words
            })
            .collect()
    }

    #[test]
    fn the_curve_visits_every_cell_once_and_steps_to_neighbours() {
        for (dimensions, bits) in [(2, 1), (2, 2), (2, 8), (3, 1), (3, 5), (4, 4), (5, 3), (6, 2), (6, 3)] {
            let cells = curve(dimensions, bits);
            assert!(cells[0].iter().all(|&axis| axis == 0), "it starts in the corner");
            for pair in cells.windows(2) {
                let apart: u32 = pair[0].iter().zip(&pair[1]).map(|(a, b)| a.abs_diff(*b)).sum();
                assert_eq!(apart, 1, "{pair:?} in {dimensions} dimensions of {bits} bits");
            }
            let distinct: std::collections::BTreeSet<_> = cells.iter().collect();
            assert_eq!(distinct.len(), cells.len());
        }
    }

    #[test]
    fn coarser_cells_lie_along_a_coarser_curve() {
        for dimensions in 2..=6 {
            let (coarse, fine) = (curve(dimensions, 2), curve(dimensions, 3));
            for (place, cell) in fine.iter().enumerate() {
                let halved: Vec<u32> = cell.iter().map(|axis| axis >> 1).collect();
                assert_eq!(halved, coarse[place >> dimensions]);
            }
        }
    }
}
