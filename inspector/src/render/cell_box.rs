//! Where a cell of the length table lies: the box of origins that its address stands for.

use std::collections::BTreeMap;

use formats::key::decode::decode;
use formats::key::{Coordinate, LayoutText};
use formats::length_table::{TABLE_BITS_MAX, TABLE_BITS_MIN};
use formats::manifest::Options;
use formats::stored_table::StoredTableError;
use rayon::prelude::*;

use super::geometry::{Geometry, boxes};
use super::range::{ValueRange, Values};
use crate::model::Queue;

/// The corners of a cell's box in unit space; an axis of which the address says nothing spans all of it.
///
/// # Errors
/// If the recording does not say how cells are addressed.
pub fn cell_box(options: &Options, cell: u32) -> Result<([f32; 3], [f32; 3]), String> {
    let layout = LayoutText::parse(&options.table_layout).and_then(|text| text.expand(1));
    let layout = layout.map_err(|error| error.to_string())?;
    let bits = options.table_bits;
    if !(TABLE_BITS_MIN..=TABLE_BITS_MAX).contains(&bits) {
        return Err(StoredTableError::Bits { bits }.to_string());
    }
    let (mut low, mut high) = ([0.0; 3], [1.0; 3]);
    for field in decode(&layout, bits, u64::from(cell)) {
        let axis = match field.coordinate {
            Coordinate::OriginX => 0,
            Coordinate::OriginY => 1,
            Coordinate::OriginZ => 2,
            _ => continue,
        };
        let (from, to) = field.range();
        (low[axis], high[axis]) = (from as f32, to as f32);
    }
    Ok((low, high))
}

/// The boxes in which the rays of a table's touched cells start, those of most rays first and at most `most`,
/// with the mean length of their rays; and the range of these. Cells that differ in direction alone share a box.
pub fn cells(options: &Options, queue: &Queue, most: usize) -> (Geometry, ValueRange) {
    let layout = LayoutText::parse(&options.table_layout).and_then(|text| text.expand(1));
    let (Ok(layout), Ok(touched)) = (layout, &queue.cells) else {
        return (boxes(std::iter::empty()).into(), ValueRange { low: 0.0, high: 1.0 });
    };
    let mut of_origin: BTreeMap<[(u32, u32); 3], (u64, u64)> = BTreeMap::new();
    for cell in &**touched {
        let mut origin = [(0, 0); 3];
        for field in decode(&layout, options.table_bits, u64::from(cell.cell)) {
            match field.coordinate {
                Coordinate::OriginX => origin[0] = (field.bits, field.value),
                Coordinate::OriginY => origin[1] = (field.bits, field.value),
                Coordinate::OriginZ => origin[2] = (field.bits, field.value),
                _ => {}
            }
        }
        let found = of_origin.entry(origin).or_default();
        *found = (found.0 + u64::from(cell.count), found.1.saturating_add(cell.sum));
    }
    let mut found: Vec<_> = of_origin.into_iter().collect();
    found.sort_by_key(|(origin, (count, _))| (std::cmp::Reverse(*count), *origin));
    found.truncate(most);
    let side =
        |(bits, value): (u32, u32), after: u32| (f64::from(value + after) / 2f64.powi(bits as i32)) as f32;
    let mean = |(count, sum): (u64, u64)| (sum as f64 / LENGTH_UNIT / count.max(1) as f64) as f32;
    let values: Vec<f32> = found.iter().map(|(_, sums)| mean(*sums)).collect();
    let range = Values::of(values.into_par_iter()).percentiles(2.0, 98.0);
    let shape = boxes(found.into_iter().map(|(origin, sums)| {
        ((origin.map(|along| side(along, 0)), origin.map(|along| side(along, 1))), mean(sums))
    }));
    (shape.into(), range)
}

/// Parts of a unit length that sums of the length table count.
const LENGTH_UNIT: f64 = (1u64 << 24) as f64;

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
