//! The watertight triangle test of Woop, Benthin and Wald 2013.
//!
//! The ray is sheared and scaled so that it runs along +z from the origin; a triangle is hit if
//! the origin lies in its projection. Both triangles at an edge see the same two sheared corners
//! and compute the same edge function up to its sign, so no ray passes between them. On a GPU
//! that contracts `a·b − c·d` that would only hold for one order of the two corners, so the WGSL
//! takes them in lexicographic order and flips the sign; without contraction, as here, both
//! orders give the same bits.
//!
//! We deviate from the paper in one point: where an edge function is zero we do not fall back to
//! double precision but count the edge in, on both sides. Rays exactly through an edge then hit
//! both triangles, and the lowest index wins.
//!
//! Hits nearer than the error of their own distance are not believed. Without that, a ray that leaves a
//! small triangle finds a large one that lies in the same plane, at a distance that is nothing but
//! rounding: in a room in millimetres some percent of all shadow rays did.

use formats::ray::Ray;
use glam::{Vec3, Vec4, Vec4Swizzles};

/// Bounds of the relative error of 2, 3 and 5 roundings in a row, `nε / (1 − nε)` with ε = 2⁻²⁴.
pub const GAMMA_2: f32 = 1.192_093e-7;
/// See [`GAMMA_2`].
pub const GAMMA_3: f32 = 1.788_139_7e-7;
/// See [`GAMMA_2`].
pub const GAMMA_5: f32 = 2.980_233_3e-7;

/// A ray's transformation: which axes are sheared, and by how much.
#[derive(Clone, Copy, Debug)]
pub struct Shear {
    /// Axes x, y, z after permutation; z is the one with the largest component of the direction,
    /// x and y are swapped where that is negative, so that windings are preserved.
    pub axes: [usize; 3],
    /// `d_x/d_z`, `d_y/d_z`, `1/d_z` with permuted axes.
    pub shear: [f32; 3],
    /// The ray's origin, axes permuted.
    pub origin: [f32; 3],
}

impl Shear {
    /// The transformation for a ray with a direction that is not zero.
    #[inline(always)]
    pub fn new(ray: &Ray) -> Self {
        let d = ray.direction;
        let size = d.map(f32::abs);
        let z = if size[0] >= size[1] {
            if size[0] >= size[2] { 0 } else { 2 }
        } else if size[1] >= size[2] {
            1
        } else {
            2
        };
        let (mut x, mut y) = ((z + 1) % 3, (z + 2) % 3);
        if d[z] < 0.0 {
            (x, y) = (y, x);
        }
        let o = ray.origin;
        Self { axes: [x, y, z], shear: [d[x] / d[z], d[y] / d[z], 1.0 / d[z]], origin: [o[x], o[y], o[z]] }
    }
}

/// A triangle as leaves hold it: one row per axis with that coordinate of the three corners, so
/// that a permutation of axes is a choice of rows; 48 bytes.
#[repr(C, align(16))]
#[derive(Clone, Copy, Debug)]
pub struct LeafTriangle {
    rows: [[f32; 4]; 3],
}

impl LeafTriangle {
    /// From its corners, its index in the scene and its mask (0 = none).
    pub fn new(corners: &[[f32; 3]; 3], triangle: u32, mask: u32) -> Self {
        let row = |axis: usize, extra: u32| {
            [corners[0][axis], corners[1][axis], corners[2][axis], f32::from_bits(extra)]
        };
        Self { rows: [row(0, triangle), row(1, mask), row(2, 0)] }
    }

    /// Its corners.
    #[inline(always)]
    pub fn corners(&self) -> [Vec3; 3] {
        let [x, y, z] = self.rows;
        [0, 1, 2].map(|corner| Vec3::new(x[corner], y[corner], z[corner]))
    }

    /// Its index in the scene.
    #[inline(always)]
    pub fn triangle(&self) -> u32 {
        self.rows[0][3].to_bits()
    }

    /// Number of its alpha mask, counted from 1; 0 if it has none.
    #[inline(always)]
    pub fn mask(&self) -> u32 {
        self.rows[1][3].to_bits()
    }

    /// Where a line hits the triangle's plane inside its edges; `t` may be anything, also NaN.
    #[inline(always)]
    pub fn intersect(&self, ray: &Shear) -> Option<Intersection> {
        // Four lanes at a time; what the last one holds and becomes is of no interest.
        let [rx, ry, rz] = ray.axes.map(|axis| Vec4::from_array(self.rows[axis]));
        let z = rz - Vec4::splat(ray.origin[2]);
        let x = (rx - Vec4::splat(ray.origin[0])) - Vec4::splat(ray.shear[0]) * z;
        let y = (ry - Vec4::splat(ray.origin[1])) - Vec4::splat(ray.shear[1]) * z;
        // Weight of a corner: the edge function of the two others.
        let edges = x.zxyw() * y.yzxw() - y.zxyw() * x.yzxw();
        let corners = 0b111;
        let is_negative = edges.cmplt(Vec4::ZERO).bitmask() & corners != 0;
        let is_positive = edges.cmpgt(Vec4::ZERO).bitmask() & corners != 0;
        if is_negative && is_positive {
            return None;
        }
        let [a, b, c, _] = edges.to_array();
        let sum = (a + b) + c;
        if sum == 0.0 {
            return None;
        }
        let depths = (Vec4::splat(ray.shear[2]) * z).truncate();
        let [az, bz, cz] = depths.to_array();
        let scaled_t = (a * az + b * bz) + c * cz;
        let t = scaled_t / sum;
        // Few triangles come this far, so that the bound costs little.
        if t <= error_bound(x.truncate(), y.truncate(), depths, edges.truncate(), sum) {
            return None;
        }
        // Quotients of numbers of the same sign: `abs` only removes the sign of a zero, which
        // depends on the order of an edge's corners.
        Some(Intersection { t, u: (b / sum).abs(), v: (c / sum).abs() })
    }
}

/// How far off the computed distance may be: nearer than this, nobody knows on which side of the triangle
/// the ray starts. From the sheared corners, their depths along the ray, the edge functions and their sum
/// (Pharr, Jakob & Humphreys, Physically Based Rendering, 3rd edition, §3.9.6).
#[inline(always)]
fn error_bound(x: Vec3, y: Vec3, depths: Vec3, edges: Vec3, sum: f32) -> f32 {
    let largest = |v: Vec3| v.abs().max_element();
    let (x, y, z, edge) = (largest(x), largest(y), largest(depths), largest(edges));
    let error_z = GAMMA_3 * z;
    let (error_x, error_y) = (GAMMA_5 * (x + z), GAMMA_5 * (y + z));
    let error_edge = 2.0 * (GAMMA_2 * x * y + error_y * x + error_x * y);
    3.0 * (GAMMA_3 * edge * z + error_edge * z + error_z * edge) / sum.abs()
}

/// Where a line meets a triangle.
#[derive(Clone, Copy, Debug)]
pub struct Intersection {
    /// Distance in units of the direction's length.
    pub t: f32,
    /// Barycentric weight of the second corner.
    pub u: f32,
    /// Barycentric weight of the third corner.
    pub v: f32,
}
