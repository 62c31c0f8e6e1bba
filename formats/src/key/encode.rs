//! From rays to keys: the encoder that layouts drive.

use super::coordinates::{cartesian, from_light, octahedral, quantise};
use super::layout::{Coordinate, Field, Layout};
use super::{LightSite, angle, termination};
use crate::ray::Ray;
use crate::unit_space::UnitSpace;

/// Bits of a coordinate that one table lookup spreads over the key.
const CHUNK_BITS: u32 = 8;

/// Turns rays into keys of `key_bits` bits, right-aligned, by one layout.
#[derive(Clone, Debug)]
pub struct Encoder {
    pub(super) unit: UnitSpace,
    pub(super) lights: Vec<LightSite>,
    pub(super) spreads: Vec<Spread>,
    pub(super) needs: Needs,
}

/// One field's bits, spread to their places by table.
#[derive(Clone, Debug)]
pub(super) struct Spread {
    pub(super) coordinate: Coordinate,
    /// Shift that brings a quantised coordinate down to the bits that the key uses.
    pub(super) drop: u32,
    /// One table per chunk of used bits, lowest chunk first.
    pub(super) tables: Vec<[u64; 1 << CHUNK_BITS]>,
}

#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Needs {
    pub(super) end: bool,
    pub(super) octahedral: bool,
    /// Light coordinates.
    pub(super) light: bool,
    /// Light coordinates or the light itself.
    pub(super) light_index: bool,
}

/// A ray's coordinates as far as the layout needs them.
struct Values {
    origin: [f32; 3],
    end: [u32; 3],
    octahedral: [f32; 2],
    from_light: [f32; 3],
}

impl Spread {
    /// Bits that one table spreads.
    pub(super) const CHUNK_BITS: u32 = CHUNK_BITS;

    fn new(field: &Field) -> Self {
        let used = field.positions.len() as u32;
        let chunks = used.div_ceil(CHUNK_BITS);
        let tables = (0..chunks)
            .map(|chunk| {
                std::array::from_fn(|value| {
                    (0..CHUNK_BITS)
                        .filter(|bit| value >> bit & 1 == 1)
                        .filter_map(|bit| (used - 1).checked_sub(chunk * CHUNK_BITS + bit))
                        .map(|mention| 1u64 << field.positions[mention as usize])
                        .sum()
                })
            })
            .collect();
        Self { coordinate: field.coordinate, drop: field.width - used, tables }
    }

    fn apply(&self, quantised: u32) -> u64 {
        let mut rest = quantised >> self.drop;
        let mut key = 0;
        for table in &self.tables {
            key |= table[(rest & ((1 << CHUNK_BITS) - 1)) as usize];
            rest >>= CHUNK_BITS;
        }
        key
    }
}

impl Encoder {
    /// An encoder for the k-bit prefix (8 ≤ `key_bits` ≤ 64) of `layout`.
    ///
    /// `lights` are the scene's, by index; only layouts with light coordinates look at them.
    pub fn new(layout: &Layout, key_bits: u32, unit: UnitSpace, lights: &[LightSite]) -> Self {
        let fields = layout.fields(key_bits);
        let uses = |predicate: fn(Coordinate) -> bool| fields.iter().any(|field| predicate(field.coordinate));
        let needs = Needs {
            end: uses(Coordinate::needs_length),
            octahedral: uses(|coordinate| {
                matches!(coordinate, Coordinate::OctahedralU | Coordinate::OctahedralV)
            }),
            light: uses(|coordinate| {
                matches!(coordinate, Coordinate::LightU | Coordinate::LightV | Coordinate::LightR)
            }),
            light_index: uses(Coordinate::needs_light),
        };
        Self { unit, lights: lights.to_vec(), spreads: fields.iter().map(Spread::new).collect(), needs }
    }

    /// The key of a ray. `length` is the estimate in unit lengths, `light` the index of a shadow
    /// ray's light; layouts that need neither ignore them.
    ///
    /// # Panics
    /// If the layout has light coordinates and `light` is not an index into the lights given.
    pub fn encode(&self, ray: &Ray, length: f32, light: u32) -> u64 {
        let values = self.values(ray, length, light);
        self.spreads
            .iter()
            .map(|spread| spread.apply(quantised(spread.coordinate, &values, ray, light)))
            .sum()
    }

    fn values(&self, ray: &Ray, length: f32, light: u32) -> Values {
        let origin = self.unit.point(ray.origin);
        let mut values = Values { origin, end: [0; 3], octahedral: [0.0; 2], from_light: [0.0; 3] };
        if self.needs.end {
            let length = termination::bounded_length(&self.unit, ray, origin, length);
            values.end =
                [0, 1, 2].map(|axis| termination::end_quantised(origin[axis], length, ray.direction[axis]));
        }
        if self.needs.octahedral {
            values.octahedral = octahedral(ray.direction);
        }
        if self.needs.light {
            values.from_light = from_light(&self.lights[light as usize], origin, ray.direction);
        }
        values
    }
}

