//! From keys back to the coordinates that they hold.

use super::hilbert;
use super::layout::{Bit, Coordinate, Layout, by_axis};

/// What a key says about one coordinate, or about several that `^` combines.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DecodedField {
    /// What its bits are.
    pub bit: Bit,
    /// Its bits that the key holds, right-aligned.
    pub value: u64,
    /// How many bits those are, 1 to 22 of one coordinate.
    pub bits: u32,
}

impl DecodedField {
    /// The range of coordinate values that share these bits, within [0, 1]; none where `^` hides them.
    pub fn range(&self) -> Option<(f64, f64)> {
        self.bit.coordinate()?;
        let cell = (-f64::from(self.bits)).exp2();
        Some((self.value as f64 * cell, (self.value + 1) as f64 * cell))
    }
}

/// The fields of a key of `key_bits` bits, in the layout's order of first mention; of a curve those of its
/// coordinates. Where the key ends within a level of a curve, some of them have a bit more than others.
pub fn decode(layout: &Layout, key_bits: u32, key: u64) -> Vec<DecodedField> {
    let mut decoded = Vec::new();
    for field in layout.fields(key_bits) {
        match field.bit.sources() {
            [source] if source.axes().len() > 1 => {
                let found =
                    source.axes().iter().zip(on_curve(&by_axis(&field.positions, source.axes().len()), key));
                let found = found.filter(|(_, (_, bits))| *bits > 0);
                decoded.extend(found.map(|(&axis, (value, bits))| DecodedField {
                    bit: axis.into(),
                    value: value.into(),
                    bits,
                }));
            }
            _ => decoded.push(DecodedField {
                value: bits_at(key, &field.positions),
                bits: field.positions.len() as u32,
                bit: field.bit,
            }),
        }
    }
    decoded
}

/// Reads one coordinate out of keys, as many bits of it as all keys have.
#[derive(Clone, Debug)]
pub struct FieldReader {
    /// Positions of the bits of each axis of its source, highest first.
    positions: Vec<Vec<u32>>,
    axis: usize,
}

impl FieldReader {
    /// Of a coordinate in keys of `key_bits` bits; `None` if they have no whole bit of it, or `^` hides it.
    pub fn new(layout: &Layout, key_bits: u32, coordinate: Coordinate) -> Option<Self> {
        layout.fields(key_bits).into_iter().find_map(|field| {
            let [source] = field.bit.sources() else { return None };
            let axis = source.axes().iter().position(|&axis| axis == coordinate)?;
            let mut positions = by_axis(&field.positions, source.axes().len());
            let levels = positions.last().map_or(0, Vec::len);
            positions.iter_mut().for_each(|positions| positions.truncate(levels));
            (levels > 0).then_some(Self { positions, axis })
        })
    }

    /// Its bits in a key, right-aligned.
    pub fn value(&self, key: u64) -> u64 {
        match self.positions.as_slice() {
            [positions] => bits_at(key, positions),
            positions => u64::from(cell(positions, key, 0)[self.axis]),
        }
    }

    /// How many bits those are.
    pub fn bits(&self) -> u32 {
        self.positions[self.axis].len() as u32
    }
}

/// The number that these bits of a key make, the highest first.
fn bits_at(key: u64, positions: &[u32]) -> u64 {
    positions.iter().fold(0, |bits, &at| bits << 1 | key >> at & 1)
}

/// The bits of each coordinate of a curve, and how many those are.
fn on_curve(positions: &[Vec<u32>], key: u64) -> Vec<(u32, u32)> {
    let (first, levels) = (cell(positions, key, 0), positions[0].len() as u32);
    // The cells of the last level that the key leaves possible are a box.
    let mut differing = vec![0; first.len()];
    for rest in 1..1 << first.len() {
        let other = cell(positions, key, rest);
        (0..first.len()).for_each(|axis| differing[axis] |= first[axis] ^ other[axis]);
    }
    first.iter().zip(differing).map(|(&value, unknown)| (value >> unknown, levels - unknown)).collect()
}

/// The cell of a curve's last level; the bits of it that the key has not are those of `rest`.
fn cell(positions: &[Vec<u32>], key: u64, rest: usize) -> Vec<u32> {
    let levels = positions[0].len();
    let word = |(axis, positions): (usize, &Vec<u32>)| {
        let word = bits_at(key, positions) as u32;
        if positions.len() < levels { word << 1 | (rest >> axis & 1) as u32 } else { word }
    };
    let mut words: Vec<u32> = positions.iter().enumerate().map(word).collect();
    hilbert::from_curve(&mut words, levels as u32);
    words
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::key::{Extent, LayoutText};

    #[test]
    fn a_key_that_ends_within_a_level_knows_more_of_some_coordinates() {
        let layout = LayoutText::parse("hilbert(ox oy oz)*").unwrap().expand(Extent::NOTHING).unwrap();
        for key in (0..1u64 << 32).step_by(999_983) {
            let fields = decode(&layout, 32, key);
            assert_eq!(fields.iter().map(|field| field.bits).sum::<u32>(), 32);
            for field in &fields {
                let reader = FieldReader::new(&layout, 32, field.bit.coordinate().unwrap()).unwrap();
                assert_eq!((reader.bits(), reader.value(key)), (10, field.value >> (field.bits - 10)));
            }
        }
    }

    #[test]
    fn what_an_exclusive_or_hides_is_not_made_up() {
        let layout = LayoutText::parse("(ox oy)*4 ^ (u v)*4 oz").unwrap().expand(Extent::NOTHING).unwrap();
        let fields = decode(&layout, 9, 0b1_0110_1001);
        let found: Vec<_> = fields.iter().map(|field| (field.bit.to_string(), field.value)).collect();
        assert_eq!(found, [("ox ^ u".into(), 0b1100), ("oy ^ v".into(), 0b0110), ("oz".into(), 1)]);
        assert_eq!(fields.iter().filter_map(DecodedField::range).collect::<Vec<_>>(), [(0.5, 1.0)]);
        assert!(FieldReader::new(&layout, 9, Coordinate::OriginX).is_none());
    }
}
