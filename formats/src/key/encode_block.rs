//! Many rays at once: coordinate by coordinate over short blocks, so that the loops have no branches and
//! processors with vectors use them. The keys are those of [`Encoder::encode`].

use super::coordinates::{cartesian, from_light, octahedral, quantise};
use super::encode::{Encoder, Spread};
use super::layout::Coordinate;
use super::{angle, termination};
use crate::ray::Ray;

/// Rays of a block.
const BLOCK: usize = 64;

/// One number per ray of a block.
type Lane<T> = [T; BLOCK];

/// What keys of a block are made from.
struct Block<'a> {
    rays: &'a [Ray],
    lights: Lane<u32>,
    origin: [Lane<f32>; 3],
    end: [Lane<u32>; 3],
    octahedral: [Lane<f32>; 2],
    from_light: [Lane<f32>; 3],
}

impl Encoder {
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
            let block = self.block(rays, |at| length(first + at), |at| light(first + at));
            let mut keys = [0u64; BLOCK];
            for spread in &self.spreads {
                spread.add_to(&mut keys, &block.quantised(spread.coordinate));
            }
            keys.iter().take(rays.len()).enumerate().for_each(|(at, &key)| put(first + at, key));
        }
    }

    fn block<'a>(
        &self,
        rays: &'a [Ray],
        length: impl Fn(usize) -> f32,
        light: impl Fn(usize) -> u32,
    ) -> Block<'a> {
        let mut block = Block {
            rays,
            lights: [0; BLOCK],
            origin: [[0.0; BLOCK]; 3],
            end: [[0; BLOCK]; 3],
            octahedral: [[0.0; BLOCK]; 2],
            from_light: [[0.0; BLOCK]; 3],
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

impl Block<'_> {
    fn quantised(&self, coordinate: Coordinate) -> Lane<u32> {
        use Coordinate as C;
        let of_direction = |map: fn([f32; 3]) -> f32| {
            let mut lane = [0; BLOCK];
            lane.iter_mut().zip(self.rays).for_each(|(value, ray)| *value = quantise(map(ray.direction)));
            lane
        };
        match coordinate {
            C::OriginX => self.origin[0].map(quantise),
            C::OriginY => self.origin[1].map(quantise),
            C::OriginZ => self.origin[2].map(quantise),
            C::EndX => self.end[0],
            C::EndY => self.end[1],
            C::EndZ => self.end[2],
            C::DirectionX => of_direction(|d| cartesian(d[0])),
            C::DirectionY => of_direction(|d| cartesian(d[1])),
            C::DirectionZ => of_direction(|d| cartesian(d[2])),
            C::OctahedralU => self.octahedral[0].map(quantise),
            C::OctahedralV => self.octahedral[1].map(quantise),
            C::Azimuth => of_direction(|d| angle::azimuth(d[0], d[1])),
            C::Polar => of_direction(|d| angle::polar(d[2])),
            C::Light => self.lights,
            C::LightU => self.from_light[0].map(quantise),
            C::LightV => self.from_light[1].map(quantise),
            C::LightR => self.from_light[2].map(quantise),
        }
    }
}

impl Spread {
    fn add_to(&self, keys: &mut Lane<u64>, quantised: &Lane<u32>) {
        for (chunk, table) in self.tables.iter().enumerate() {
            let shift = self.drop + chunk as u32 * Self::CHUNK_BITS;
            for (key, quantised) in keys.iter_mut().zip(quantised) {
                *key |= table[(quantised >> shift) as usize & (table.len() - 1)];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::key::method::BUILTIN;
    use crate::key::{Encoder, LightSite, Method};
    use crate::ray::Ray;
    use crate::unit_space::UnitSpace;

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
        let lights = [
            LightSite::Placed { centre: [0.5, 0.2, 0.4] },
            LightSite::directional([0.0, -1.0, 0.0]),
            LightSite::Environment,
        ];
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
