//! From rays to keys: the encoder that layouts drive.
//!
//! Many rays are encoded coordinate by coordinate over short blocks. Where the processor has AVX2, the same code is
//! compiled for it, with ways of its own to take rays and to spread bits.

use super::block::{Aligned, Block, Needs};
use super::layout::{CURVE_AXES, Layout, Share, Source};
use super::spread::Spread;
use super::{COORDINATE_BITS, Coordinate, Facts, LightSite, Tiles, hilbert};
use crate::prefetch::prefetch_at;
use crate::ray::Ray;
use crate::unit_space::UnitSpace;

/// Rays of a block.
const BLOCK: usize = 64;
/// Rays ahead that memory is asked for: more than a page, beyond which processors do not look by themselves.
const AHEAD: usize = 3 * BLOCK;
/// Rays of a cache line.
const LINE: usize = 64 / size_of::<Ray>();

/// A word that keys are written to.
pub trait Word {
    /// The lowest bits of a key.
    fn of(key: u64) -> Self;
}

impl Word for u32 {
    #[inline(always)]
    fn of(key: u64) -> Self {
        key as Self
    }
}

impl Word for u64 {
    #[inline(always)]
    fn of(key: u64) -> Self {
        key
    }
}

/// Turns rays into keys of `key_bits` bits, right-aligned, by one layout.
#[derive(Clone, Debug)]
pub struct Encoder {
    unit: UnitSpace,
    lights: Vec<LightSite>,
    tiles: Option<Tiles>,
    parts: Vec<Part>,
    needs: Needs,
}

/// What one source adds to a key.
#[derive(Clone, Debug)]
struct Part {
    source: Source,
    width: u32,
    /// One for each axis.
    spreads: Vec<Spread>,
}

impl Part {
    fn new(share: &Share) -> Self {
        let spreads = share.positions.iter().map(|positions| Spread::new(share.width, positions));
        Self { source: share.source, width: share.width, spreads: spreads.collect() }
    }

    /// Hands the numbers that each axis spreads to `add`; `quantise` writes a coordinate of all rays.
    #[inline(always)]
    fn each<const N: usize>(
        &self,
        quantise: impl Fn(Coordinate, &mut [u32; N]),
        mut add: impl FnMut(&Spread, &[u32; N]),
    ) {
        if let ([axis], [spread]) = (self.source.axes(), self.spreads.as_slice()) {
            let mut numbers = Aligned([0; N]);
            quantise(*axis, &mut numbers.0);
            return add(spread, &numbers.0);
        }
        let mut words = [[0; N]; CURVE_AXES];
        let words = &mut words[..self.spreads.len()];
        for (word, &axis) in words.iter_mut().zip(self.source.axes()) {
            quantise(axis, word);
            word.iter_mut().for_each(|number| *number >>= COORDINATE_BITS - self.width);
        }
        hilbert::to_curve(words, self.width);
        self.spreads.iter().zip(words.iter()).for_each(|(spread, word)| add(spread, word));
    }
}

impl Encoder {
    /// An encoder for the k-bit prefix (8 ≤ `key_bits` ≤ 64) of `layout`.
    ///
    /// `lights` are the scene's, by index; only layouts with light coordinates look at them.
    pub fn new(layout: &Layout, key_bits: u32, unit: UnitSpace, lights: &[LightSite]) -> Self {
        let shares = layout.shares(key_bits);
        let needs = Needs::of(shares.iter().flat_map(|share| share.source.axes().iter().copied()));
        let (lights, tiles, parts) =
            (lights.to_vec(), layout.tiles(), shares.iter().map(Part::new).collect());
        Self { unit, lights, tiles, parts, needs }
    }

    /// The key of a ray.
    ///
    /// # Panics
    /// If the layout has light coordinates and the light is not an index into the lights given.
    pub fn encode(&self, ray: &Ray, facts: Facts) -> u64 {
        let mut block = Block::<1>::empty();
        let of_one = Facts { length: |_| facts.length, light: |_| facts.light, path: |_| facts.path };
        let ray = std::slice::from_ref(ray);
        block.load(&self.unit, ray);
        self.derive(&mut block, ray, 0, &of_one);
        let [key] = self.keys(&block);
        key
    }

