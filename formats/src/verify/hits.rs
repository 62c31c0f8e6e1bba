//! Hits and distances against their rays and triangles.
//!
//! Whether a nearer triangle was missed cannot be seen without tracing; that the point named by a
//! hit lies on its ray, and within the ray's limits, can.

use glam::{DVec3, Vec3};

use super::{Check, Subject};
use crate::holes::Holes;
use crate::manifest::{Place, SceneArray};
use crate::ray::{Hit, Ray};
use crate::reader::Loaded;
use crate::traced::Results;

/// How many roundings of single precision a point may be off, for a well-shaped triangle.
const ROUNDINGS: f64 = 32.0;
/// How far barycentric weights may leave 0 to 1 by rounding.
const WEIGHT_TOLERANCE: f64 = 1e-5;

pub(super) fn check(subject: &Subject<'_>) -> [Check; 2] {
    let mut hits_check = Check::new("hits");
    let mut distances_check = Check::new("distances");
    let scene = Geometry::of(subject);
    if scene.is_none() {
        let absence = subject.geometry_absence();
        hits_check.not_checked.push(format!("points on triangles: the scene was {absence}"));
    }
    for &queue in subject.queues.keys() {
        let Some(traced) = subject.traced(queue) else { continue };
        let rays = traced.rays();
        match traced.results() {
            Results::Hits(hits) => {
                let fault = |index: usize| fault(&rays[index], &hits[index], scene.as_ref());
                hits_check.each(
                    hits.len(),
                    |index| fault(index).is_none(),
                    |index| {
                        let fault = fault(index).map_or(String::new(), |fault| fault.to_string());
                        format!("{queue}/hits.npy: ray {index} {fault}: {:?}", hits[index])
                    },
                );
            }
            Results::Distances(distances) => {
                let is_right = |index: usize| {
                    let (ray, distance) = (&rays[index], distances[index]);
                    distance == f32::INFINITY || (distance >= ray.t_min && distance <= ray.t_max)
                };
                distances_check.each(distances.len(), is_right, |index| {
                    let Ray { t_min, t_max, .. } = rays[index];
                    format!(
                        "{queue}/distances.npy: ray {index} is stopped at {}, expected {t_min} to {t_max}, or inf",
                        distances[index]
                    )
                });
            }
        }
    }
    [hits_check, distances_check]
}

/// The scene's triangles and their holes.
struct Geometry {
    holes: Option<Holes>,
    positions: Loaded<[f32; 3]>,
    triangles: Loaded<[u32; 3]>,
}

impl Geometry {
    fn of(subject: &Subject<'_>) -> Option<Self> {
        let holes = Holes::open(subject.dump).unwrap_or_else(|error| {
            subject.note_error(&Place::Scene(SceneArray::Masks), &error);
            None
        });
        Some(Self {
            holes,
            positions: subject.array(&Place::Scene(SceneArray::Positions))?,
            triangles: subject.array(&Place::Scene(SceneArray::Triangles))?,
        })
    }

    /// Whether an existing triangle has a hole where it is hit.
    fn is_hole(&self, hit: &Hit) -> bool {
        let corners = self.triangles[hit.triangle as usize];
        self.holes.as_ref().is_some_and(|holes| holes.is_surely_hole(hit.triangle, corners, [hit.u, hit.v]))
    }

    /// The corners of a triangle; `None` if there is no such triangle or vertex.
    fn corners(&self, triangle: u32) -> Option<[DVec3; 3]> {
        let indices = self.triangles.get(triangle as usize)?;
        let corner =
            |index: u32| self.positions.get(index as usize).map(|&point| Vec3::from(point).as_dvec3());
        Some([corner(indices[0])?, corner(indices[1])?, corner(indices[2])?])
    }
}

/// What is wrong with a hit; lengths in world units.
#[derive(Debug, PartialEq, thiserror::Error)]
enum Fault {
    #[error("misses, but not with t = inf and u = v = 0")]
    Miss,
    #[error("hits a triangle that does not exist")]
    Triangle,
    #[error("is hit outside its t_min and t_max")]
    Distance,
    #[error("has barycentric weights outside 0 to 1")]
    Weights,
    #[error("is hit where its material's mask has a hole")]
    Hole,
    #[error("is hit {apart:e} away from the triangle's point, expected at most {tolerance:e}")]
    Point { apart: f64, tolerance: f64 },
}

