//! Eight vectors side by side, for work on eight paths at once: the arithmetic of [`super::vector`], lane by lane, and
//! so with its bits.

use std::ops::{Add, Mul, Neg, Sub};

use fearless_simd::prelude::*;
use fearless_simd::{f32x8, mask32x8};
use glam::Vec3;

/// How many.
pub const LANES: usize = 8;

/// Eight vectors.
#[derive(Clone, Copy, Debug)]
pub struct Vec3x8<S: Simd> {
    /// First components.
    pub x: f32x8<S>,
    /// Second components.
    pub y: f32x8<S>,
    /// Third components.
    pub z: f32x8<S>,
}

impl<S: Simd> Vec3x8<S> {
    /// These.
    #[inline(always)]
    pub fn new(x: f32x8<S>, y: f32x8<S>, z: f32x8<S>) -> Self {
        Self { x, y, z }
    }

    /// The same vector eight times.
    #[inline(always)]
    pub fn splat(simd: S, v: Vec3) -> Self {
        Self::from_lanes(simd, |_| v.to_array())
    }

    /// The vector of each lane, 0 to 7.
    #[inline(always)]
    pub fn from_lanes(simd: S, of: impl Fn(usize) -> [f32; 3]) -> Self {
        let component = |axis: usize| f32x8::from_fn(simd, |lane| of(lane)[axis]);
        Self::new(component(0), component(1), component(2))
    }

    /// The components of all lanes.
    #[inline(always)]
    pub fn to_arrays(self) -> [[f32; LANES]; 3] {
        [self.x, self.y, self.z].map(f32x8::to_array)
    }

    /// Of each lane that of `self` where `mask` is set, else `other`'s.
    #[inline(always)]
    pub fn where_or(self, mask: mask32x8<S>, other: Self) -> Self {
        Self::new(mask.select(self.x, other.x), mask.select(self.y, other.y), mask.select(self.z, other.z))
    }

    /// Pointing the other way where `mask` is set.
    #[inline(always)]
    pub fn negated_where(self, mask: mask32x8<S>) -> Self {
        (-self).where_or(mask, self)
    }
}

impl<S: Simd> Add for Vec3x8<S> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self::new(self.x + other.x, self.y + other.y, self.z + other.z)
    }
}

impl<S: Simd> Sub for Vec3x8<S> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self::new(self.x - other.x, self.y - other.y, self.z - other.z)
    }
}

impl<S: Simd> Neg for Vec3x8<S> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self::new(-self.x, -self.y, -self.z)
    }
}

impl<S: Simd> Mul for Vec3x8<S> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self::new(self.x * other.x, self.y * other.y, self.z * other.z)
    }
}

impl<S: Simd> Mul<f32x8<S>> for Vec3x8<S> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, factor: f32x8<S>) -> Self {
        Self::new(self.x * factor, self.y * factor, self.z * factor)
    }
}

/// Dot product, summed from x to z.
#[inline(always)]
pub fn dot3<S: Simd>(a: Vec3x8<S>, b: Vec3x8<S>) -> f32x8<S> {
    a.x * b.x + a.y * b.y + a.z * b.z
}

/// Cross product.
#[inline(always)]
pub fn cross3<S: Simd>(a: Vec3x8<S>, b: Vec3x8<S>) -> Vec3x8<S> {
    Vec3x8::new(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x)
}

/// Vectors of length 1; NaN for zero vectors.
#[inline(always)]
pub fn normalize3<S: Simd>(a: Vec3x8<S>) -> Vec3x8<S> {
    a * (1.0 / dot3(a, a).sqrt())
}

/// The largest component, without its sign.
#[inline(always)]
pub fn largest<S: Simd>(a: Vec3x8<S>) -> f32x8<S> {
    a.x.abs().max(a.y.abs()).max(a.z.abs())
}

/// Two unit vectors across each unit vector of `n` (Duff et al., "Building an Orthonormal Basis,
/// Revisited", JCGT 2017).
#[inline(always)]
pub fn basis<S: Simd>(n: Vec3x8<S>) -> (Vec3x8<S>, Vec3x8<S>) {
    let simd = n.z.token();
    let sign = n.z.simd_ge(0.0).select(f32x8::splat(simd, 1.0), f32x8::splat(simd, -1.0));
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    (
        Vec3x8::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x),
        Vec3x8::new(b, sign + n.y * n.y * a, -n.y),
    )
}

/// Perceived brightness of linear RGB (Rec. 709).
#[inline(always)]
pub fn luminance<S: Simd>(color: Vec3x8<S>) -> f32x8<S> {
    0.2126 * color.x + 0.7152 * color.y + 0.0722 * color.z
}
