//! From keys back to the coordinates that they hold.

use super::layout::{Coordinate, Layout};

/// What a key says about one coordinate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DecodedField {
    /// Which coordinate.
    pub coordinate: Coordinate,
    /// Its bits that the key holds, right-aligned.
    pub value: u32,
    /// How many bits those are, 1 to 22.
    pub bits: u32,
}

impl DecodedField {
    /// The range of coordinate values that share these bits, within [0, 1].
    pub fn range(&self) -> (f64, f64) {
        let cell = 1.0 / f64::from(1u32 << self.bits);
        (f64::from(self.value) * cell, f64::from(self.value + 1) * cell)
    }
}

/// The fields of a key of `key_bits` bits, in the layout's order of first mention.
pub fn decode(layout: &Layout, key_bits: u32, key: u64) -> Vec<DecodedField> {
    let value_at = |positions: &[u32]| {
        positions.iter().fold(0u32, |value, &position| value << 1 | (key >> position & 1) as u32)
    };
    layout
        .fields(key_bits)
        .into_iter()
        .map(|field| DecodedField {
            coordinate: field.coordinate,
            value: value_at(&field.positions),
            bits: field.positions.len() as u32,
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::key::{Encoder, Method};
    use crate::ray::Ray;
    use crate::unit_space::UnitSpace;

    #[test]
    fn decoding_finds_the_cell_that_was_encoded() {
        let unit = UnitSpace::from_bounds([0.0; 3], [1.0; 3]);
        let ray =
            Ray { origin: [0.3, 0.6, 0.9], t_min: 0.0, direction: [0.0, 0.6, -0.8], t_max: f32::INFINITY };
        for name in ["origin", "reis", "costa", "aila", "octahedron"] {
            let layout = Method::builtin(name).unwrap().layout.expand(1).unwrap();
            for key_bits in [8, 32, 64] {
                let key = Encoder::new(&layout, key_bits, unit, &[]).encode(&ray, 0.0, 0);
                for field in decode(&layout, key_bits, key) {
                    let (low, high) = field.range();
                    let truth = match field.coordinate {
                        Coordinate::OriginX => 0.3,
                        Coordinate::OriginY => 0.6,
                        Coordinate::OriginZ => 0.9,
                        Coordinate::DirectionX => 0.5,
                        Coordinate::DirectionY => 0.8,
                        Coordinate::DirectionZ => 0.1,
                        Coordinate::Azimuth => 0.75,
                        Coordinate::Polar => (-0.8f64).acos() / std::f64::consts::PI,
                        Coordinate::OctahedralU => (1.0 - 0.6 / 1.4) * -0.5 + 0.5,
                        Coordinate::OctahedralV => 1.0,
                        other => panic!("{name} has no {other:?}"),
                    };
                    assert!(
                        (low - 1e-6..=high + 1e-6).contains(&truth),
                        "{name} {key_bits}: {field:?} {truth}"
                    );
                }
            }
        }
    }
}
