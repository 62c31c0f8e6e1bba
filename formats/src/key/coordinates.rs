//! From a ray to numbers in [0, 1], and from those to integers of 22 bits.

use super::{COORDINATE_BITS, LightSite};

/// One over √3, the longest distance in unit space.
pub const INVERSE_SQRT_3: f32 = 0.577_350_26;

/// Quantises to 22 bits: equal cells, NaN and negatives to 0, overflow to the last cell (docs/keys.md).
/// A coordinate of n < 22 bits is the top n of these.
#[expect(clippy::manual_clamp, reason = "a clamp keeps NaN")]
#[inline(always)]
pub fn quantise(value: f32) -> u32 {
    const LAST: f32 = ((1 << COORDINATE_BITS) - 1) as f32;
    let scaled = (value * (1u32 << COORDINATE_BITS) as f32).max(0.0).min(LAST);
    // SAFETY: from 0 to LAST, which an i32 holds; NaN became 0.
    unsafe { scaled.to_int_unchecked::<i32>() as u32 }
}

/// Cartesian map of a unit vector's coordinate: (x + 1)/2.
#[inline(always)]
pub fn cartesian(x: f32) -> f32 {
    (x + 1.0) * 0.5
}

/// Octahedral map of a direction of any length to [0, 1]²; (0.5, 0.5) for a zero vector.
#[inline(always)]
pub fn octahedral(d: [f32; 3]) -> [f32; 2] {
    let sum = d[0].abs() + d[1].abs() + d[2].abs();
    let upper = [d[0] / sum, d[1] / sum];
    let sign = |x: f32| if x > 0.0 { 1.0 } else { -1.0 };
    let lower = [(1.0 - upper[1].abs()) * sign(d[0]), (1.0 - upper[0].abs()) * sign(d[1])];
    let select = |upper: f32, lower: f32| {
        let p = cartesian(if d[2] < 0.0 { lower } else { upper });
        if sum == 0.0 { 0.5 } else { p }
    };
    [select(upper[0], lower[0]), select(upper[1], lower[1])]
}

/// Paraboloid map of a unit vector to [0, 1]²: directions with z < 0 in the left half, the others in the right one.
#[inline(always)]
pub fn paraboloid(d: [f32; 3]) -> [f32; 2] {
    let k = d[2].abs() + 1.0;
    let half = if d[2] < 0.0 { 0.25 } else { 0.75 };
    [d[0] / k * 0.25 + half, d[1] / k * 0.5 + 0.5]
}

/// Coordinates of a shadow ray seen from its light: (u, v, r), each in [0, 1].
///
/// `origin` in unit space. See docs/keys.md, "Coordinates".
pub fn from_light(site: &LightSite, origin: [f32; 3], direction: [f32; 3]) -> [f32; 3] {
    match site {
        LightSite::Placed { centre } => seen_from(*centre, origin),
        LightSite::Directional { direction, tangent, bitangent } => {
            [tangent, bitangent, direction].map(|axis| cartesian(dot(origin, *axis) * INVERSE_SQRT_3))
        }
        LightSite::Environment => {
            let [u, v] = octahedral(direction);
            [u, v, 0.0]
        }
    }
}

/// [`from_light`] of a light with a place.
#[inline(always)]
pub(super) fn seen_from(centre: [f32; 3], origin: [f32; 3]) -> [f32; 3] {
    let d = [origin[0] - centre[0], origin[1] - centre[1], origin[2] - centre[2]];
    let [u, v] = octahedral(d);
    [u, v, dot(d, d).sqrt() * INVERSE_SQRT_3]
}

#[inline(always)]
fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantising_has_equal_cells_and_clamps() {
        assert_eq!(quantise(0.0), 0);
        assert_eq!(quantise(-1.0), 0);
        assert_eq!(quantise(f32::NAN), 0);
        assert_eq!(quantise(0.5), 1 << 21);
        assert_eq!(quantise(1.0), (1 << 22) - 1);
        assert_eq!(quantise(f32::INFINITY), (1 << 22) - 1);
        // The oracle: floor in f64, for n bits and as a prefix of 22.
        for i in 0..100_000u32 {
            let value = i.wrapping_mul(2_654_435_761) as f32 / u32::MAX as f32;
            for n in [1, 5, 11, 21, 22] {
                let truth = ((f64::from(value) * f64::from(1u32 << n)).floor() as u32).min((1 << n) - 1);
                assert_eq!(quantise(value) >> (22 - n), truth, "{value} at {n} bits");
            }
        }
    }

    #[test]
    fn octahedral_covers_the_square_and_separates_hemispheres() {
        assert_eq!(octahedral([0.0; 3]), [0.5, 0.5]);
        assert_eq!(octahedral([0.0, 0.0, 1.0]), [0.5, 0.5]);
        assert_eq!(octahedral([1.0, 0.0, 0.0]), [1.0, 0.5]);
        assert_eq!(octahedral([0.0, -2.0, 0.0]), [0.5, 0.0]);
        assert_eq!(octahedral([1.0, 1.0, -2.0]), [0.875, 0.875]);
        assert_eq!(octahedral([0.0, 0.0, -1.0]), [0.0, 0.0]);
    }

    #[test]
    fn paraboloids_lie_side_by_side() {
        assert_eq!(paraboloid([0.0, 0.0, 1.0]), [0.75, 0.5]);
        assert_eq!(paraboloid([0.0, 0.0, -1.0]), [0.25, 0.5]);
        assert_eq!(paraboloid([1.0, 0.0, 0.0]), [1.0, 0.5]);
        assert_eq!(paraboloid([0.0, -1.0, 0.0]), [0.75, 0.0]);
        assert_eq!(paraboloid([-0.8, 0.0, -0.6]), [0.125, 0.5]);
    }
}
