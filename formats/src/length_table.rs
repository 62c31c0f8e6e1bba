//! The hashed table of mean ray lengths that two-point-adaptive reads (docs/keys.md, "Length table").

use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};

use bytemuck::{Pod, Zeroable};

/// Fraction bits of the fixed-point sums: a length of 1 counts as 2²⁴.
pub const LENGTH_FRACTION_BITS: u32 = 24;
/// Longest length that is summed, unit lengths.
pub const LONGEST_SUMMED: f32 = 2.0;
/// Sum of an untouched cell: one dummy ray of length 0.25.
pub const DUMMY_SUM: u64 = 1 << (LENGTH_FRACTION_BITS - 2);
/// Fewest and most address bits, and the default.
pub const TABLE_BITS_MIN: u32 = 8;
/// Most address bits.
pub const TABLE_BITS_MAX: u32 = 24;
/// Address bits unless told otherwise.
pub const TABLE_BITS_DEFAULT: u32 = 20;

/// One touched cell as a dump holds it; 16 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct LengthCell {
    /// Address of the cell.
    pub cell: u32,
    /// Rays summed, the dummy included: ≥ 2.
    pub count: u32,
    /// Sum of lengths in units of 2⁻²⁴, the dummy included.
    pub sum: u64,
}

/// Sums and counts of ray lengths per cell; 2^bits cells.
///
/// Adding is order-independent, so any number of threads gives the same table.
#[derive(Clone, Debug)]
pub struct LengthTable {
    bits: u32,
    cells: Vec<TableCell>,
}

/// A cell in memory, 16 bytes, so that asking it or adding to it touches one cache line.
///
/// Without its dummy, so that an untouched cell is 0: the system gives such memory only when it is written to, and
/// a large table of few cells costs next to nothing.
#[repr(C, align(16))]
#[derive(Debug, Zeroable)]
pub struct TableCell {
    sum: AtomicU64,
    count: AtomicU32,
}

impl TableCell {
    /// Adds a ray whose length is this fixed-point number, as [`LengthTable::add`] does, to a cell that nobody else
    /// adds to.
    #[inline]
    pub fn add(&mut self, length: u32) {
        *self.sum.get_mut() += u64::from(length);
        *self.count.get_mut() += 1;
    }

    /// Sum and count, the dummy ray included. As many additions as would wrap a count are refused before a
    /// recording starts; one that a file claims must not end us.
    #[inline]
    fn with_dummy(&self) -> (u64, u32) {
        let count = self.count.load(Ordering::Relaxed).saturating_add(1);
        (self.sum.load(Ordering::Relaxed) + DUMMY_SUM, count)
    }
}

impl Clone for TableCell {
    fn clone(&self) -> Self {
        let count = AtomicU32::new(self.count.load(Ordering::Relaxed));
        Self { sum: AtomicU64::new(self.sum.load(Ordering::Relaxed)), count }
    }
}

/// Why stored cells are not a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[expect(missing_docs, reason = "each message says what its fields mean")]
pub enum LengthTableError {
    /// Cells must ascend and stay below 2^bits.
    #[error("cell {cell} at place {place} is out of order or not below 2^{bits}")]
    Cell { cell: u32, place: usize, bits: u32 },
    /// A stored cell counts at least the dummy and one ray.
    #[error("cell {cell} holds {count} rays, expected 2 or more")]
    Count { cell: u32, count: u32 },
    /// No ray adds more than [`LONGEST_SUMMED`], and none takes away from the dummy.
    #[error("cell {cell} sums {sum} for {count} rays, expected {least} to {most}")]
    Sum { cell: u32, sum: u64, count: u32, least: u64, most: u64 },
}

/// A length in unit space as the fixed-point number that is summed.
pub fn fixed_point(length: f32) -> u32 {
    (length.min(LONGEST_SUMMED) * (1u32 << LENGTH_FRACTION_BITS) as f32) as u32
}

/// The least and the most that the dummy and `count` − 1 rays sum up to.
fn sums_of(count: u32) -> (u64, u64) {
    let rays = u64::from(count.saturating_sub(1));
    (DUMMY_SUM, DUMMY_SUM + rays * u64::from(fixed_point(LONGEST_SUMMED)))
}

/// Mean length in unit space from a cell's sum and count, exact on every device.
#[inline]
pub fn mean_length(sum: u64, count: u32) -> f32 {
    // Division of integers takes two ways by their size, which processors cannot guess. An f64 holds sums below 2^53,
    // and rounds no quotient up to a whole number: that lies 1 / count above it or more, over 2^-54 of itself.
    let mean = if sum < 1 << 53 {
        (sum as i64 as f64 / f64::from(count)) as u32
    } else {
        (sum / u64::from(count)) as u32
    };
    (mean >> 1) as f32 * (2.0 / (1u32 << LENGTH_FRACTION_BITS) as f32)
}

