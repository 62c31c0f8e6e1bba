//! Vector products with a fixed order of evaluation, so that both backends round alike.
//!
//! Sums and products by component are `glam`'s; what has an order to choose is here and, under the
//! same names, in WGSL.

use glam::Vec3;

/// Dot product, summed from x to z.
pub fn dot3(a: Vec3, b: Vec3) -> f32 {
    a.x * b.x + a.y * b.y + a.z * b.z
}

/// Cross product.
pub fn cross3(a: Vec3, b: Vec3) -> Vec3 {
    Vec3::new(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x)
}

/// A vector of length 1; NaN for a zero vector.
#[inline(always)]
pub fn normalize3(a: Vec3) -> Vec3 {
    a * (1.0 / dot3(a, a).sqrt())
}

/// Perceived brightness of linear RGB (Rec. 709).
#[inline(always)]
pub fn luminance(color: Vec3) -> f32 {
    0.2126 * color.x + 0.7152 * color.y + 0.0722 * color.z
}

/// Vectors of three as kernels read them.
pub fn padded(vectors: &[[f32; 3]]) -> Vec<[f32; 4]> {
    vectors.iter().map(|&[x, y, z]| [x, y, z, 0.0]).collect()
}
