//! The surface of a group's capsule as triangles.

use formats::metrics::capsule::{Capsule, Point};
use glam::DVec3;

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
    let origins = (DVec3::from(capsule.origin_centre), capsule.origin_radius);
    let terminations = (DVec3::from(capsule.end_centre), capsule.end_radius);
    let ((from, radius_from), (to, radius_to)) = (origins, terminations);
    let between = to - from;
    let distance = between.length();
    // One sphere inside the other: the larger one alone.
    let is_nested = distance <= (radius_from - radius_to).abs();
    let larger = if radius_from >= radius_to { origins } else { terminations };
    let ends = if is_nested { [larger, larger] } else { [origins, terminations] };
    let tangent = if is_nested { 0.0 } else { ((radius_from - radius_to) / distance).asin() };
    let axis = if distance > 0.0 { between / distance } else { DVec3::Z };
    let (right, up) = across(axis);
    let quarter = std::f64::consts::FRAC_PI_2;
    (0..2 * RINGS).flat_map(move |ring| {
        let part = (ring % RINGS) as f64 / (RINGS - 1) as f64;
        let (low, high) = if ring < RINGS { (-quarter, tangent) } else { (tangent, quarter) };
        let (along, around) = (low + (high - low) * part).sin_cos();
        let (centre, radius) = ends[ring / RINGS];
        (0..SEGMENTS).map(move |segment| {
            let (sine, cosine) = (segment as f64 / SEGMENTS as f64 * std::f64::consts::TAU).sin_cos();
            (centre + radius * (along * axis + around * (cosine * right + sine * up))).into()
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
fn across(axis: DVec3) -> (DVec3, DVec3) {
    let other = if axis.x.abs() < 0.7 { DVec3::X } else { DVec3::Y };
    let right = other.cross(axis);
    let right = right / right.length();
    (right, axis.cross(right))
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
            let corners: Vec<DVec3> = vertices(&capsule).map(DVec3::from).collect();
            assert_eq!((corners.len(), triangles().count()), (VERTICES, TRIANGLES));
            let area: f64 = triangles()
                .map(|[a, b, c]| {
                    let [a, b, c] = [a, b, c].map(|at| corners[at as usize]);
                    0.5 * (b - a).cross(c - a).length()
                })
                .sum();
            let expected = capsule.area();
            assert!((area / expected - 1.0).abs() < 0.05, "{area} is not {expected}");
        }
    }
}
