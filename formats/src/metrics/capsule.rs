//! Capsules: the convex hull of two spheres, one around a group's origins, one around its ends.

use std::f64::consts::PI;

use crate::ray::Ray;
use crate::unit_space::UnitSpace;

/// A point in unit space.
pub type Point = [f64; 3];

/// A ray from its origin to where it ended, unit space.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Segment {
    /// Where the ray starts.
    pub origin: Point,
    /// Where it was found to end.
    pub end: Point,
}

impl Segment {
    /// Of a ray in world space with its traced `length` in unit lengths. A length that is not finite,
    /// as that of a ray without a direction, counts as 0.
    #[inline]
    pub fn of(unit: &UnitSpace, ray: &Ray, length: f32) -> Self {
        let length = if length.is_finite() { f64::from(length) } else { 0.0 };
        let scale = f64::from(unit.scale);
        let origin = [0, 1, 2].map(|axis| (f64::from(ray.origin[axis]) - f64::from(unit.min[axis])) * scale);
        let end = [0, 1, 2].map(|axis| origin[axis] + length * f64::from(ray.direction[axis]));
        Self { origin, end }
    }
}

/// The capsule of a group of rays, unit space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Capsule {
    /// Centre of the origins' bounding box.
    pub origin_centre: Point,
    /// Largest distance of an origin to it.
    pub origin_radius: f64,
    /// Centre of the ends' bounding box.
    pub end_centre: Point,
    /// Largest distance of an end to it.
    pub end_radius: f64,
}

impl Capsule {
    /// Around a group; `None` for an empty one.
    #[inline]
    pub fn around(group: &[Segment]) -> Option<Self> {
        if group.is_empty() {
            return None;
        }
        let (origin_centre, origin_radius) = sphere(group.iter().map(|segment| segment.origin));
        let (end_centre, end_radius) = sphere(group.iter().map(|segment| segment.end));
        Some(Self { origin_centre, origin_radius, end_centre, end_radius })
    }

    /// Area of the surface: two spherical caps and the frustum of a cone that touches both spheres;
    /// that of the larger sphere if it holds the smaller one.
    ///
    /// Continuous, and at equal radii `4πr² + 2πrD`, the talk's capsule.
    pub fn area(&self) -> f64 {
        let (a, b) = (self.origin_radius, self.end_radius);
        let apart = distance(self.origin_centre, self.end_centre);
        let difference = a - b;
        if apart <= difference.abs() {
            return 4.0 * PI * a.max(b).powi(2);
        }
        let slope = difference / apart;
        let caps = 2.0 * PI * (a * a * (1.0 + slope) + b * b * (1.0 - slope));
        caps + PI * (a + b) * (apart * apart - difference * difference) / apart
    }
}

/// The centre of the points' bounding box and the largest distance to it.
#[inline]
fn sphere(points: impl Iterator<Item = Point> + Clone) -> (Point, f64) {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for point in points.clone() {
        for axis in 0..3 {
            // Comparisons of their own are one instruction each, f64::min and f64::max are several.
            low[axis] = if point[axis] < low[axis] { point[axis] } else { low[axis] };
            high[axis] = if point[axis] > high[axis] { point[axis] } else { high[axis] };
        }
    }
    let centre = [0, 1, 2].map(|axis| 0.5 * (low[axis] + high[axis]));
    let squared = points.map(|point| squared_distance(point, centre));
    let squared = squared.fold(0.0f64, |largest, squared| if squared > largest { squared } else { largest });
    (centre, squared.sqrt())
}

#[inline]
fn squared_distance(a: Point, b: Point) -> f64 {
    (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2) + (a[2] - b[2]).powi(2)
}

