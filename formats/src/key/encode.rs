//! From rays to keys: the encoder that layouts drive.
//!
//! Many rays are encoded coordinate by coordinate over short blocks, so that the loops have no branches and
//! processors with vectors use them.

use super::coordinates::{cartesian, from_light, octahedral, quantise};
use super::layout::{Coordinate, Field, Layout};
use super::{LightSite, angle, termination};
use crate::ray::Ray;
use crate::unit_space::UnitSpace;

/// Bits of a coordinate that one table lookup spreads over the key.
const CHUNK_BITS: u32 = 8;
/// Rays of a block.
const BLOCK: usize = 64;

/// Turns rays into keys of `key_bits` bits, right-aligned, by one layout.
#[derive(Clone, Debug)]
pub struct Encoder {
    unit: UnitSpace,
    lights: Vec<LightSite>,
    spreads: Vec<Spread>,
    needs: Needs,
}

/// One field's bits, spread to their places by table.
#[derive(Clone, Debug)]
struct Spread {
    coordinate: Coordinate,
    /// Shift that brings a quantised coordinate down to the bits that the key uses.
    drop: u32,
    /// One table per chunk of used bits, lowest chunk first.
    tables: Vec<[u64; 1 << CHUNK_BITS]>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Needs {
    end: bool,
    octahedral: bool,
    /// Light coordinates.
    light: bool,
    /// Light coordinates or the light itself.
    light_index: bool,
}

/// What the keys of up to `N` rays are made from.
struct Block<'a, const N: usize> {
    rays: &'a [Ray],
    lights: [u32; N],
    origin: [[f32; N]; 3],
    end: [[u32; N]; 3],
    octahedral: [[f32; N]; 2],
    from_light: [[f32; N]; 3],
}

impl Spread {
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

    fn add_to<const N: usize>(&self, keys: &mut [u64; N], quantised: &[u32; N]) {
        for (chunk, table) in self.tables.iter().enumerate() {
            let shift = self.drop + chunk as u32 * CHUNK_BITS;
            for (key, quantised) in keys.iter_mut().zip(quantised) {
                *key |= table[(quantised >> shift) as usize & (table.len() - 1)];
            }
        }
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
        let [key] = self.keys(std::slice::from_ref(ray), |_| length, |_| light);
        key
    }

    /// Keys of many rays: `put(i, key)` for each i in order. `length` and `light` give what
    /// [`Encoder::encode`] takes for ray i; they are only asked if the layout needs them.
    ///
    /// # Panics
    /// As [`Encoder::encode`].
    pub fn encode_all(
        &self,
        rays: &[Ray],
        length: impl Fn(usize) -> f32,
        light: impl Fn(usize) -> u32,
        mut put: impl FnMut(usize, u64),
    ) {
        for (number, rays) in rays.chunks(BLOCK).enumerate() {
            let first = number * BLOCK;
            let keys: [u64; BLOCK] = self.keys(rays, |at| length(first + at), |at| light(first + at));
            keys.iter().take(rays.len()).enumerate().for_each(|(at, &key)| put(first + at, key));
        }
    }

    /// Keys of up to `N` rays.
    fn keys<const N: usize>(
        &self,
        rays: &[Ray],
        length: impl Fn(usize) -> f32,
        light: impl Fn(usize) -> u32,
    ) -> [u64; N] {
        let block: Block<'_, N> = self.block(rays, length, light);
        let mut keys = [0; N];
        for spread in &self.spreads {
            spread.add_to(&mut keys, &block.quantised(spread.coordinate));
        }
        keys
    }

