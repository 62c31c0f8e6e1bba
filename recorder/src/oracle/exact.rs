//! Arithmetic without rounding: numbers as integers times a common power of two.

use num_bigint::{BigInt, Sign};

/// A vector of whole numbers.
pub(super) type Vector = [BigInt; 3];

/// Finite vectors as whole numbers in units of `2^exponent`, and that exponent.
pub(super) fn whole<const N: usize>(vectors: [[f64; 3]; N]) -> ([Vector; N], i32) {
    let lowest = vectors.iter().flatten().filter(|x| **x != 0.0).map(|x| parts(*x).1).min();
    let exponent = lowest.unwrap_or(0);
    let number = |x: f64| {
        let (mantissa, own) = parts(x);
        if mantissa == 0 { BigInt::ZERO } else { BigInt::from(mantissa) << (own - exponent) }
    };
    (vectors.map(|vector| vector.map(number)), exponent)
}

/// A finite number as mantissa and exponent, the mantissa as short as it can be.
fn parts(x: f64) -> (i64, i32) {
    let bits = x.to_bits();
    let (field, fraction) = ((bits >> 52 & 0x7ff) as i32, (bits & ((1 << 52) - 1)) as i64);
    let (mantissa, exponent) =
        if field == 0 { (fraction, -1074) } else { (fraction | 1 << 52, field - 1075) };
    let zeros = if mantissa == 0 { 0 } else { mantissa.trailing_zeros() as i32 };
    let mantissa = mantissa >> zeros;
    (if x < 0.0 { -mantissa } else { mantissa }, exponent + zeros)
}

pub(super) fn minus(a: &Vector, b: &Vector) -> Vector {
    [0, 1, 2].map(|axis| &a[axis] - &b[axis])
}

pub(super) fn cross(a: &Vector, b: &Vector) -> Vector {
    [(1, 2), (2, 0), (0, 1)].map(|(i, j)| &a[i] * &b[j] - &a[j] * &b[i])
}

pub(super) fn dot(a: &Vector, b: &Vector) -> BigInt {
    &a[0] * &b[0] + &a[1] * &b[1] + &a[2] * &b[2]
}

/// `numerator / denominator · 2^exponent`, to within 2^-50 of itself. The denominator is not zero.
pub(super) fn quotient(numerator: &BigInt, denominator: &BigInt, exponent: i32) -> f64 {
    // At least 60 bits of quotient, at most 62.
    let shift = 61 + denominator.bits() as i64 - numerator.bits() as i64;
    let scaled = if shift >= 0 { numerator << shift } else { numerator >> -shift };
    let ratio: BigInt = scaled / denominator;
    let (sign, digits) = ratio.into_parts();
    let size = digits.to_u64_digits().first().map_or(0.0, |&digit| digit as f64);
    let value = size * 2f64.powi(exponent - shift as i32);
    if sign == Sign::Minus { -value } else { value }
}
