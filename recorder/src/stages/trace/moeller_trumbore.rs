//! The triangle test of Möller and Trumbore 1997, "Fast, Minimum Storage Ray/Triangle Intersection".
//!
//! Without culling and without an epsilon: what rounding does to it is what is to be measured. Both
//! triangles at an edge round on their own, so rays pass between them.

use formats::intersect::Intersection;
use formats::ray::Ray;
use glam::Vec3;

use super::triangle::{LeafTriangle, TriangleBlock, TriangleRay};
use crate::stages::vector::{cross3, dot3};

/// A ray as it is.
#[derive(Clone, Copy, Debug)]
pub struct PlainRay {
    origin: Vec3,
    direction: Vec3,
}

impl TriangleRay for PlainRay {
    #[inline(always)]
    fn new(ray: &Ray, _inverse: [f32; 3]) -> Self {
        Self { origin: Vec3::from(ray.origin), direction: Vec3::from(ray.direction) }
    }

    #[inline(always)]
    fn intersect(&self, leaf: &LeafTriangle) -> Option<Intersection> {
        let [a, b, c] = leaf.corners();
        let (ab, ac) = (b - a, c - a);
        let across = cross3(self.direction, ac);
        let determinant = dot3(ab, across);
        if determinant == 0.0 {
            return None;
        }
        let inverse = 1.0 / determinant;
        let from_a = self.origin - a;
        let u = dot3(from_a, across) * inverse;
        let along = cross3(from_a, ab);
        let v = dot3(self.direction, along) * inverse;
        let is_inside = u >= 0.0 && v >= 0.0 && u + v <= 1.0;
        is_inside.then(|| Intersection { t: dot3(ac, along) * inverse, u, v })
    }

    #[inline(always)]
    fn confirm<const WEIGHTS: bool>(
        &self,
        leaf: &LeafTriangle,
        counts: impl FnOnce(f32) -> bool,
    ) -> Option<Intersection> {
        self.intersect(leaf).filter(|at| counts(at.t))
    }

    #[inline(always)]
    fn candidates(&self, block: &TriangleBlock, _farthest: f32) -> u32 {
        (1 << block.count()) - 1
    }
}
