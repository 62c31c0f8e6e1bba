//! The rows of a table of rays: those that pass the filter, sorted by any of their numbers.

use formats::metrics::quantity::{Quantity, RayAt};
use rayon::prelude::*;

use super::numbers::Numbers;
use crate::filter::Passing;

/// Which way rows go.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Direction {
    /// The least first.
    #[default]
    Ascending,
    /// The greatest first.
    Descending,
}

/// What rows are sorted by. Rays of equal numbers stay in their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sorting {
    /// The number.
    pub by: Quantity,
    /// Which way; rays that do not have the number come last both ways.
    pub direction: Direction,
}

impl Default for Sorting {
    fn default() -> Self {
        Self { by: Quantity::Place, direction: Direction::Ascending }
    }
}

/// The place of an order in each row.
#[derive(Debug, PartialEq, Eq)]
pub enum Rows {
    /// All of so many places, one way or the other.
    All(usize, Direction),
    /// These places.
    Listed(Vec<u32>),
}

impl Rows {
    /// The rows of an order; all of its rays if nothing says which pass.
    pub fn of(numbers: &Numbers, passing: Option<&Passing>, sorting: Sorting) -> Self {
        let rays = numbers.order.len();
        if sorting.by == Quantity::Place {
            return match (passing, sorting.direction) {
                (None, direction) => Self::All(rays, direction),
                (Some(passing), Direction::Ascending) => Self::Listed(passing.places().to_vec()),
                (Some(passing), Direction::Descending) => {
                    Self::Listed(passing.places().iter().rev().copied().collect())
                }
            };
        }
        numbers.prepare(sorting.by);
        let (ordered, value) = (numbers.rays(), sorting.by.value());
        let keyed = |place: u32| (sort_key(ordered.at(place as usize), sorting, value), place);
        let mut keyed: Vec<(u64, u32)> = match passing {
            Some(passing) => passing.places().par_iter().map(|&place| keyed(place)).collect(),
            None => (0..rays as u32).into_par_iter().map(keyed).collect(),
        };
        // Places ascend and are part of the key, so ties stay in order.
        keyed.par_sort_unstable();
        Self::Listed(keyed.into_par_iter().map(|(_, place)| place).collect())
    }

    /// How many rows.
    pub fn len(&self) -> usize {
        match self {
            Self::All(rays, _) => *rays,
            Self::Listed(places) => places.len(),
        }
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The place in a row.
    ///
    /// # Panics
    /// If there is no such row.
    pub fn place(&self, row: usize) -> usize {
        match self {
            Self::All(_, Direction::Ascending) => row,
            Self::All(rays, Direction::Descending) => rays - 1 - row,
            Self::Listed(places) => places[row] as usize,
        }
    }

    /// The row of a place, if it has one.
    pub fn row_of(&self, place: usize) -> Option<usize> {
        match self {
            Self::All(rays, Direction::Ascending) => Some(place).filter(|place| place < rays),
            Self::All(rays, Direction::Descending) => rays.checked_sub(place + 1),
            Self::Listed(places) => places.par_iter().position_first(|&listed| listed as usize == place),
        }
    }
}

/// Whole numbers that sort as the numbers of rays do; what is not a number last.
fn sort_key(ray: RayAt<'_>, sorting: Sorting, value: fn(RayAt<'_>) -> f64) -> u64 {
    let ascending = match sorting.by {
        // All of its bits, of which f64 has too few.
        Quantity::Key => ray.key(),
        _ => ordered_bits(value(ray)),
    };
    match (ascending, sorting.direction) {
        (None, _) => u64::MAX,
        (Some(key), Direction::Ascending) => key,
        (Some(key), Direction::Descending) => !key,
    }
}

/// The bits of a number, changed so that they sort as it does; `None` for NaN.
fn ordered_bits(value: f64) -> Option<u64> {
    const SIGN: u64 = 1 << 63;
    // Both zeros are the same number.
    let bits = (value + 0.0).to_bits();
    (!value.is_nan()).then_some(if bits & SIGN == 0 { bits | SIGN } else { !bits })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_sort_as_numbers_do() {
        let values = [f64::NEG_INFINITY, -2.5, -1e-300, 0.0, 1e-300, 0.5, 3.0, f64::INFINITY];
        let bits: Vec<u64> = values.iter().map(|&value| ordered_bits(value).unwrap()).collect();
        assert!(bits.windows(2).all(|pair| pair[0] < pair[1]));
        assert_eq!(ordered_bits(-0.0), ordered_bits(0.0));
        assert_eq!(ordered_bits(f64::NAN), None);
    }

    #[test]
    fn rows_and_places_are_inverse() {
        let listed = Rows::Listed(vec![7, 2, 9]);
        for rows in [Rows::All(5, Direction::Ascending), Rows::All(5, Direction::Descending), listed] {
            for row in 0..rows.len() {
                assert_eq!(rows.row_of(rows.place(row)), Some(row));
            }
            assert_eq!(rows.row_of(100), None);
        }
    }
}
