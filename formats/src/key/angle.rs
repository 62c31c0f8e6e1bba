//! Arctangent and arccosine as polynomials: the same on every backend, unlike built-ins.
//!
//! Coefficients: Abramowitz & Stegun, Handbook of Mathematical Functions, 4.4.46 (arccosine) and
//! 4.4.49 (arctangent), absolute error ≤ 2·10⁻⁸ before rounding. The WGSL is composed from
//! these same arrays.

use std::f32::consts::{FRAC_1_PI, FRAC_PI_2, PI};

/// `atan(x) = x·(1 + Σ c[i]·x^(2(i+1)))` for |x| ≤ 1.
pub const ARCTANGENT: [f32; 8] = [
    -0.333_331_45,
    0.199_935_51,
    -0.142_089,
    0.106_562_64,
    -0.075_289_64,
    0.042_909_614,
    -0.016_165_737,
    0.002_866_225_7,
];

/// `acos(x) = sqrt(1 − x)·Σ c[i]·x^i` for 0 ≤ x ≤ 1.
pub const ARCCOSINE: [f32; 8] = [
    FRAC_PI_2,
    -0.214_598_8,
    0.088_978_99,
    -0.050_174_305,
    0.030_891_88,
    -0.017_088_126,
    0.006_670_09,
    -0.001_262_491_1,
];

/// Azimuth `atan2(y, x)/2π + 0.5` in [0, 1]; 0.5 at x = y = 0. Error ≤ 2⁻²⁰.
#[inline(always)]
pub fn azimuth(x: f32, y: f32) -> f32 {
    let (ax, ay) = (x.abs(), y.abs());
    let larger = ax.max(ay);
    let z = ax.min(ay) / larger;
    let z2 = z * z;
    let mut sum = ARCTANGENT[7];
    for &coefficient in ARCTANGENT[..7].iter().rev() {
        sum = sum * z2 + coefficient;
    }
    let mut angle = z * (sum * z2 + 1.0);
    if ay > ax {
        angle = FRAC_PI_2 - angle;
    }
    if x < 0.0 {
        angle = PI - angle;
    }
    if y < 0.0 {
        angle = -angle;
    }
    if larger == 0.0 { 0.5 } else { angle * (0.5 * FRAC_1_PI) + 0.5 }
}

/// Polar angle `acos(z)/π` in [0, 1]; z is clamped to [−1, 1]. Error ≤ 2⁻²⁰.
#[inline(always)]
pub fn polar(z: f32) -> f32 {
    let a = z.abs().min(1.0);
    let mut sum = ARCCOSINE[7];
    for &coefficient in ARCCOSINE[..7].iter().rev() {
        sum = sum * a + coefficient;
    }
    let angle = (1.0 - a).sqrt() * sum;
    let angle = if z < 0.0 { PI - angle } else { angle };
    angle * FRAC_1_PI
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOUND: f64 = 1.0 / (1u32 << 20) as f64;

    #[test]
    fn azimuth_stays_within_its_bound_of_f64() {
        for i in 0..200_000 {
            let angle = f64::from(i) * 0.000_031_415_926_5 * 2.0 - std::f64::consts::PI;
            let (x, y) = (angle.cos() as f32, angle.sin() as f32);
            let truth = f64::from(y).atan2(f64::from(x)) / (2.0 * std::f64::consts::PI) + 0.5;
            let error = (f64::from(azimuth(x, y)) - truth).abs();
            assert!(error <= BOUND, "x {x} y {y}: error {error:e}");
        }
    }

    #[test]
    fn polar_stays_within_its_bound_of_f64() {
        for i in 0..=400_000 {
            let z = (f64::from(i) / 200_000.0 - 1.0) as f32;
            let truth = f64::from(z).acos() / std::f64::consts::PI;
            let error = (f64::from(polar(z)) - truth).abs();
            assert!(error <= BOUND, "z {z}: error {error:e}");
        }
    }

    #[test]
    fn poles_and_axes() {
        assert_eq!(azimuth(0.0, 0.0), 0.5);
        assert_eq!(azimuth(1.0, 0.0), 0.5);
        assert_eq!(azimuth(0.0, 1.0), 0.75);
        assert_eq!(azimuth(0.0, -1.0), 0.25);
        assert_eq!(polar(1.0), 0.0);
        assert_eq!(polar(-1.0), 1.0);
        assert!((polar(0.0) - 0.5).abs() < 1e-7);
    }
}