fn fault(ray: &Ray, hit: &Hit, scene: Option<&Geometry>) -> Option<Fault> {
    if !hit.is_hit() {
        return (*hit != Hit::MISS).then_some(Fault::Miss);
    }
    if !(hit.t >= ray.t_min && hit.t <= ray.t_max && hit.t.is_finite()) {
        return Some(Fault::Distance);
    }
    let (u, v) = (f64::from(hit.u), f64::from(hit.v));
    let in_triangle = [u, v, 1.0 - u - v].iter().all(|&weight| weight >= -WEIGHT_TOLERANCE);
    if !in_triangle {
        return Some(Fault::Weights);
    }
    let scene = scene?;
    let Some(corners) = scene.corners(hit.triangle) else { return Some(Fault::Triangle) };
    let (apart, tolerance) = distance_and_tolerance(ray, hit, corners);
    let is_close = apart <= tolerance;
    if !is_close {
        return Some(Fault::Point { apart, tolerance });
    }
    scene.is_hole(hit).then_some(Fault::Hole)
}

/// How far the triangle's point is from the ray's, and how far it may be, in world units.
///
/// Rounding moves the weights by its size over the triangle's projected area, so the point, which
/// stays in the triangle, may move along slivers and triangles seen edge-on: the tolerance grows
/// with (longest edge)² / projected area, up to the longest edge.
fn distance_and_tolerance(ray: &Ray, hit: &Hit, [a, b, c]: [DVec3; 3]) -> (f64, f64) {
    let (origin, direction) = (Vec3::from(ray.origin).as_dvec3(), Vec3::from(ray.direction).as_dvec3());
    let (t, u, v) = (f64::from(hit.t), f64::from(hit.u), f64::from(hit.v));
    let (to_b, to_c) = (b - a, c - a);
    let apart = a + u * to_b + v * to_c - (origin + t * direction);
    let longest = to_b.length().max(to_c.length()).max((c - b).length());
    let largest =
        |point: DVec3| point.to_array().iter().fold(0.0f64, |largest, along| largest.max(along.abs()));
    let scale = [origin, a, b, c].into_iter().map(largest).fold(t.max(longest), f64::max);
    let rounding = ROUNDINGS * f64::from(f32::EPSILON) * scale;
    let projected_area = to_b.cross(to_c).dot(direction).abs();
    let slant = longest * longest / projected_area.max(f64::MIN_POSITIVE);
    (apart.length(), rounding + (rounding * slant).min(longest))
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: [DVec3; 3] =
        [DVec3::new(0.0, 0.0, 5.0), DVec3::new(4.0, 0.0, 5.0), DVec3::new(0.0, 4.0, 5.0)];

    fn ray() -> Ray {
        Ray { origin: [1.0, 1.0, 0.0], t_min: 0.0, direction: [0.0, 0.0, 1.0], t_max: f32::INFINITY }
    }

    fn hit() -> Hit {
        Hit { t: 5.0, triangle: 0, u: 0.25, v: 0.25 }
    }

    #[test]
    fn points_are_compared_within_rounding() {
        let (apart, tolerance) = distance_and_tolerance(&ray(), &hit(), CORNERS);
        assert!(apart == 0.0 && tolerance < 2e-4, "{apart} {tolerance}");
        for wrong in [Hit { t: 5.01, ..hit() }, Hit { u: 0.26, ..hit() }, Hit { v: 0.0, ..hit() }] {
            let (apart, tolerance) = distance_and_tolerance(&ray(), &wrong, CORNERS);
            assert!(apart > tolerance, "{wrong:?}: {apart} {tolerance}");
        }
    }

    #[test]
    fn limits_weights_and_misses_are_held() {
        assert_eq!(fault(&ray(), &hit(), None), None);
        assert_eq!(fault(&ray(), &Hit::MISS, None), None);
        for (wrong, expected) in [
            (Hit { t: 5.0, ..Hit::MISS }, Fault::Miss),
            (Hit { u: 0.5, ..Hit::MISS }, Fault::Miss),
            (Hit { t: f32::INFINITY, ..hit() }, Fault::Distance),
            (Hit { t: f32::NAN, ..hit() }, Fault::Distance),
            (Hit { t: -1.0, ..hit() }, Fault::Distance),
            (Hit { u: 0.8, v: 0.3, ..hit() }, Fault::Weights),
            (Hit { u: f32::NAN, ..hit() }, Fault::Weights),
        ] {
            assert_eq!(fault(&ray(), &wrong, None), Some(expected), "{wrong:?}");
        }
        let short = Ray { t_max: 4.0, ..ray() };
        assert_eq!(fault(&short, &hit(), None), Some(Fault::Distance));
    }
}