impl LengthTable {
    /// A table of 2^`bits` cells, each with its dummy ray. `bits` from 8 to 24.
    pub fn new(bits: u32) -> Self {
        Self { bits, cells: bytemuck::zeroed_vec(1 << bits) }
    }

    /// Forgets all but the dummy rays, in the same memory.
    pub fn clear(&mut self) {
        self.cells.iter_mut().for_each(|cell| *cell = TableCell::zeroed());
    }

    /// The table whose touched cells are `cells`, as [`LengthTable::touched`] gave them.
    ///
    /// # Errors
    /// If the cells do not ascend, are out of range, hold fewer than two rays, or a sum that no rays have.
    pub fn from_touched(bits: u32, cells: &[LengthCell]) -> Result<Self, LengthTableError> {
        let table = Self::new(bits);
        let mut next = 0u64;
        for (place, &LengthCell { cell, count, sum }) in cells.iter().enumerate() {
            if u64::from(cell) < next || u64::from(cell) >= 1 << bits {
                return Err(LengthTableError::Cell { cell, place, bits });
            }
            if count < 2 {
                return Err(LengthTableError::Count { cell, count });
            }
            let (least, most) = sums_of(count);
            if !(least..=most).contains(&sum) {
                return Err(LengthTableError::Sum { cell, sum, count, least, most });
            }
            let stored = &table.cells[cell as usize];
            stored.sum.store(sum - DUMMY_SUM, Ordering::Relaxed);
            stored.count.store(count - 1, Ordering::Relaxed);
            next = u64::from(cell) + 1;
        }
        Ok(table)
    }

    /// Sum and count of every cell, in order.
    pub fn cells(&self) -> impl Iterator<Item = (u64, u32)> {
        self.cells.iter().map(TableCell::with_dummy)
    }

    /// Address bits.
    pub fn bits(&self) -> u32 {
        self.bits
    }

    /// The cells, to be added to without company.
    pub fn cells_mut(&mut self) -> &mut [TableCell] {
        &mut self.cells
    }

    /// Where a cell lies.
    #[inline]
    pub fn cell(&self, cell: u32) -> &TableCell {
        &self.cells[cell as usize]
    }

    /// Mean length of a cell in unit space.
    #[inline]
    pub fn mean(&self, cell: u32) -> f32 {
        let (sum, count) = self.cell(cell).with_dummy();
        mean_length(sum, count)
    }

    /// Adds a ray of traced `length` (unit lengths, ≥ 0) to a cell.
    pub fn add(&self, cell: u32, length: f32) {
        let cell = self.cell(cell);
        cell.sum.fetch_add(u64::from(fixed_point(length)), Ordering::Relaxed);
        cell.count.fetch_add(1, Ordering::Relaxed);
    }

    /// The cells with a count of 2 or more, ascending: what a dump stores.
    pub fn touched(&self) -> Vec<LengthCell> {
        self.touched_cells().collect()
    }

    /// The same, one after the other.
    pub fn touched_cells(&self) -> impl Iterator<Item = LengthCell> {
        let is_touched = |(stored, _): &(&TableCell, u32)| stored.count.load(Ordering::Relaxed) > 0;
        self.cells.iter().zip(0..).filter(is_touched).map(|(stored, cell)| {
            let (sum, count) = stored.with_dummy();
            LengthCell { cell, count, sum }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn untouched_cells_say_a_quarter() {
        let table = LengthTable::new(8);
        assert_eq!(table.mean(17), 0.25);
        assert!(table.touched().is_empty());
    }

    #[test]
    fn means_are_whole_quotients_up_to_the_last_before_the_next() {
        let mut random = fastrand::Rng::with_seed(17);
        for _ in 0..1_000_000 {
            let count = (random.u32(..) >> random.u32(0..32)).max(1);
            let mean = random.u32(..=fixed_point(LONGEST_SUMMED)) >> random.u32(0..26);
            let least = u64::from(mean) * u64::from(count);
            for sum in [least, least + random.u64(0..u64::from(count)), least + u64::from(count) - 1] {
                let expected = (mean >> 1) as f32 / (1u32 << (LENGTH_FRACTION_BITS - 1)) as f32;
                assert_eq!(mean_length(sum, count), expected, "{sum} of {count}");
            }
        }
    }

    #[test]
    fn bad_cells_are_refused() {
        let cell = |cell, count| LengthCell { cell, count, sum: 1 << 24 };
        assert!(matches!(LengthTable::from_touched(8, &[cell(256, 2)]), Err(LengthTableError::Cell { .. })));
        assert!(matches!(
            LengthTable::from_touched(8, &[cell(5, 2), cell(5, 2)]),
            Err(LengthTableError::Cell { place: 1, .. })
        ));
        assert!(matches!(LengthTable::from_touched(8, &[cell(5, 0)]), Err(LengthTableError::Count { .. })));
    }
}
