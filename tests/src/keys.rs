//! Keys and ray lengths once more, written from their definition alone and as plainly as can be: what
//! recordings of both backends are compared with.
//!
//! A key is taken apart by the layout's names, coordinate by coordinate. Origins, ends, cartesian
//! directions and light indices must be exact; where the definition leaves the rounding to the device,
//! one quantum is allowed.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::f64::consts::PI;

use formats::key::LightSite;
use formats::ray::{Hit, Kind, Ray};

/// Bits of the finest coordinate.
const FINEST: usize = 22;

/// The names of a method's 64 key bits, most significant first. `lights` matters to those with a light.
///
/// # Panics
/// If the method is not known here.
pub fn layout(method: &str, lights: usize) -> Vec<&'static str> {
    let repeat = |times: usize, words: &'static str| words.split(' ').collect::<Vec<_>>().repeat(times);
    let light_bits = (0..).find(|&bits| 1usize << bits >= lights).unwrap_or(0);
    let mut bits = match method {
        "origin" => [repeat(21, "ox oy oz"), repeat(1, "ox")].concat(),
        "reis" => [repeat(7, "ox oy oz"), repeat(1, "ox"), repeat(21, "azimuth polar")].concat(),
        "costa" => [
            repeat(4, "azimuth polar"),
            repeat(15, "ox oy oz"),
            repeat(5, "azimuth polar"),
            repeat(1, "azimuth"),
        ]
        .concat(),
        "aila" => [repeat(3, "ox oy oz"), repeat(9, "ox oy oz dx dy dz"), repeat(1, "ox")].concat(),
        "octahedron" => [repeat(4, "ox oy oz"), repeat(10, "ox oy oz u v"), repeat(1, "ox oy")].concat(),
        "two-point" | "two-point-adaptive" | "two-point-real" => {
            [repeat(10, "ox oy oz ex ey ez"), repeat(1, "ox oy oz ex")].concat()
        }
        "light-octahedron" => {
            [repeat(light_bits, "light"), repeat(8, "lu lv"), repeat(14, "lu lv lr"), repeat(22, "ox oy oz")]
                .concat()
        }
        "origin-light" => {
            [repeat(3, "ox oy oz"), repeat(light_bits, "light"), repeat(19, "ox oy oz")].concat()
        }
        other => panic!("the method {other} has no layout here"),
    };
    assert!(bits.len() >= 64, "{method} has {} bits", bits.len());
    bits.truncate(64);
    bits
}

/// Unit space of a scene with these bounds.
#[derive(Clone, Copy, Debug)]
pub struct Space {
    min: [f32; 3],
    scale: f32,
    sides: [f32; 3],
}

impl Space {
    /// From the corners of the bounding box, world units.
    pub fn new(min: [f32; 3], max: [f32; 3]) -> Self {
        let largest = (0..3).map(|axis| max[axis] - min[axis]).fold(0.0, f32::max);
        let scale = if largest == 0.0 { 1.0 } else { 1.0 / largest };
        Self { min, scale, sides: std::array::from_fn(|axis| (max[axis] - min[axis]) * scale) }
    }

    fn point(&self, world: [f32; 3]) -> [f32; 3] {
        std::array::from_fn(|axis| (world[axis] - self.min[axis]) * self.scale)
    }

    /// Unit length at which the ray leaves the box for good; 0 if it misses it.
    fn exit(&self, ray: &Ray) -> f32 {
        let origin = self.point(ray.origin);
        let mut slabs = Vec::new();
        for (axis, &start) in origin.iter().enumerate() {
            let is_outside = start < 0.0 || start > self.sides[axis];
            match ray.direction[axis] {
                0.0 if is_outside => return 0.0,
                0.0 => {}
                d => slabs.push([(0.0 - start) / d, (self.sides[axis] - start) / d]),
            }
        }
        let far = slabs.iter().map(|[a, b]| a.max(*b)).fold(f32::INFINITY, f32::min);
        let near = slabs.iter().map(|[a, b]| a.min(*b)).fold(0.0, f32::max);
        if far < near { 0.0 } else { far }
    }

