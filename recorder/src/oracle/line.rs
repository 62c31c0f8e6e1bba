//! Where a line crosses a triangle.

use formats::ray::Ray;
use num_bigint::{BigInt, Sign};

use super::exact;

/// A ray in double precision.
#[derive(Clone, Copy, Debug)]
pub struct Line {
    /// Where it starts.
    pub origin: [f64; 3],
    /// Where it leads, of any length.
    pub direction: [f64; 3],
    /// The nearest distance that counts, in units of the direction's length.
    pub t_min: f64,
    /// The farthest one.
    pub t_max: f64,
}

/// A point where a line crosses a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Crossing {
    /// Distance in units of the direction's length.
    pub(super) t: f64,
    /// Bound of its error.
    pub(super) error: f64,
    /// Barycentric weights of the three corners, none negative.
    pub(super) weights: [f64; 3],
}

/// Rounding of one operation on f64.
const UNIT: f64 = f64::EPSILON / 2.0;
/// Bound of the relative error of an edge function, of the sum of the sizes of its terms: differences, two
/// products and two sums of each term round, seven times in all.
const EDGE_ERROR: f64 = 8.0 * UNIT;
/// Largest bound of a distance's error that is left as it is, in parts of the distance to the farthest corner.
const GOOD_ENOUGH: f64 = 1.0 / (1u64 << 32) as f64;

impl Line {
    pub(super) fn new(ray: &Ray) -> Self {
        Self {
            origin: ray.origin.map(f64::from),
            direction: ray.direction.map(f64::from),
            t_min: f64::from(ray.t_min),
            t_max: f64::from(ray.t_max),
        }
    }

    /// Whether it leads anywhere.
    pub(super) fn is_valid(&self) -> bool {
        let is_finite = self.origin.iter().chain(&self.direction).all(|x| x.is_finite());
        is_finite && self.direction != [0.0; 3]
    }

    /// Whether a distance lies between the line's ends, both included.
    pub(super) fn includes(&self, t: f64) -> bool {
        self.t_min <= t && t <= self.t_max
    }

    /// Length of the direction.
    pub fn speed(&self) -> f64 {
        dot(self.direction, self.direction).sqrt()
    }

    /// Where it crosses a triangle, edges and corners included, at any distance. A line that runs along the
    /// triangle's plane does not.
    ///
    /// A line passes a triangle's edges on the same side exactly if it crosses the triangle: three signs of
    /// `direction · (p × q)` with p and q the ends of an edge as seen from the origin.
    pub(super) fn cross(&self, corners: &[[f32; 3]; 3]) -> Option<Crossing> {
        if !self.is_valid() {
            return None;
        }
        let corners = corners.map(|corner| corner.map(f64::from));
        let from_origin = corners.map(|corner| minus(corner, self.origin));
        let [p, q, r] = from_origin;
        let edges = [(q, r), (r, p), (p, q)].map(|(p, q)| self.edge(p, q));
        let is_certain = |sign: f64| edges.iter().any(|(value, error)| value * sign > *error);
        if is_certain(1.0) && is_certain(-1.0) {
            return None;
        }
        let rounding: f64 = edges.iter().map(|(_, error)| error).sum();
        let weights = edges.map(|(value, _)| value);
        let sum: f64 = weights.iter().sum();
        let are_signs_certain = edges.iter().all(|(value, error)| value.abs() > *error);
        // Infinite where the sum is zero, not a number where everything is.
        let relative = 2.0 * rounding / sum.abs() + 16.0 * UNIT;
        if !(are_signs_certain && relative <= GOOD_ENOUGH) {
            return self.cross_exactly(corners);
        }
        let speed = self.speed();
        let reach = from_origin.iter().map(|corner| dot(*corner, *corner).sqrt()).fold(0.0, f64::max);
        let weights = weights.map(|weight| weight / sum);
        let depths = from_origin.map(|corner| dot(corner, self.direction) / speed);
        Some(Crossing { t: dot(weights, depths) / speed, error: relative * reach / speed, weights })
    }

    /// The edge function of the edge from p to q, both as seen from the origin, and a bound of its error.
    fn edge(&self, p: [f64; 3], q: [f64; 3]) -> (f64, f64) {
        let sizes = |v: [f64; 3]| v.map(f64::abs);
        let (a, b, d) = (sizes(p), sizes(q), sizes(self.direction));
        let size = d[0] * (a[1] * b[2] + a[2] * b[1])
            + d[1] * (a[2] * b[0] + a[0] * b[2])
            + d[2] * (a[0] * b[1] + a[1] * b[0]);
        (dot(self.direction, cross(p, q)), EDGE_ERROR * size)
    }

    /// [`Line::cross`] in whole numbers.
    fn cross_exactly(&self, [p, q, r]: [[f64; 3]; 3]) -> Option<Crossing> {
        let ([p, q, r, origin], unit) = exact::whole([p, q, r, self.origin]);
        let ([direction], direction_unit) = exact::whole([self.direction]);
        let from_origin = [p, q, r].map(|corner| exact::minus(&corner, &origin));
        let [p, q, r] = &from_origin;
        let edges = [(q, r), (r, p), (p, q)].map(|(p, q)| exact::dot(&direction, &exact::cross(p, q)));
        let has = |sign: Sign| edges.iter().any(|edge| edge.sign() == sign);
        if has(Sign::Plus) == has(Sign::Minus) {
            return None; // On both sides, or on neither since the line runs along the plane.
        }
        let sum: BigInt = edges.iter().sum();
        // t is the sum of weights times depths, over the direction's squared length.
        let depths: BigInt = edges.iter().zip(&from_origin).map(|(e, p)| e * exact::dot(p, &direction)).sum();
        let squared = &sum * exact::dot(&direction, &direction);
        let t = exact::quotient(&depths, &squared, unit - direction_unit);
        let weights = edges.map(|edge| exact::quotient(&edge, &sum, 0));
        Some(Crossing { t, error: t.abs() * 8.0 * UNIT, weights })
    }
}

/// The difference of two vectors.
pub fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// Cross product.
pub fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Dot product.
pub fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
