//! A few rays coordinate by coordinate: what their keys are made from, in loops without branches, which processors
//! with vectors run several rays at a time.

use super::coordinates::{cartesian, from_light, octahedral, paraboloid, quantise, seen_from};
use super::{Coordinate, LightSite, Tiles, angle, termination};
use crate::ray::Ray;
use crate::unit_space::UnitSpace;

/// Begins with a cache line, so that no eight lanes lie across two.
#[repr(align(64))]
pub(super) struct Aligned<T>(pub(super) T);

/// Up to `N` rays; what lies in lanes without a ray is of no account.
///
/// In this order, all arrays begin with a cache line.
#[repr(C, align(64))]
pub(super) struct Block<const N: usize> {
    /// In unit space.
    origin: [[f32; N]; 3],
    direction: [[f32; N]; 3],
    /// Quantised termination points.
    end: [[u32; N]; 3],
    /// Quantised octahedral direction.
    octahedral: [[u32; N]; 2],
    /// Index of each ray's light.
    lights: [u32; N],
    /// Quantised coordinates from the light.
    from_light: [[u32; N]; 3],
    /// Number of the tile that each ray's path lies in.
    tiles: [u32; N],
    count: usize,
}

/// What a layout asks of a block beyond origins.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Needs {
    pub(super) direction: bool,
    pub(super) end: bool,
    pub(super) octahedral: bool,
    /// Light coordinates.
    pub(super) from_light: bool,
    /// Light coordinates or the light itself.
    pub(super) light: bool,
    /// The path.
    pub(super) path: bool,
}

impl Needs {
    pub(super) fn of(coordinates: impl Iterator<Item = Coordinate>) -> Self {
        use Coordinate as C;
        coordinates.fold(Self::default(), |needs, coordinate| Self {
            direction: needs.direction || coordinate.needs_direction(),
            end: needs.end || coordinate.needs_length(),
            octahedral: needs.octahedral || matches!(coordinate, C::OctahedralU | C::OctahedralV),
            from_light: needs.from_light || matches!(coordinate, C::LightU | C::LightV | C::LightR),
            light: needs.light || coordinate.needs_light(),
            path: needs.path || coordinate.needs_path(),
        })
    }
}

/// Writes a number for each lane. Part of its caller, so that it is compiled for the same processor.
#[inline(always)]
fn each<const N: usize>(numbers: &mut [u32; N], of_lane: impl Fn(usize) -> u32) {
    numbers.iter_mut().enumerate().for_each(|(at, number)| *number = of_lane(at));
}

impl<const N: usize> Block<N> {
    pub(super) fn empty() -> Self {
        Self {
            count: 0,
            origin: [[0.0; N]; 3],
            direction: [[0.0; N]; 3],
            end: [[0; N]; 3],
            octahedral: [[0; N]; 2],
            lights: [0; N],
            from_light: [[0; N]; 3],
            tiles: [0; N],
        }
    }

    /// Takes up to `N` rays in place of those before.
    #[inline(always)]
    pub(super) fn load(&mut self, unit: &UnitSpace, rays: &[Ray]) {
        self.count = rays.len().min(N);
        self.load_from(0, unit, rays);
    }

    /// Takes those from a lane on.
    #[inline(always)]
    fn load_from(&mut self, lane: usize, unit: &UnitSpace, rays: &[Ray]) {
        for (at, ray) in (lane..N).zip(rays.iter().skip(lane)) {
            let origin = unit.point(ray.origin);
            (0..3).for_each(|axis| self.origin[axis][at] = origin[axis]);
            (0..3).for_each(|axis| self.direction[axis][at] = ray.direction[axis]);
        }
    }

    /// The same as [`Block::load`], eight rays at a time.
    #[cfg(target_arch = "x86_64")]
    #[inline]
    #[target_feature(enable = "avx2")]
    pub(super) fn load_avx2(&mut self, unit: &UnitSpace, rays: &[Ray], with_directions: bool) {
        self.count = rays.len().min(N);
        let (groups, _) = rays[..self.count].as_chunks();
        for (number, group) in groups.iter().enumerate() {
            let lanes = number * avx2::LANES..(number + 1) * avx2::LANES;
            let origin = avx2::origins(unit, group);
            (0..3).for_each(|axis| self.origin[axis][lanes.clone()].copy_from_slice(&origin[axis]));
            if with_directions {
                let direction = avx2::directions(group);
                (0..3).for_each(|axis| self.direction[axis][lanes.clone()].copy_from_slice(&direction[axis]));
            }
        }
        self.load_from(groups.len() * avx2::LANES, unit, rays);
    }

