//! The surface of a group's capsule as triangles.

use formats::metrics::capsule::Capsule;
pub(crate) use formats::metrics::capsule::Point;

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
    let (origins, terminations) =
        ((capsule.origin_centre, capsule.origin_radius), (capsule.end_centre, capsule.end_radius));
    let ((from, radius_from), (to, radius_to)) = (origins, terminations);
    let between = sub(to, from);
    let distance = length(between);
    // One sphere inside the other: the larger one alone.
    let is_nested = distance <= (radius_from - radius_to).abs();
    let larger = if radius_from >= radius_to { origins } else { terminations };
    let ends = if is_nested { [larger, larger] } else { [origins, terminations] };
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
    fn the_mesh_has_the_area_of_the_formula() {
        for (radius_a, radius_b, distance) in
            [(1.0, 0.5, 3.0), (0.2, 1.0, 2.0), (1.0, 1.0, 1.0), (2.0, 0.5, 1.0)]
        {
            let to = [0.6 * distance, 0.0, 0.8 * distance];
            let capsule = Capsule {
                origin_centre: [0.0; 3],
                origin_radius: radius_a,
                end_centre: to,
                end_radius: radius_b,
            };
            let corners: Vec<Point> = vertices(&capsule).collect();
            assert_eq!((corners.len(), triangles().count()), (VERTICES, TRIANGLES));
            let area: f64 = triangles()
                .map(|[a, b, c]| {
                    let [a, b, c] = [a, b, c].map(|at| corners[at as usize]);
                    0.5 * length(cross(sub(b, a), sub(c, a)))
                })
                .sum();
            let expected = capsule.area();
            assert!((area / expected - 1.0).abs() < 0.05, "{area} is not {expected}");
        }
    }
}