    /// Traced length of a closest ray, unit lengths.
    pub fn closest_length(&self, ray: &Ray, hit: &Hit) -> f32 {
        if hit.triangle == u32::MAX { self.exit(ray) } else { hit.t * self.scale }
    }

    /// Traced length of a shadow ray, unit lengths.
    pub fn shadow_length(&self, ray: &Ray, distance: f32) -> f32 {
        [distance * self.scale, ray.t_max * self.scale].into_iter().fold(self.exit(ray), f32::min)
    }

    fn bounded(&self, ray: &Ray, length: f32) -> f32 {
        [length, ray.t_max * self.scale, self.exit(ray)].into_iter().fold(1.75, f32::min).max(0.0)
    }
}

/// Everything that a ray's keys are made of.
#[derive(Clone, Copy, Debug)]
pub struct Facts<'a> {
    /// The scene's unit space.
    pub space: &'a Space,
    /// The ray.
    pub ray: &'a Ray,
    /// Unit length that the method takes the ray to have; what the others make of it does not matter.
    pub length: f32,
    /// Index and place of a shadow ray's light.
    pub light: Option<(u32, LightSite)>,
}

/// `v` in [0, 1] as one of 2^22 equal cells.
fn cell(v: f32) -> i64 {
    if v > 0.0 { ((f64::from(v) * f64::from(1u32 << FINEST)) as i64).min((1 << FINEST) - 1) } else { 0 }
}

fn cell_of_f64(v: f64) -> i64 {
    ((v * f64::from(1u32 << FINEST)).floor() as i64).clamp(0, (1 << FINEST) - 1)
}

