//! A few rays coordinate by coordinate: what their keys are made from, in loops without branches, which processors
//! with vectors run several rays at a time.

use super::coordinates::{cartesian, from_light, octahedral, paraboloid, quantise, seen_from};
use super::{Coordinate, LightSite, Tiles, angle, termination};
use crate::ray::Ray;
use crate::unit_space::UnitSpace;

/// Up to `N` rays; what lies in lanes without a ray is of no account.
pub(super) struct Block<const N: usize> {
    count: usize,
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

/// A value for each lane. Part of its caller, so that it is compiled for the same processor.
#[inline(always)]
fn lanes<T: Copy + Default, const N: usize>(value: impl Fn(usize) -> T) -> [T; N] {
    let mut lanes = [T::default(); N];
    lanes.iter_mut().enumerate().for_each(|(at, lane)| *lane = value(at));
    lanes
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
        for (at, ray) in rays.iter().take(N).enumerate() {
            let origin = unit.point(ray.origin);
            (0..3).for_each(|axis| self.origin[axis][at] = origin[axis]);
        }
    }

    /// Takes their directions, too.
    #[inline(always)]
    pub(super) fn load_directions(&mut self, rays: &[Ray]) {
        for (at, ray) in rays.iter().take(N).enumerate() {
            (0..3).for_each(|axis| self.direction[axis][at] = ray.direction[axis]);
        }
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

    /// A coordinate of every ray as an integer.
    #[inline(always)]
    pub(super) fn quantised(&self, coordinate: Coordinate) -> [u32; N] {
        use Coordinate as C;
        match coordinate {
            C::OriginX => self.quantised_origin(0),
            C::OriginY => self.quantised_origin(1),
            C::OriginZ => self.quantised_origin(2),
            C::EndX => self.end[0],
            C::EndY => self.end[1],
            C::EndZ => self.end[2],
            C::DirectionX => self.quantised_direction(0),
            C::DirectionY => self.quantised_direction(1),
            C::DirectionZ => self.quantised_direction(2),
            C::OctahedralU => self.octahedral[0],
            C::OctahedralV => self.octahedral[1],
            C::ParaboloidU => lanes(|at| quantise(paraboloid(self.direction(at))[0])),
            C::ParaboloidV => lanes(|at| quantise(paraboloid(self.direction(at))[1])),
            C::Azimuth => lanes(|at| quantise(angle::azimuth(self.direction[0][at], self.direction[1][at]))),
            C::Polar => lanes(|at| quantise(angle::polar(self.direction[2][at]))),
            C::Light => self.lights,
            C::LightU => self.from_light[0],
            C::LightV => self.from_light[1],
            C::LightR => self.from_light[2],
            C::Tile => self.tiles,
        }
    }

    #[inline(always)]
    fn quantised_origin(&self, axis: usize) -> [u32; N] {
        lanes(|at| quantise(self.origin[axis][at]))
    }

    #[inline(always)]
    fn quantised_direction(&self, axis: usize) -> [u32; N] {
        lanes(|at| quantise(cartesian(self.direction[axis][at])))
    }
}