    fn block<'a, const N: usize>(
        &self,
        rays: &'a [Ray],
        length: impl Fn(usize) -> f32,
        light: impl Fn(usize) -> u32,
    ) -> Block<'a, N> {
        let mut block = Block {
            rays,
            lights: [0; N],
            origin: [[0.0; N]; 3],
            end: [[0; N]; 3],
            octahedral: [[0.0; N]; 2],
            from_light: [[0.0; N]; 3],
        };
        for (at, ray) in rays.iter().enumerate() {
            let origin = self.unit.point(ray.origin);
            (0..3).for_each(|axis| block.origin[axis][at] = origin[axis]);
            if self.needs.end {
                let length = termination::bounded_length(&self.unit, ray, origin, length(at));
                let end = |axis: usize| termination::end_quantised(origin[axis], length, ray.direction[axis]);
                (0..3).for_each(|axis| block.end[axis][at] = end(axis));
            }
            if self.needs.octahedral {
                let [u, v] = octahedral(ray.direction);
                (block.octahedral[0][at], block.octahedral[1][at]) = (u, v);
            }
            if self.needs.light_index {
                block.lights[at] = light(at);
            }
            if self.needs.light {
                let site = &self.lights[block.lights[at] as usize];
                let seen = from_light(site, origin, ray.direction);
                (0..3).for_each(|axis| block.from_light[axis][at] = seen[axis]);
            }
        }
        block
    }
}

impl<const N: usize> Block<'_, N> {
    /// A coordinate that depends on the direction alone.
    fn of_direction(&self, map: impl Fn([f32; 3]) -> f32) -> [u32; N] {
        let mut lane = [0; N];
        lane.iter_mut().zip(self.rays).for_each(|(value, ray)| *value = quantise(map(ray.direction)));
        lane
    }

    fn quantised(&self, coordinate: Coordinate) -> [u32; N] {
        use Coordinate as C;
        match coordinate {
            C::OriginX => self.origin[0].map(quantise),
            C::OriginY => self.origin[1].map(quantise),
            C::OriginZ => self.origin[2].map(quantise),
            C::EndX => self.end[0],
            C::EndY => self.end[1],
            C::EndZ => self.end[2],
            C::DirectionX => self.of_direction(|d| cartesian(d[0])),
            C::DirectionY => self.of_direction(|d| cartesian(d[1])),
            C::DirectionZ => self.of_direction(|d| cartesian(d[2])),
            C::OctahedralU => self.octahedral[0].map(quantise),
            C::OctahedralV => self.octahedral[1].map(quantise),
            C::Azimuth => self.of_direction(|d| angle::azimuth(d[0], d[1])),
            C::Polar => self.of_direction(|d| angle::polar(d[2])),
            C::Light => self.lights,
            C::LightU => self.from_light[0].map(quantise),
            C::LightV => self.from_light[1].map(quantise),
            C::LightR => self.from_light[2].map(quantise),
        }
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

    /// One of each kind.
    fn lights() -> [LightSite; 3] {
        let placed = LightSite::Placed { centre: [0.5, 0.2, 0.4] };
        [placed, LightSite::directional([0.0, -1.0, 0.0]), LightSite::Environment]
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
        let lights = lights();
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

    #[test]
    fn blocks_have_the_keys_of_single_rays() {
        let mut generator = fastrand::Rng::with_seed(5);
        let mut random = || 2.0 * generator.f32() - 1.0;
        let mut ray = || Ray {
            origin: [random() * 3.0, random(), random()],
            t_min: 0.0,
            direction: [random(), random(), random()],
            t_max: if random() > 0.0 { f32::INFINITY } else { 0.5 },
        };
        let mut rays: Vec<Ray> = (0..1000).map(|_| ray()).collect();
        // Whatever a file may hold.
        rays[3].origin = [f32::NAN, f32::INFINITY, -0.0];
        rays[70].direction = [0.0; 3];
        let unit = UnitSpace::from_bounds([-1.0; 3], [1.0; 3]);
        let lights = lights();
        let light = |at: usize| at as u32 % 3;
        let length = |at: usize| at as f32 / 700.0;
        for (name, ..) in BUILTIN {
            let layout = Method::builtin(name).unwrap().layout.expand(lights.len()).unwrap();
            for key_bits in [8, 17, 32, 64] {
                let encoder = Encoder::new(&layout, key_bits, unit, &lights);
                let mut keys = Vec::new();
                encoder.encode_all(&rays, length, light, |at, key| {
                    assert_eq!(at, keys.len());
                    keys.push(key);
                });
                let single =
                    rays.iter().enumerate().map(|(at, ray)| encoder.encode(ray, length(at), light(at)));
                assert_eq!(keys, single.collect::<Vec<u64>>(), "{name} at {key_bits} bits");
            }
        }
    }
}
