//! The truth: every triangle tested against every ray in f64, slow and exact.

use formats::ray::Ray;
use scenes::Scene;

/// Traces rays through a scene without a hierarchy.
#[derive(Clone, Debug)]
pub struct Oracle {
    corners: Vec<[[f64; 3]; 3]>,
}

/// A hit in double precision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExactHit {
    /// Distance in units of the direction's length.
    pub t: f64,
    /// Index of the triangle.
    pub triangle: u32,
    /// Barycentric weight of the second corner.
    pub u: f64,
    /// Barycentric weight of the third corner.
    pub v: f64,
    /// Smallest of the three barycentric weights: how far inside the triangle the hit is.
    pub inside: f64,
}

impl Oracle {
    /// Copies the scene's triangles. Alpha masks are not looked at.
    pub fn new(scene: &Scene) -> Self {
        let corners = (0..scene.triangles.len())
            .map(|triangle| scene.corners(triangle).map(|corner| corner.map(f64::from)));
        Self { corners: corners.collect() }
    }

    /// Every hit of a ray between its `t_min` and `t_max`, in the order of the triangles.
    pub fn hits(&self, ray: &Ray) -> impl Iterator<Item = ExactHit> {
        let (t_min, t_max) = (f64::from(ray.t_min), f64::from(ray.t_max));
        let (origin, direction) = (ray.origin.map(f64::from), ray.direction.map(f64::from));
        self.corners.iter().enumerate().filter_map(move |(triangle, corners)| {
            let hit = intersect(origin, direction, corners, triangle as u32)?;
            (t_min <= hit.t && hit.t <= t_max && hit.inside >= 0.0).then_some(hit)
        })
    }

    /// The nearest hit; of equal distances the one with the lowest triangle index.
    pub fn closest(&self, ray: &Ray) -> Option<ExactHit> {
        self.hits(ray).reduce(|best, hit| if hit.t < best.t { hit } else { best })
    }

    /// Whether the ray hits anything.
    pub fn is_occluded(&self, ray: &Ray) -> bool {
        self.hits(ray).next().is_some()
    }
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Where a line meets a triangle's plane (Möller and Trumbore 1997); `None` if it never does.
fn intersect(
    origin: [f64; 3],
    direction: [f64; 3],
    [a, b, c]: &[[f64; 3]; 3],
    triangle: u32,
) -> Option<ExactHit> {
    let (ab, ac) = (minus(*b, *a), minus(*c, *a));
    let across = cross(direction, ac);
    let determinant = dot(ab, across);
    if determinant == 0.0 {
        return None;
    }
    let from_a = minus(origin, *a);
    let along = cross(from_a, ab);
    let u = dot(from_a, across) / determinant;
    let v = dot(direction, along) / determinant;
    let t = dot(ac, along) / determinant;
    Some(ExactHit { t, triangle, u, v, inside: u.min(v).min(1.0 - u - v) })
}