fn quantised(coordinate: Coordinate, values: &Values, ray: &Ray, light: u32) -> u32 {
    use Coordinate as C;
    let direction = ray.direction;
    match coordinate {
        C::OriginX => quantise(values.origin[0]),
        C::OriginY => quantise(values.origin[1]),
        C::OriginZ => quantise(values.origin[2]),
        C::EndX => values.end[0],
        C::EndY => values.end[1],
        C::EndZ => values.end[2],
        C::DirectionX => quantise(cartesian(direction[0])),
        C::DirectionY => quantise(cartesian(direction[1])),
        C::DirectionZ => quantise(cartesian(direction[2])),
        C::OctahedralU => quantise(values.octahedral[0]),
        C::OctahedralV => quantise(values.octahedral[1]),
        C::Azimuth => quantise(angle::azimuth(direction[0], direction[1])),
        C::Polar => quantise(angle::polar(direction[2])),
        C::Light => light,
        C::LightU => quantise(values.from_light[0]),
        C::LightV => quantise(values.from_light[1]),
        C::LightR => quantise(values.from_light[2]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::key::Method;
    use crate::key::method::BUILTIN;

    fn ray(i: u32) -> Ray {
        let part = |salt: u32| (i.wrapping_add(1).wrapping_mul(salt) >> 8) as f32 / (1u32 << 24) as f32;
        let [x, y, z] = [part(2_654_435_761) - 0.5, part(2_246_822_519) - 0.5, part(3_266_489_917) - 0.5];
        let length = (x * x + y * y + z * z).sqrt().max(1e-6);
        Ray {
            origin: [part(668_265_263) * 4.0 - 1.0, part(374_761_393) * 2.0, part(1_274_126_177) * 3.0 + 7.0],
            t_min: 0.0,
            direction: [x / length, y / length, z / length],
            t_max: if i.is_multiple_of(3) { 0.7 } else { f32::INFINITY },
        }
    }

    /// Bit by bit in f64 and u128, straight from KEYS, sharing no code with the encoder.
    fn slow_origin_bits(unit: &UnitSpace, ray: &Ray, key_bits: u32) -> u64 {
        let mut key = 0u64;
        for place in 0..key_bits {
            let (axis, level) = ((place % 3) as usize, place / 3);
            let u = f64::from((ray.origin[axis] - unit.min[axis]) * unit.scale).clamp(0.0, 1.0 - 1e-12);
            let bit = (u * 2f64.powi(level as i32 + 1)).floor() as u64 & 1;
            key = key << 1 | bit;
        }
        key
    }

    #[test]
    fn origin_keys_are_morton_codes() {
        let unit = UnitSpace::from_bounds([-1.0, 0.0, 7.0], [3.0, 2.0, 10.0]);
        let layout = Method::builtin("origin").unwrap().layout.expand(1).unwrap();
        for key_bits in [8, 16, 31, 32, 33, 63, 64] {
            let encoder = Encoder::new(&layout, key_bits, unit, &[]);
            for i in 0..2000 {
                let ray = ray(i);
                assert_eq!(
                    encoder.encode(&ray, 0.0, 0),
                    slow_origin_bits(&unit, &ray, key_bits),
                    "ray {i}, {key_bits} bits"
                );
            }
        }
    }

    #[test]
    fn short_keys_are_prefixes_of_long_ones() {
        let unit = UnitSpace::from_bounds([-1.0, 0.0, 7.0], [3.0, 2.0, 10.0]);
        let lights = [
            LightSite::Placed { centre: [0.5, 0.2, 0.4] },
            LightSite::directional([0.0, -1.0, 0.0]),
            LightSite::Environment,
        ];
        for (name, ..) in BUILTIN {
            let layout = Method::builtin(name).unwrap().layout.expand(lights.len()).unwrap();
            let long = Encoder::new(&layout, 64, unit, &lights);
            for key_bits in 8..64 {
                let short = Encoder::new(&layout, key_bits, unit, &lights);
                for i in 0..50 {
                    let (ray, light) = (ray(i), i % 3);
                    assert_eq!(
                        short.encode(&ray, 0.3, light),
                        long.encode(&ray, 0.3, light) >> (64 - key_bits),
                        "{name}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_layout_shorter_than_the_key_leaves_zeros_at_the_end() {
        let unit = UnitSpace::from_bounds([0.0; 3], [1.0; 3]);
        let layout = crate::key::LayoutText::parse("(ox oy)*4").unwrap().expand(1).unwrap();
        let ray = Ray { origin: [1.0, 0.0, 0.0], t_min: 0.0, direction: [0.0, 0.0, 1.0], t_max: 1.0 };
        assert_eq!(Encoder::new(&layout, 16, unit, &[]).encode(&ray, 0.0, 0), 0b1010_1010_0000_0000);
    }
}
