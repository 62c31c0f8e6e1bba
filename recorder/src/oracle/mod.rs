//! The truth about rays and triangles: slow, in double precision, and exact where that does not decide.
//!
//! Which triangles a line meets is decided by the signs of edge functions. They are evaluated in f64
//! with a bound of their rounding, and in whole numbers where the bound does not tell the sign
//! ([`line`](mod@line), [`exact`]); boxes are tested conservatively ([`tree`]). So a hit of the oracle is a hit,
//! edges and corners included, at any scale of the scene and any shape of the triangle. Nothing here is
//! shared with the tracers but the alpha masks, whose texels are looked up alike.
//!
//! [`judge`](mod@judge) holds a tracer's answer against it.

mod exact;
mod judge;
pub mod line;
mod projected;
#[cfg(test)]
mod tests;
mod tree;

pub use judge::{Deviation, Judgement, Verdict};
pub use projected::REACH;

use formats::ray::Ray;
use scenes::Scene;

use crate::stages::trace::mask::Masks;
use line::{Crossing, Line};
use tree::Tree;

/// Traces rays through the triangles of a scene, exactly.
#[derive(Clone, Debug)]
pub struct Oracle {
    corners: Vec<[[f32; 3]; 3]>,
    masks: Masks,
    tree: Tree,
}

/// A hit in double precision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExactHit {
    /// Distance in units of the direction's length.
    pub t: f64,
    /// Bound of the error of `t`, at most 2^-32 of the distance to the triangle's farthest corner.
    pub error: f64,
    /// Index of the triangle.
    pub triangle: u32,
    /// Barycentric weight of the second corner.
    pub u: f64,
    /// Barycentric weight of the third corner.
    pub v: f64,
}

impl ExactHit {
    /// Whether this is the hit that counts of the two: the nearer one, or of equal distances that with the
    /// lower triangle index.
    fn is_before(&self, other: &Self) -> bool {
        let apart = other.t - self.t;
        let is_equal = apart.abs() <= self.error + other.error;
        if is_equal { self.triangle < other.triangle } else { apart > 0.0 }
    }
}

impl Oracle {
    /// Copies the scene's triangles and builds a hierarchy over them. Takes seconds per million triangles.
    pub fn new(scene: &Scene) -> Self {
        let corners: Vec<_> = (0..scene.triangles.len()).map(|triangle| scene.corners(triangle)).collect();
        Self { masks: Masks::new(scene), tree: Tree::new(&corners), corners }
    }

    /// The nearest hit between the ray's `t_min` and `t_max`, both included; of equal distances the one with the
    /// lowest triangle index.
    ///
    /// A triangle that the ray runs along is not hit. Nothing is hit by a ray with a direction of zero or one
    /// that is not finite.
    pub fn closest(&self, ray: &Ray) -> Option<ExactHit> {
        self.closest_on(&Line::new(ray))
    }

    /// As [`Oracle::closest`], of a line in double precision.
    pub fn closest_on(&self, line: &Line) -> Option<ExactHit> {
        let mut best: Option<ExactHit> = None;
        self.tree.walk(line, |triangle| {
            if let Some(hit) = self.hit(line, triangle)
                && line.includes(hit.t)
                && best.is_none_or(|best| hit.is_before(&best))
            {
                best = Some(hit);
            }
            best.map_or(line.t_max, |best| best.t + best.error)
        });
        best
    }

    /// Where a line hits a triangle, for any distance, if that is no hole.
    fn hit(&self, line: &Line, triangle: u32) -> Option<ExactHit> {
        let Crossing { t, error, weights: [_, u, v] } = line.cross(&self.corners[triangle as usize])?;
        let number = self.masks.number(triangle);
        let is_hole = number != 0 && self.masks.is_hole(number, u as f32, v as f32);
        (!is_hole).then_some(ExactHit { t, error, triangle, u, v })
    }
}