    /// Keys of many rays, a key for each; of keys that are wider than a word, its lowest bits.
    ///
    /// # Panics
    /// As [`Encoder::encode`], or if there are not as many keys as rays.
    pub fn encode_all<W: Word>(
        &self,
        rays: &[Ray],
        facts: &Facts<impl Fn(usize) -> f32, impl Fn(usize) -> u32, impl Fn(usize) -> u32>,
        keys: &mut [W],
    ) {
        assert_eq!(rays.len(), keys.len(), "a key for each ray");
        #[cfg(target_arch = "x86_64")]
        if is_x86_feature_detected!("avx2") {
            // SAFETY: the processor has AVX2.
            return unsafe { self.encode_all_avx2(rays, facts, keys) };
        }
        self.encode_all_portably(rays, facts, keys);
    }

    fn encode_all_portably<W: Word>(
        &self,
        rays: &[Ray],
        facts: &Facts<impl Fn(usize) -> f32, impl Fn(usize) -> u32, impl Fn(usize) -> u32>,
        keys: &mut [W],
    ) {
        let mut block = Block::<BLOCK>::empty();
        for (number, (block_rays, keys)) in rays.chunks(BLOCK).zip(keys.chunks_mut(BLOCK)).enumerate() {
            let first = number * BLOCK;
            (first..first + BLOCK).step_by(LINE).for_each(|at| prefetch_at(rays, at + AHEAD));
            block.load(&self.unit, block_rays);
            self.derive(&mut block, block_rays, first, facts);
            keys.iter_mut().zip(self.keys(&block)).for_each(|(word, key)| *word = W::of(key));
        }
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn encode_all_avx2<W: Word>(
        &self,
        rays: &[Ray],
        facts: &Facts<impl Fn(usize) -> f32, impl Fn(usize) -> u32, impl Fn(usize) -> u32>,
        keys: &mut [W],
    ) {
        let mut block = Block::<BLOCK>::empty();
        for (number, (block_rays, keys)) in rays.chunks(BLOCK).zip(keys.chunks_mut(BLOCK)).enumerate() {
            let first = number * BLOCK;
            (first..first + BLOCK).step_by(LINE).for_each(|at| prefetch_at(rays, at + AHEAD));
            block.load_avx2(&self.unit, block_rays, self.needs.direction);
            self.derive(&mut block, block_rays, first, facts);
            let mut words = Aligned([[0; BLOCK]; 2]);
            for part in &self.parts {
                let quantise = |axis, numbers: &mut _| block.quantise_avx2(axis, numbers);
                part.each(quantise, |spread, numbers| spread.add_to_words(&mut words.0, numbers));
            }
            let [low, high] = &words.0;
            for ((word, low), high) in keys.iter_mut().zip(low).zip(high) {
                *word = W::of(u64::from(*high) << 32 | u64::from(*low));
            }
        }
    }

    /// Derives what the keys of the rays in a block are made from, the first of which has number `first`.
    #[inline(always)]
    fn derive<const N: usize>(
        &self,
        block: &mut Block<N>,
        rays: &[Ray],
        first: usize,
        facts: &Facts<impl Fn(usize) -> f32, impl Fn(usize) -> u32, impl Fn(usize) -> u32>,
    ) {
        if self.needs.end {
            block.find_ends(&self.unit, rays, |at| (facts.length)(first + at));
        }
        if self.needs.octahedral {
            block.find_octahedral();
        }
        if self.needs.light {
            block.find_lights(|at| (facts.light)(first + at));
        }
        if self.needs.from_light {
            block.find_from_light(&self.lights);
        }
        if let Some(tiles) = self.tiles.as_ref().filter(|_| self.needs.path) {
            block.find_tiles(tiles, |at| (facts.path)(first + at));
        }
    }

    fn keys<const N: usize>(&self, block: &Block<N>) -> [u64; N] {
        let mut keys = [0; N];
        for part in &self.parts {
            let quantise = |axis, numbers: &mut _| block.quantise(axis, numbers);
            part.each(quantise, |spread, numbers| spread.add_to(&mut keys, numbers));
        }
        keys
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::key::method::BUILTIN;
    use crate::key::{Extent, Method};

    /// One of each kind.
    fn lights() -> [LightSite; 3] {
        let placed = LightSite::Placed { centre: [0.5, 0.2, 0.4] };
        [placed, LightSite::directional([0.0, -1.0, 0.0]), LightSite::Environment]
    }

    fn extent() -> Extent {
        Extent { lights: lights().len(), picture: [1920, 1080] }
    }

    #[test]
    fn a_layout_shorter_than_the_key_leaves_zeros_at_the_end() {
        let unit = UnitSpace::from_bounds([0.0; 3], [1.0; 3]);
        let layout = crate::key::LayoutText::parse("(ox oy)*4").unwrap().expand(Extent::NOTHING).unwrap();
        let ray = Ray { origin: [1.0, 0.0, 0.0], t_min: 0.0, direction: [0.0, 0.0, 1.0], t_max: 1.0 };
        assert_eq!(
            Encoder::new(&layout, 16, unit, &[]).encode(&ray, Facts::default()),
            0b1010_1010_0000_0000
        );
    }

    /// Rays of all kinds, those included that only files have.
    fn random_rays() -> Vec<Ray> {
        let mut generator = fastrand::Rng::with_seed(5);
        let mut random = || 2.0 * generator.f32() - 1.0;
        let mut ray = || Ray {
            origin: [random() * 3.0, random(), random()],
            t_min: 0.0,
            direction: [random(), random(), random()],
            t_max: if random() > 0.0 { f32::INFINITY } else { 0.5 },
        };
        // Not a multiple of eight.
        let mut rays: Vec<Ray> = (0..4003).map(|_| ray()).collect();
        let odd = [0.0, -0.0, 1.0, -1.0, f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e-40, -3e38];
        for ray in &mut rays[1000..] {
            for value in ray.origin.iter_mut().chain(&mut ray.direction).chain([&mut ray.t_max]) {
                if generator.u32(0..4) == 0 {
                    *value = odd[generator.usize(0..odd.len())];
                }
            }
        }
        rays
    }

    #[test]
    fn blocks_have_the_keys_of_single_rays() {
        let rays = random_rays();
        let unit = UnitSpace::from_bounds([-1.0; 3], [1.0; 3]);
        let lights = lights();
        let facts = Facts {
            length: |at: usize| at as f32 / 2000.0,
            light: |at: usize| at as u32 % 3,
            path: |at: usize| at as u32 * 500,
        };
        let of = |at: usize| Facts {
            length: (facts.length)(at),
            light: (facts.light)(at),
            path: (facts.path)(at),
        };
        for (name, ..) in BUILTIN {
            let layout = Method::builtin(name).unwrap().layout.expand(extent()).unwrap();
            for key_bits in [8, 17, 32, 33, 64] {
                let encoder = Encoder::new(&layout, key_bits, unit, &lights);
                let single = rays.iter().enumerate();
                let single: Vec<u64> = single.map(|(at, ray)| encoder.encode(ray, of(at))).collect();
                let (mut keys, mut narrow) = (vec![0u64; rays.len()], vec![0u32; rays.len()]);
                encoder.encode_all(&rays, &facts, &mut keys);
                assert_eq!(keys, single, "{name} at {key_bits} bits");
                encoder.encode_all_portably(&rays, &facts, &mut keys);
                assert_eq!(keys, single, "{name} at {key_bits} bits, portably");
                encoder.encode_all(&rays, &facts, &mut narrow);
                let is_same = |(&narrow, &key): (&u32, &u64)| narrow == key as u32;
                assert!(narrow.iter().zip(&keys).all(is_same), "{name} at {key_bits} bits, narrow");
            }
        }
    }
}
