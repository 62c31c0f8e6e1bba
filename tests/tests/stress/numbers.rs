//! Numbers from fixed seeds, and rays made of them.

use formats::ray::Ray;
use recorder::stages::random::Random;

use crate::shapes::Triangle;

/// A stream of numbers; equal seeds give equal numbers.
pub(crate) struct Numbers(Random);

impl Numbers {
    pub(crate) fn new(seed: u32) -> Self {
        Self(Random::new([seed, 0x5eed], 0, 0, 0))
    }

    /// From 0 to below 1.
    pub(crate) fn unit(&mut self) -> f32 {
        self.0.draw()
    }

    pub(crate) fn below(&mut self, limit: usize) -> usize {
        ((self.unit() * limit as f32) as usize).min(limit - 1)
    }

    /// In the unit cube.
    pub(crate) fn point(&mut self) -> [f32; 3] {
        [0; 3].map(|_| self.unit())
    }

    /// A unit vector.
    pub(crate) fn direction(&mut self) -> [f32; 3] {
        loop {
            let v = self.point().map(|x| 2.0 * x - 1.0);
            let squared: f32 = v.iter().map(|x| x * x).sum();
            if (0.01..1.0).contains(&squared) {
                return v.map(|x| x / squared.sqrt());
            }
        }
    }

    /// A corner of some triangle.
    pub(crate) fn corner(&mut self, triangles: &[Triangle]) -> [f32; 3] {
        triangles[self.below(triangles.len())][self.below(3)]
    }

    /// A point on an edge of some triangle, as near as single precision gets.
    pub(crate) fn edge_point(&mut self, triangles: &[Triangle]) -> [f32; 3] {
        let triangle = triangles[self.below(triangles.len())];
        let first = self.below(3);
        let (a, b, place) = (triangle[first], triangle[(first + 1) % 3], self.unit());
        [0, 1, 2].map(|axis| a[axis] + place * (b[axis] - a[axis]))
    }

    /// A point on some triangle, as near as single precision gets.
    pub(crate) fn surface_point(&mut self, triangles: &[Triangle]) -> [f32; 3] {
        let [a, b, c] = triangles[self.below(triangles.len())];
        let (root, part) = (self.unit().sqrt(), self.unit());
        let (u, v) = (root * (1.0 - part), root * part);
        [0, 1, 2].map(|axis| a[axis] + u * (b[axis] - a[axis]) + v * (c[axis] - a[axis]))
    }
}

/// A ray without ends.
pub(crate) fn ray(origin: [f32; 3], direction: [f32; 3]) -> Ray {
    Ray { origin, t_min: 0.0, direction, t_max: f32::INFINITY }
}

/// A ray with a unit direction from one point towards another; `None` if they are the same.
pub(crate) fn towards(origin: [f32; 3], target: [f32; 3]) -> Option<Ray> {
    let to = [0, 1, 2].map(|axis| f64::from(target[axis]) - f64::from(origin[axis]));
    let length = to.iter().map(|x| x * x).sum::<f64>().sqrt();
    (length > 0.0).then(|| ray(origin, to.map(|x| (x / length) as f32)))
}

/// Rays from places about a point, in turn anywhere, at a corner and at an edge.
pub(crate) fn rays_from_inside(
    numbers: &mut Numbers,
    triangles: &[Triangle],
    centre: [f32; 3],
    radius: f32,
    count: usize,
) -> Vec<Ray> {
    let mut rays = Vec::with_capacity(count);
    while rays.len() < count {
        let (offset, part) = (numbers.direction(), numbers.unit() * radius);
        let origin = [0, 1, 2].map(|axis| centre[axis] + part * offset[axis]);
        rays.extend(match rays.len() % 3 {
            0 => Some(ray(origin, numbers.direction())),
            1 => towards(origin, numbers.corner(triangles)),
            _ => towards(origin, numbers.edge_point(triangles)),
        });
    }
    rays
}

/// Rays from places in and around the unit cube in all directions.
pub(crate) fn rays_around(numbers: &mut Numbers, count: usize) -> Vec<Ray> {
    (0..count).map(|_| ray(numbers.point().map(|x| 3.0 * x - 1.0), numbers.direction())).collect()
}
