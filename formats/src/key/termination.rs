//! The estimated termination point of the two-point methods (docs/keys.md, "Estimated end").

use super::COORDINATE_BITS;
use super::coordinates::quantise;
use crate::ray::Ray;
use crate::unit_space::UnitSpace;

/// No ray is thought to be longer than this, in unit lengths: just above √3.
pub const LONGEST: f32 = 1.75;

/// Fraction bits of lengths and direction coordinates when the point is stepped in integers.
pub const STEP_BITS: u32 = 15;

/// `L`: the estimate `length` (unit space), cut by the ray's own end and the scene's box.
///
/// `origin` is the ray's origin in unit space.
#[inline(always)]
pub fn bounded_length(unit: &UnitSpace, ray: &Ray, origin: [f32; 3], length: f32) -> f32 {
    let exit = unit.exit(origin, ray.direction);
    length.min(ray.t_max * unit.scale).min(exit).clamp(0.0, LONGEST)
}

/// `e22` along one axis: the quantised origin moved by `length · direction` in integers.
///
/// Exact on every device once `length` is known: both conversions truncate, the product of
/// 57,344 and 32,768 fits an i32, the shift is arithmetic. Directions that are no unit vectors, which
/// only files have, wrap around as the integers of WGSL do.
#[inline(always)]
pub fn end_quantised(origin: f32, length: f32, direction: f32) -> u32 {
    const ONE: f32 = (1u32 << STEP_BITS) as f32;
    let product = truncated(length * ONE).wrapping_mul(truncated(direction * ONE));
    let step = product >> (2 * STEP_BITS - COORDINATE_BITS);
    (quantise(origin) as i32 + step).clamp(0, (1 << COORDINATE_BITS) - 1) as u32
}

/// `value as i32`, which compilers turn into vector instructions less well.
#[expect(clippy::manual_range_contains, reason = "both comparisons, without a branch")]
#[inline(always)]
fn truncated(value: f32) -> i32 {
    const BEYOND: f32 = 2_147_483_648.0;
    let is_held = (value >= -BEYOND) & (value < BEYOND);
    // SAFETY: an i32 holds it.
    let whole = unsafe { (if is_held { value } else { 0.0 }).to_int_unchecked::<i32>() };
    let beyond = if value >= BEYOND { i32::MAX } else { whole };
    if value < -BEYOND { i32::MIN } else { beyond }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_point_is_within_a_few_quanta_of_f64() {
        let quantum = 1.0 / f64::from(1u32 << 22);
        // One step of 2^-15 in each factor, over a length of at most 1.75.
        let bound = 1.75 / 32_768.0 * 2.0 + 2.0 * quantum;
        for i in 0..50_000u32 {
            let part = |salt: u32| (i.wrapping_mul(salt) >> 8) as f32 / (1u32 << 24) as f32;
            let (origin, length, direction) =
                (part(2_654_435_761), part(2_246_822_519) * 1.75, part(3_266_489_917) * 2.0 - 1.0);
            let truth = (f64::from(origin) + f64::from(length) * f64::from(direction)).clamp(0.0, 1.0);
            let found = f64::from(end_quantised(origin, length, direction)) * quantum;
            assert!(
                (found - truth).abs() <= bound,
                "o {origin} l {length} d {direction}: {found} against {truth}"
            );
        }
    }

    #[test]
    fn truncating_is_as_the_language_does_it() {
        let bits = (0..=u32::MAX).step_by(65_521);
        let edges = [2_147_483_520.0, 2_147_483_648.0, -2_147_483_648.0, -2_147_483_904.0];
        for value in bits.map(f32::from_bits).chain(edges) {
            assert_eq!(truncated(value), value as i32, "{value}");
        }
    }

    #[test]
    fn lengths_are_cut_by_light_box_and_longest() {
        let unit = UnitSpace::from_bounds([0.0; 3], [2.0, 1.0, 1.0]);
        let ray =
            Ray { origin: [0.5, 0.5, 0.5], t_min: 0.0, direction: [1.0, 0.0, 0.0], t_max: f32::INFINITY };
        let origin = unit.point(ray.origin);
        assert_eq!(bounded_length(&unit, &ray, origin, 0.25), 0.25);
        assert_eq!(bounded_length(&unit, &ray, origin, 5.0), 0.75);
        let short = Ray { t_max: 0.5, ..ray };
        assert_eq!(bounded_length(&unit, &short, origin, 5.0), 0.25);
    }
}
