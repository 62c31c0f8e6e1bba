//! The capsule of a group of rays: the convex hull of a sphere around its origins and one around its
//! termination points (KEYS: "Coherence of an order"), and its surface as triangles.

/// A point in world space.
pub(crate) type Point = [f64; 3];

/// Two spheres, world units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Capsule {
    /// Centre and radius of the sphere around the origins.
    pub(crate) origins: (Point, f64),
    /// Centre and radius of the sphere around the termination points.
    pub(crate) terminations: (Point, f64),
}

impl Capsule {
    /// The capsule of rays from `origins` to `terminations`.
    pub(crate) fn around(origins: &[Point], terminations: &[Point]) -> Self {
        Self { origins: sphere(origins), terminations: sphere(terminations) }
    }
}

/// The centre of the points' bounding box, and the largest distance to it.
fn sphere(points: &[Point]) -> (Point, f64) {
    let mut low = [f64::INFINITY; 3];
    let mut high = [f64::NEG_INFINITY; 3];
    for point in points {
        for axis in 0..3 {
            low[axis] = low[axis].min(point[axis]);
            high[axis] = high[axis].max(point[axis]);
        }
    }
    let centre = [0, 1, 2].map(|axis| 0.5 * (low[axis] + high[axis]));
    let radius = points.iter().map(|point| length(sub(*point, centre))).fold(0.0, f64::max);
    (centre, radius)
}

/// Corners around the axis of a capsule's mesh.
pub(crate) const SEGMENTS: usize = 16;
/// Rings of corners on each of its two spheres.
const RINGS: usize = 6;
/// Corners of a mesh.
pub(crate) const VERTICES: usize = 2 * RINGS * SEGMENTS;
/// Triangles of a mesh.
pub(crate) const TRIANGLES: usize = (2 * RINGS - 1) * SEGMENTS * 2;

/// The corners of a capsule's surface: rings from the far side of the first sphere, over the cone that
/// touches both, to the far side of the other.
pub(crate) fn vertices(capsule: &Capsule) -> impl Iterator<Item = Point> + use<> {
    let ((from, radius_from), (to, radius_to)) = (capsule.origins, capsule.terminations);
    let between = sub(to, from);
    let distance = length(between);
    // One sphere inside the other: the larger one alone.
    let is_nested = distance <= (radius_from - radius_to).abs();
    let larger = if radius_from >= radius_to { capsule.origins } else { capsule.terminations };
    let ends = if is_nested { [larger, larger] } else { [capsule.origins, capsule.terminations] };
    let tangent = if is_nested { 0.0 } else { ((radius_from - radius_to) / distance).asin() };
    let axis = if distance > 0.0 { between.map(|part| part / distance) } else { [0.0, 0.0, 1.0] };
    let (right, up) = across(axis);
    let quarter = std::f64::consts::FRAC_PI_2;
    (0..2 * RINGS).flat_map(move |ring| {
        let part = (ring % RINGS) as f64 / (RINGS - 1) as f64;
        let (low, high) = if ring < RINGS { (-quarter, tangent) } else { (tangent, quarter) };
        let (along, around) = (low + (high - low) * part).sin_cos();
        let (centre, radius) = ends[ring / RINGS];
        (0..SEGMENTS).map(move |segment| {
            let (sine, cosine) = (segment as f64 / SEGMENTS as f64 * std::f64::consts::TAU).sin_cos();
            [0, 1, 2].map(|at| {
                centre[at] + radius * (along * axis[at] + around * (cosine * right[at] + sine * up[at]))
            })
        })
    })
}

/// The triangles of a mesh, as places among its corners.
pub(crate) fn triangles() -> impl Iterator<Item = [u32; 3]> {
    (0..2 * RINGS - 1).flat_map(|ring| {
        (0..SEGMENTS).flat_map(move |segment| {
            let place = |ring: usize, segment: usize| (ring * SEGMENTS + segment % SEGMENTS) as u32;
            let (a, b) = (place(ring, segment), place(ring, segment + 1));
            let (c, d) = (place(ring + 1, segment), place(ring + 1, segment + 1));
            [[a, b, c], [b, d, c]]
        })
    })
}

/// Two directions at right angles to a unit vector and to each other.
fn across(axis: Point) -> (Point, Point) {
    let other = if axis[0].abs() < 0.7 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
    let right = cross(other, axis);
    let right = right.map(|part| part / length(right));
    (right, cross(axis, right))
}

fn cross(a: Point, b: Point) -> Point {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn sub(a: Point, b: Point) -> Point {
    [0, 1, 2].map(|axis| a[axis] - b[axis])
}

fn length(a: Point) -> f64 {
    a.iter().map(|part| part * part).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spheres_hold_their_points() {
        let capsule = Capsule::around(&[[0.0; 3], [2.0, 0.0, 0.0]], &[[0.0, 5.0, 1.0]]);
        assert_eq!(capsule.origins, ([1.0, 0.0, 0.0], 1.0));
        assert_eq!(capsule.terminations, ([0.0, 5.0, 1.0], 0.0));
    }

    /// Area of KEYS' formula, against that of the mesh.
    #[test]
    fn the_mesh_has_the_area_of_the_formula() {
        for (radius_a, radius_b, distance) in
            [(1.0, 0.5, 3.0), (0.2, 1.0, 2.0), (1.0, 1.0, 1.0), (2.0, 0.5, 1.0)]
        {
            let to = [0.6 * distance, 0.0, 0.8 * distance];
            let capsule = Capsule { origins: ([0.0; 3], radius_a), terminations: (to, radius_b) };
            let corners: Vec<Point> = vertices(&capsule).collect();
            assert_eq!((corners.len(), triangles().count()), (VERTICES, TRIANGLES));
            let area: f64 = triangles()
                .map(|[a, b, c]| {
                    let [a, b, c] = [a, b, c].map(|at| corners[at as usize]);
                    0.5 * length(cross(sub(b, a), sub(c, a)))
                })
                .sum();
            let (tau, delta) = (std::f64::consts::TAU, radius_a - radius_b);
            let expected = if distance <= delta.abs() {
                2.0 * tau * radius_a.max(radius_b).powi(2)
            } else {
                let caps = radius_a * radius_a * (1.0 + delta / distance)
                    + radius_b * radius_b * (1.0 - delta / distance);
                tau * caps
                    + 0.5 * tau * (radius_a + radius_b) * (distance * distance - delta * delta) / distance
            };
            assert!((area / expected - 1.0).abs() < 0.05, "{area} is not {expected}");
        }
    }
}
