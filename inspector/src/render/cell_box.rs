//! Where a cell of the length table lies: the box of origins that its address stands for.

use std::collections::BTreeMap;

use formats::key::decode::decode;
use formats::key::{Coordinate, Extent, Layout, LayoutText};
use formats::length_table::{LENGTH_FRACTION_BITS, TABLE_BITS_MAX, TABLE_BITS_MIN};
use formats::manifest::Options;
use rayon::prelude::*;

use super::geometry::{Corners, Geometry, boxes};
use super::range::{ValueRange, Values};
use crate::model::Queue;

/// How the cells of a recording's length tables are addressed; `None` if it does not say so.
fn table_layout(options: &Options) -> Option<Layout> {
    let has_table = (TABLE_BITS_MIN..=TABLE_BITS_MAX).contains(&options.table_bits);
    let text = LayoutText::parse(&options.table_layout).ok().filter(|_| has_table);
    text?.expand(Extent::NOTHING).ok()
}

/// The corners of a cell's box; an axis of which the address says nothing spans all of it.
fn corners(layout: &Layout, bits: u32, cell: u32) -> Corners {
    let (mut low, mut high) = ([0.0; 3], [1.0; 3]);
    for field in decode(layout, bits, u64::from(cell)) {
        let axis = match field.bit.coordinate() {
            Some(Coordinate::OriginX) => 0,
            Some(Coordinate::OriginY) => 1,
            Some(Coordinate::OriginZ) => 2,
            _ => continue,
        };
        let Some((from, to)) = field.range() else { continue };
        (low[axis], high[axis]) = (from as f32, to as f32);
    }
    (low, high)
}

/// The box of a cell; `None` if the recording does not say how cells are addressed.
pub fn cell_box(options: &Options, cell: u32) -> Option<Corners> {
    Some(corners(&table_layout(options)?, options.table_bits, cell))
}

/// The boxes in which the rays of a table's touched cells start, those of most rays first and at most `most`,
/// with the mean length of their rays; the range of these; and how many boxes there are. Cells that differ in direction
/// alone share one.
pub fn cells(options: &Options, queue: &Queue, most: usize) -> (Geometry, ValueRange, usize) {
    let (Some(layout), Ok(touched)) = (table_layout(options), &queue.cells) else {
        return (boxes(std::iter::empty()).into(), ValueRange { low: 0.0, high: 1.0 }, 0);
    };
    // Corners are not negative, so their bits sort as they do.
    let mut of_origin: BTreeMap<[[u32; 3]; 2], (u64, u64)> = BTreeMap::new();
    for cell in &**touched {
        let (low, high) = corners(&layout, options.table_bits, cell.cell);
        let found = of_origin.entry([low, high].map(|corner| corner.map(f32::to_bits))).or_default();
        *found = (found.0 + u64::from(cell.count), found.1.saturating_add(cell.sum));
    }
    let mut found: Vec<_> = of_origin.into_iter().collect();
    let all = found.len();
    found.sort_by_key(|(_, (count, _))| std::cmp::Reverse(*count));
    found.truncate(most);
    let mean = |(count, sum): (u64, u64)| (sum as f64 / LENGTH_UNIT / count.max(1) as f64) as f32;
    let values: Vec<f32> = found.iter().map(|(_, sums)| mean(*sums)).collect();
    let range = Values::of(values.into_par_iter()).percentiles(2.0, 98.0);
    let shape = boxes(
        found
            .into_iter()
            .map(|([low, high], sums)| ((low.map(f32::from_bits), high.map(f32::from_bits)), mean(sums))),
    );
    (shape.into(), range, all)
}

/// Parts of a unit length that sums of the length table count.
const LENGTH_UNIT: f64 = (1u64 << LENGTH_FRACTION_BITS) as f64;

/// Column and row of a cell in a picture whose neighbours are neighbours in the address: bits of the
/// address go to column and row in turn.
pub fn pixel_of_cell(cell: u32) -> (u32, u32) {
    (every_other_bit(cell), every_other_bit(cell >> 1))
}

/// The cell at a column and a row; the inverse of [`pixel_of_cell`].
pub fn cell_of_pixel(column: u32, row: u32) -> u32 {
    let spread = |value: u32| (0..16).fold(0, |bits, at| bits | (value >> at & 1) << (2 * at));
    spread(column) | spread(row) << 1
}

fn every_other_bit(value: u32) -> u32 {
    (0..16).fold(0, |bits, at| bits | (value >> (2 * at) & 1) << at)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_and_cells_are_inverse() {
        for cell in [0, 1, 2, 3, 4, 1023, 1024, 0xf_ffff, 0x5_5555, u32::MAX] {
            let (column, row) = pixel_of_cell(cell);
            assert_eq!(cell_of_pixel(column, row), cell);
        }
        assert_eq!([1, 2, 4].map(pixel_of_cell), [(1, 0), (0, 1), (2, 0)]);
    }
}