    #[inline(always)]
    fn origin(&self, at: usize) -> [f32; 3] {
        [self.origin[0][at], self.origin[1][at], self.origin[2][at]]
    }

    #[inline(always)]
    fn direction(&self, at: usize) -> [f32; 3] {
        [self.direction[0][at], self.direction[1][at], self.direction[2][at]]
    }

    /// Estimates where rays end; `length` as in [`super::Encoder::encode_all`].
    #[inline(always)]
    pub(super) fn find_ends(&mut self, unit: &UnitSpace, rays: &[Ray], length: impl Fn(usize) -> f32) {
        let (mut lengths, mut t_max) = ([0.0; N], [0.0; N]);
        for (at, ray) in rays.iter().take(N).enumerate() {
            (lengths[at], t_max[at]) = (length(at), ray.t_max);
        }
        for at in 0..N {
            let (origin, direction) = (self.origin(at), self.direction(at));
            let ray = Ray { origin, t_min: 0.0, direction, t_max: t_max[at] };
            let length = termination::bounded_length(unit, &ray, origin, lengths[at]);
            for axis in 0..3 {
                self.end[axis][at] = termination::end_quantised(origin[axis], length, direction[axis]);
            }
        }
    }

    /// Maps directions to the octahedron.
    #[inline(always)]
    pub(super) fn find_octahedral(&mut self) {
        for at in 0..N {
            let [u, v] = octahedral(self.direction(at));
            (self.octahedral[0][at], self.octahedral[1][at]) = (quantise(u), quantise(v));
        }
    }

    /// Asks for the rays' lights; `light` as in [`super::Encoder::encode_all`].
    #[inline(always)]
    pub(super) fn find_lights(&mut self, light: impl Fn(usize) -> u32) {
        self.lights.iter_mut().take(self.count).enumerate().for_each(|(at, found)| *found = light(at));
    }

    /// Finds the tiles of the rays' paths; `path` as in [`super::Encoder::encode_all`].
    #[inline(always)]
    pub(super) fn find_tiles(&mut self, tiles: &Tiles, path: impl Fn(usize) -> u32) {
        let found = self.tiles.iter_mut().take(self.count).enumerate();
        found.for_each(|(at, found)| *found = tiles.number(path(at)));
    }

    /// Maps origins to where their lights see them: all as if their lights had a place, then those again whose
    /// lights have none.
    #[expect(clippy::needless_range_loop, reason = "a lane of several arrays at once")]
    #[inline(always)]
    pub(super) fn find_from_light(&mut self, sites: &[LightSite]) {
        let mut centres = [[0.0; N]; 3];
        let site = |at: usize| &sites[self.lights[at] as usize];
        let mut unplaced = 0;
        for at in 0..self.count {
            match site(at) {
                LightSite::Placed { centre } => (0..3).for_each(|axis| centres[axis][at] = centre[axis]),
                LightSite::Directional { .. } | LightSite::Environment => unplaced += 1,
            }
        }
        for at in 0..N {
            let seen = seen_from([centres[0][at], centres[1][at], centres[2][at]], self.origin(at));
            (0..3).for_each(|axis| self.from_light[axis][at] = quantise(seen[axis]));
        }
        if unplaced > 0 {
            for at in 0..self.count {
                if !matches!(site(at), LightSite::Placed { .. }) {
                    let seen = from_light(site(at), self.origin(at), self.direction(at));
                    (0..3).for_each(|axis| self.from_light[axis][at] = quantise(seen[axis]));
                }
            }
        }
    }

    /// Writes a coordinate of every ray as an integer. Never a part of its caller: compilers would make all
    /// coordinates there, and then choose.
    #[inline(never)]
    pub(super) fn quantise(&self, coordinate: Coordinate, numbers: &mut [u32; N]) {
        self.quantise_here(coordinate, numbers);
    }

    /// The same compiled for AVX2.
    #[cfg(target_arch = "x86_64")]
    #[inline(never)]
    #[target_feature(enable = "avx2")]
    pub(super) fn quantise_avx2(&self, coordinate: Coordinate, numbers: &mut [u32; N]) {
        self.quantise_here(coordinate, numbers);
    }