fn distance(a: Point, b: Point) -> f64 {
    squared_distance(a, b).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn capsule(origin_radius: f64, end_radius: f64, apart: f64) -> Capsule {
        Capsule {
            origin_centre: [0.1, 0.2, 0.3],
            origin_radius,
            end_centre: [0.1, 0.2 + apart, 0.3],
            end_radius,
        }
    }

    fn assert_close(found: f64, expected: f64, tolerance: f64) {
        assert!(
            (found - expected).abs() <= tolerance * expected.abs().max(1e-12),
            "{found}, expected {expected}"
        );
    }

    /// Area of the convex hull of two spheres: its outline, turned around the axis, integrated numerically.
    fn integrated_area(a: f64, b: f64, apart: f64) -> f64 {
        // The outline's point in direction θ is the support point of whichever sphere reaches farther;
        // between the two arcs lies their straight common tangent.
        const STEPS: usize = 200_000;
        let point = |angle: f64| {
            let (sphere, centre) = if a >= b + apart * angle.cos() { (a, 0.0) } else { (b, apart) };
            (centre + sphere * angle.cos(), sphere * angle.sin())
        };
        let mut area = 0.0;
        let mut before = point(0.0);
        for step in 1..=STEPS {
            let here = point(PI * step as f64 / STEPS as f64);
            let length = (here.0 - before.0).hypot(here.1 - before.1);
            area += PI * (here.1 + before.1) * length;
            before = here;
        }
        area
    }

    #[test]
    fn equal_radii_give_the_talks_capsule() {
        for (radius, apart) in [(0.1, 0.5), (0.3, 0.01), (1e-4, 1.0)] {
            let expected = 4.0 * PI * radius * radius + 2.0 * PI * radius * apart;
            assert_close(capsule(radius, radius, apart).area(), expected, 1e-12);
        }
        assert_eq!(capsule(0.0, 0.0, 0.7).area(), 0.0);
    }

    #[test]
    fn unequal_radii_give_the_hulls_surface() {
        for (a, b, apart) in [(0.3, 0.1, 0.5), (0.05, 0.4, 0.6), (0.0, 0.25, 0.75), (0.2, 0.1, 0.1001)] {
            assert_close(capsule(a, b, apart).area(), integrated_area(a, b, apart), 1e-4);
            assert_close(capsule(a, b, apart).area(), capsule(b, a, apart).area(), 1e-12);
        }
    }

    #[test]
    fn a_sphere_in_a_sphere_adds_nothing_and_the_step_is_continuous() {
        let sphere = 4.0 * PI * 0.3 * 0.3;
        assert_close(capsule(0.3, 0.1, 0.1).area(), sphere, 1e-12);
        assert_close(capsule(0.1, 0.3, 0.2).area(), sphere, 1e-12);
        assert_close(capsule(0.3, 0.1, 0.2 + 1e-9).area(), sphere, 1e-6);
        assert_close(capsule(0.3, 0.3, 0.0).area(), sphere, 1e-12);
    }

    #[test]
    fn no_rays_have_no_capsule_and_equal_ones_no_area() {
        assert_eq!(Capsule::around(&[]), None);
        let same = Segment { origin: [0.25; 3], end: [0.5, 0.75, 0.125] };
        let of_equal = Capsule::around(&[same; 64]).unwrap();
        assert_eq!((of_equal.origin_radius, of_equal.end_radius, of_equal.area()), (0.0, 0.0, 0.0));
    }

    #[test]
    fn segments_lie_in_unit_space() {
        let unit = UnitSpace::from_bounds([-2.0, 1.0, 10.0], [6.0, 5.0, 12.0]);
        let ray = Ray { origin: [0.0, 3.0, 11.0], t_min: 0.0, direction: [0.0, -1.0, 0.0], t_max: 4.0 };
        let expected = Segment { origin: [0.25, 0.25, 0.125], end: [0.25, 0.125, 0.125] };
        assert_eq!(Segment::of(&unit, &ray, 0.125), expected);
        assert_eq!(Segment::of(&unit, &ray, f32::INFINITY).end, expected.origin);
    }
}