fn octahedral([x, y, z]: [f64; 3]) -> [f64; 2] {
    let sum = x.abs() + y.abs() + z.abs();
    if sum == 0.0 {
        return [0.5, 0.5];
    }
    let (px, py) = (x / sum, y / sum);
    let sign = |v: f64| if v > 0.0 { 1.0 } else { -1.0 };
    let (px, py) = if z < 0.0 { ((1.0 - py.abs()) * sign(x), (1.0 - px.abs()) * sign(y)) } else { (px, py) };
    [(px + 1.0) / 2.0, (py + 1.0) / 2.0]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

impl Facts<'_> {
    /// The light's two directions and distance, each in [0, 1].
    fn seen_from_light(&self) -> [f64; 3] {
        let origin = self.space.point(self.ray.origin).map(f64::from);
        let (_, site) = self.light.expect("only shadow rays have keys with a light");
        let root = 3f64.sqrt();
        match site {
            LightSite::Placed { centre } => {
                let from: [f64; 3] = std::array::from_fn(|axis| origin[axis] - f64::from(centre[axis]));
                let [u, v] = octahedral(from);
                [u, v, dot(from, from).sqrt() / root]
            }
            LightSite::Directional { direction, tangent, bitangent } => [tangent, bitangent, direction]
                .map(|axis| (dot(origin, axis.map(f64::from)) / root + 1.0) / 2.0),
            LightSite::Environment => {
                let [u, v] = octahedral(self.ray.direction.map(f64::from));
                [u, v, 0.0]
            }
        }
    }

    /// A coordinate as one of 2^22 cells.
    fn coordinate(&self, name: &str) -> i64 {
        let direction = self.ray.direction;
        let axis = match name.as_bytes().last() {
            Some(b'x') => 0,
            Some(b'y') => 1,
            _ => 2,
        };
        let [x, y, z] = direction.map(f64::from);
        match name {
            "ox" | "oy" | "oz" => cell(self.space.point(self.ray.origin)[axis]),
            "dx" | "dy" | "dz" => cell((direction[axis] + 1.0) / 2.0),
            "ex" | "ey" | "ez" => {
                let fixed = |v: f32| (v * 32_768.0) as i64;
                let length = self.space.bounded(self.ray, self.length);
                let step = (fixed(length) * fixed(direction[axis])) >> 8;
                (cell(self.space.point(self.ray.origin)[axis]) + step).clamp(0, (1 << FINEST) - 1)
            }
            "azimuth" => cell_of_f64(if x == 0.0 && y == 0.0 { 0.5 } else { y.atan2(x) / (2.0 * PI) + 0.5 }),
            "polar" => cell_of_f64(z.clamp(-1.0, 1.0).acos() / PI),
            "u" => cell_of_f64(octahedral([x, y, z])[0]),
            "v" => cell_of_f64(octahedral([x, y, z])[1]),
            "lu" => cell_of_f64(self.seen_from_light()[0]),
            "lv" => cell_of_f64(self.seen_from_light()[1]),
            "lr" => cell_of_f64(self.seen_from_light()[2]),
            other => panic!("there is no coordinate {other}"),
        }
    }

    /// The part of a coordinate that the first of `bits` hold, as a number of `count` bits.
    fn expected(&self, name: &str, count: usize, light_bits: usize) -> i64 {
        if name == "light" {
            let (index, _) = self.light.expect("only shadow rays have keys with a light");
            return i64::from(index) >> (light_bits - count);
        }
        self.coordinate(name) >> (FINEST - count)
    }

    /// Compares a key of `key_bits` bits with what it must be.
    ///
    /// # Errors
    /// A sentence that names the first coordinate that is wrong.
    pub fn check(&self, bits: &[&str], key_bits: usize, key: u64) -> Result<(), String> {
        if key_bits < 64 && key >> key_bits != 0 {
            return Err(format!("the key {key:#x} has more than {key_bits} bits"));
        }
        let light_bits = bits.iter().filter(|name| **name == "light").count();
        let used = &bits[..key_bits];
        let mut names = used.to_vec();
        names.sort_unstable();
        names.dedup();
        for name in names {
            let mut found = 0;
            let mut count = 0;
            for (place, _) in used.iter().enumerate().filter(|(_, other)| **other == name) {
                found = found << 1 | (key >> (key_bits - 1 - place) & 1) as i64;
                count += 1;
            }
            let expected = self.expected(name, count, light_bits);
            let apart = (found - expected).abs();
            // The azimuth is a circle: its first and last cell are neighbours.
            let apart = if name == "azimuth" { apart.min((1 << count) - apart) } else { apart };
            let allowed = i64::from(matches!(name, "azimuth" | "polar" | "u" | "v" | "lu" | "lv" | "lr"));
            if apart > allowed {
                return Err(format!(
                    "{name} is {found} of {count} bits in the key {key:#x}, expected {expected}: {self:?}"
                ));
            }
        }
        Ok(())
    }

    /// The address of the ray in a length table of 2^`table_bits` cells that `aila` addresses.
    pub fn table_cell(&self, table_bits: usize) -> u32 {
        let mut taken = std::collections::HashMap::new();
        layout("aila", 0)[..table_bits].iter().fold(0, |address, name| {
            let depth = taken.entry(*name).or_insert(0usize);
            *depth += 1;
            address << 1 | (self.coordinate(name) >> (FINEST - *depth) & 1) as u32
        })
    }
}

/// The mean length that a cell's sum and count stand for, unit lengths.
pub fn mean_length(sum: u64, count: u32) -> f32 {
    ((sum / u64::from(count)) >> 1) as f32 / 8_388_608.0
}

/// What a traced length adds to a cell's sum.
pub fn summed(length: f32) -> u64 {
    (f64::from(length.min(2.0)) * 16_777_216.0) as u64
}

/// Whether a method has keys for rays of this kind.
pub fn applies(method: &str, kind: Kind) -> bool {
    kind == Kind::Shadow || !["light-octahedron", "origin-light"].contains(&method)
}