    #[inline(always)]
    fn quantise_here(&self, coordinate: Coordinate, numbers: &mut [u32; N]) {
        use Coordinate as C;
        match coordinate {
            C::OriginX => self.quantise_origin(0, numbers),
            C::OriginY => self.quantise_origin(1, numbers),
            C::OriginZ => self.quantise_origin(2, numbers),
            C::EndX => *numbers = self.end[0],
            C::EndY => *numbers = self.end[1],
            C::EndZ => *numbers = self.end[2],
            C::DirectionX => self.quantise_direction(0, numbers),
            C::DirectionY => self.quantise_direction(1, numbers),
            C::DirectionZ => self.quantise_direction(2, numbers),
            C::OctahedralU => *numbers = self.octahedral[0],
            C::OctahedralV => *numbers = self.octahedral[1],
            C::ParaboloidU => each(numbers, |at| quantise(paraboloid(self.direction(at))[0])),
            C::ParaboloidV => each(numbers, |at| quantise(paraboloid(self.direction(at))[1])),
            C::Azimuth => {
                each(numbers, |at| quantise(angle::azimuth(self.direction[0][at], self.direction[1][at])));
            }
            C::Polar => each(numbers, |at| quantise(angle::polar(self.direction[2][at]))),
            C::Light => *numbers = self.lights,
            C::LightU => *numbers = self.from_light[0],
            C::LightV => *numbers = self.from_light[1],
            C::LightR => *numbers = self.from_light[2],
            C::Tile => *numbers = self.tiles,
        }
    }

    #[inline(always)]
    fn quantise_origin(&self, axis: usize, numbers: &mut [u32; N]) {
        each(numbers, |at| quantise(self.origin[axis][at]));
    }

    #[inline(always)]
    fn quantise_direction(&self, axis: usize, numbers: &mut [u32; N]) {
        each(numbers, |at| quantise(cartesian(self.direction[axis][at])));
    }
}

#[cfg(target_arch = "x86_64")]
mod avx2 {
    use std::arch::x86_64::*;

    use crate::ray::Ray;
    use crate::unit_space::UnitSpace;

    /// Rays that are taken at once.
    pub(super) const LANES: usize = 8;

    /// Origins of rays in unit space, axis by axis.
    #[inline]
    #[target_feature(enable = "avx2")]
    pub(super) fn origins(unit: &UnitSpace, rays: &[Ray; LANES]) -> [[f32; LANES]; 3] {
        let scale = _mm256_set1_ps(unit.scale);
        let mut axes = columns(rays, 0);
        for (axis, &min) in axes.iter_mut().zip(&unit.min) {
            *axis = _mm256_mul_ps(_mm256_sub_ps(*axis, _mm256_set1_ps(min)), scale);
        }
        bytemuck::cast(axes)
    }

    /// Directions of rays, axis by axis.
    #[inline]
    #[target_feature(enable = "avx2")]
    pub(super) fn directions(rays: &[Ray; LANES]) -> [[f32; LANES]; 3] {
        bytemuck::cast(columns(rays, 1))
    }

    /// The first three numbers of a half of each ray, number by number.
    #[inline]
    #[target_feature(enable = "avx2")]
    fn columns(rays: &[Ray; LANES], half: usize) -> [__m256; 3] {
        let rays: &[[[f32; 4]; 2]; LANES] = bytemuck::cast_ref(rays);
        let row = |at: usize| bytemuck::cast::<[f32; 4], __m128>(rays[at][half]);
        // Of a ray and of the one four after it.
        let pair = |at: usize| _mm256_set_m128(row(at + 4), row(at));
        let [a, b, c, d] = [pair(0), pair(1), pair(2), pair(3)];
        let [low, low_after] = [_mm256_unpacklo_ps(a, b), _mm256_unpacklo_ps(c, d)];
        let [high, high_after] = [_mm256_unpackhi_ps(a, b), _mm256_unpackhi_ps(c, d)];
        const FIRST: i32 = 0b01_00_01_00;
        const SECOND: i32 = 0b11_10_11_10;
        [
            _mm256_shuffle_ps::<FIRST>(low, low_after),
            _mm256_shuffle_ps::<SECOND>(low, low_after),
            _mm256_shuffle_ps::<FIRST>(high, high_after),
        ]
    }
}
