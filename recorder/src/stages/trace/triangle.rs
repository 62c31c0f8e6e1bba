//! The watertight triangle test of Woop, Benthin and Wald 2013.
//!
//! The ray is sheared and scaled so that it runs along +z from the origin; a triangle is hit if
//! the origin lies in its projection. Both triangles at an edge see the same two sheared corners
//! and compute the same edge function up to its sign, so no ray passes between them. On a GPU
//! that contracts `a·b − c·d` that would only hold for one order of the two corners, so there the WGSL
//! takes them in lexicographic order and flips the sign; without contraction, as here and on devices whose
//! self-check finds none, both orders give the same bits.
//!
//! We deviate from the paper in one point: where an edge function is zero we do not fall back to
//! double precision but count the edge in, on both sides. Rays exactly through an edge then hit
//! both triangles, and the lowest index wins.
//!
//! The distance is another deviation. The paper weights the corners' depths by the edge functions; those of
//! a sliver are all rounding, and so would be its distance, anywhere along the sliver. Here it comes
//! from the triangle's plane, whose normal is the product of the two shorter edges. It is kept between the
//! corners' depths, and behind the place where the ray enters the triangle's bounding box: by the arithmetic
//! of the box tests, so that no hierarchy drops a box for being farther away than what is in it. A
//! triangle without area has no plane and is never hit.
//!
//! A hit is believed if the plane lies ahead of the ray beyond rounding, or, where rounding hides on which
//! side of the plane the ray starts or whether it comes nearer, if all corners lie ahead. Without that, a ray
//! that leaves a small triangle finds a large one that lies in the same plane, at a distance that is
//! nothing but rounding: in a room in millimetres some percent of all shadow rays did.

use formats::ray::{Hit, Ray};
use glam::{Vec3, Vec4, Vec4Swizzles};

use super::cpu_vector::Vector;
use super::mask::Masks;
use crate::stages::vector::{cross3, dot3};

/// Bound of the relative error of 8 roundings in a row, `nε / (1 − nε)` with ε = 2⁻²⁴.
pub const GAMMA_8: f32 = 4.768_374e-7;

/// A ray as a triangle test takes it.
pub trait TriangleRay: Sized {
    /// Eight rays side by side.
    type Lanes<V: Vector>: TriangleLanes<V, Self>;

    /// Prepares for a ray with a direction that is not zero, given its reciprocals.
    fn new(ray: &Ray, inverse: [f32; 3]) -> Self;

    /// Where the line hits a triangle, ahead of its origin or not; `t` may be anything, also NaN.
    fn intersect(&self, leaf: &LeafTriangle) -> Option<Intersection>;

    /// Bit `lane` set for each triangle of a block that may be hit at `farthest` or nearer: all that are, and few
    /// others.
    fn candidates(&self, block: &TriangleBlock, farthest: f32) -> u32;
}

/// Rays side by side, each with a triangle of its own.
pub trait TriangleLanes<V: Vector, R> {
    /// Of eight rays.
    fn new(rays: [&R; 8]) -> Self;

    /// Which axis of a ray's triangle is its first, second and third; a lane per ray.
    fn axes(&self) -> &[[u32; 8]; 3];

    /// Bit `lane` set for each ray that may hit its triangle at `farthest` or nearer: all that do, and few others.
    /// The corners have their coordinates in the order of [`TriangleLanes::axes`].
    fn candidates(&self, corners: [[V; 3]; 3], farthest: V) -> u32;
}

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
    /// The ray's origin and direction, axes as they are.
    line: [Vec3; 2],
    /// Reciprocals of the direction, axes permuted.
    inverse: [f32; 3],
}

impl TriangleRay for Shear {
    type Lanes<V: Vector> = ShearLanes<V>;

    #[inline(always)]
    fn new(ray: &Ray, inverse: [f32; 3]) -> Self {
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
        let shear = [d[x] / d[z], d[y] / d[z], 1.0 / d[z]];
        Self {
            axes: [x, y, z],
            shear,
            origin: [o[x], o[y], o[z]],
            line: [Vec3::from(o), Vec3::from(d)],
            inverse: [inverse[x], inverse[y], inverse[z]],
        }
    }

    /// Ahead of the ray's origin; its ends are not looked at.
    #[inline(always)]
    fn intersect(&self, leaf: &LeafTriangle) -> Option<Intersection> {
        // Four lanes at a time; what the last one holds and becomes is of no interest.
        let [rx, ry, rz] = self.axes.map(|axis| Vec4::from_array(leaf.rows[axis]));
        let z = rz - Vec4::splat(self.origin[2]);
        let (moved_x, moved_y) = (rx - Vec4::splat(self.origin[0]), ry - Vec4::splat(self.origin[1]));
        let (shear_x, shear_y) = (Vec4::splat(self.shear[0]), Vec4::splat(self.shear[1]));
        let x = moved_x - shear_x * z;
        let y = moved_y - shear_y * z;
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
        // Few triangles come this far, so that what follows costs little.
        let [inverse_x, inverse_y, inverse_z] = self.inverse.map(Vec4::splat);
        let reached = [inverse_x * moved_x, inverse_y * moved_y, inverse_z * z].map(Vec4::truncate);
        let t = leaf.distance(&self.line, reached)?;
        // Quotients of numbers of the same sign: `abs` only removes the sign of a zero, which
        // depends on the order of an edge's corners.
        Some(Intersection { t, u: (b / sum).abs(), v: (c / sum).abs() })
    }

    /// By the arithmetic of [`Shear::intersect`]: the signs of the edge functions, and the depth of the nearest
    /// corner, which no hit is in front of.
    #[inline(always)]
    fn candidates(&self, block: &TriangleBlock, farthest: f32) -> u32 {
        let [rows_x, rows_y, rows_z] = self.axes.map(|axis| &block.rows[axis]);
        let [origin_x, origin_y, origin_z] = self.origin.map(Vec4::splat);
        let [shear_x, shear_y, inverse_z] = [self.shear[0], self.shear[1], self.inverse[2]].map(Vec4::splat);
        let [z_a, z_b, z_c] = [0, 1, 2].map(|corner| rows_z[corner] - origin_z);
        let sheared = |corner: usize, z: Vec4| {
            (rows_x[corner] - origin_x - shear_x * z, rows_y[corner] - origin_y - shear_y * z)
        };
        let [(x_a, y_a), (x_b, y_b), (x_c, y_c)] = [sheared(0, z_a), sheared(1, z_b), sheared(2, z_c)];
        let a = x_c * y_b - y_c * x_b;
        let b = x_a * y_c - y_a * x_c;
        let c = x_b * y_a - y_b * x_a;
        let is_inside = a.min(b).min(c).cmpge(Vec4::ZERO) | a.max(b).max(c).cmple(Vec4::ZERO);
        let has_area = ((a + b) + c).cmpne(Vec4::ZERO);
        let ahead = (inverse_z * z_a).min(inverse_z * z_b).min(inverse_z * z_c);
        (is_inside & has_area & ahead.cmple(Vec4::splat(farthest))).bitmask()
    }
}

/// The transformations of eight rays.
#[derive(Clone, Copy, Debug)]
pub struct ShearLanes<V> {
    axes: [[u32; 8]; 3],
    origin: [V; 3],
    shear: [V; 2],
    inverse_z: V,
}

impl<V: Vector> TriangleLanes<V, Shear> for ShearLanes<V> {
    #[inline(always)]
    fn new(rays: [&Shear; 8]) -> Self {
        let [x, y, z] = [0, 1, 2].map(|axis| rays.map(|ray| ray.origin[axis]));
        let [shear_x, shear_y] = [0, 1].map(|axis| rays.map(|ray| ray.shear[axis]));
        Self {
            axes: [0, 1, 2].map(|axis| rays.map(|ray| ray.axes[axis] as u32)),
            origin: [V::load(&x), V::load(&y), V::load(&z)],
            shear: [V::load(&shear_x), V::load(&shear_y)],
            inverse_z: V::load(&rays.map(|ray| ray.inverse[2])),
        }
    }

    #[inline(always)]
    fn axes(&self) -> &[[u32; 8]; 3] {
        &self.axes
    }

    /// As [`Shear::candidates`].
    #[inline(always)]
    fn candidates(&self, corners: [[V; 3]; 3], farthest: V) -> u32 {
        let [a, b, c] = corners;
        let ([x_a, y_a, z_a], [x_b, y_b, z_b], [x_c, y_c, z_c]) =
            (self.sheared(a), self.sheared(b), self.sheared(c));
        let a = x_c.mul(y_b).sub(y_c.mul(x_b));
        let b = x_a.mul(y_c).sub(y_a.mul(x_c));
        let c = x_b.mul(y_a).sub(y_b.mul(x_a));
        let zero = V::splat(0.0);
        let is_inside = zero.le(a.min(b).min(c)) | a.max(b).max(c).le(zero);
        let sum = a.add(b).add(c);
        let has_no_area = sum.le(zero) & zero.le(sum);
        let ahead = self.inverse_z.mul(z_a).min(self.inverse_z.mul(z_b)).min(self.inverse_z.mul(z_c));
        is_inside & !has_no_area & ahead.le(farthest)
    }
}

impl<V: Vector> ShearLanes<V> {
    /// A corner beside the ray, and how far along its third axis.
    #[inline(always)]
    fn sheared(&self, [x, y, z]: [V; 3]) -> [V; 3] {
        let z = z.sub(self.origin[2]);
        let x = x.sub(self.origin[0]).sub(self.shear[0].mul(z));
        let y = y.sub(self.origin[1]).sub(self.shear[1].mul(z));
        [x, y, z]
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

    /// That coordinate of its corners, and something else.
    #[inline(always)]
    pub(super) fn row(&self, axis: usize) -> &[f32; 4] {
        &self.rows[axis]
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

    /// Distance along a line to the triangle's plane; `None` if that is not to be believed. `reached` says where
    /// the line comes to the corners' x, y and z.
    #[inline(always)]
    fn distance(&self, [origin, direction]: &[Vec3; 2], reached: [Vec3; 3]) -> Option<f32> {
        let corner = |at: usize| Vec3::from(self.rows.map(|row| row[at]));
        let (p, q, r) = (corner(0), corner(1), corner(2));
        let squared = |v: Vec3| dot3(v, v);
        // The corner opposite the longest edge, and the two others.
        let [across_p, across_q, across_r] = [squared(r - q), squared(p - r), squared(q - p)];
        let (base, next, last) = if across_p >= across_q && across_p >= across_r {
            (p, q, r)
        } else if across_q >= across_r {
            (q, r, p)
        } else {
            (r, p, q)
        };
        let (a, b, to_base) = (next - base, last - base, base - *origin);
        let normal = cross3(a, b);
        let (height, approach) = (dot3(normal, to_base), dot3(normal, *direction));
        let (a, b) = (a.abs(), b.abs());
        let sizes = Vec3::new(a.y * b.z + a.z * b.y, a.z * b.x + a.x * b.z, a.x * b.y + a.y * b.x);
        let is_certain = height.abs() > GAMMA_8 * dot3(sizes, to_base.abs())
            && approach.abs() > GAMMA_8 * dot3(sizes, direction.abs());
        let [x, y, z] = reached;
        let ahead = z.min_element();
        let nearest = x.min_element().max(y.min_element()).max(ahead);
        let farthest = z.max_element();
        let quotient = height / approach;
        let is_ahead = if is_certain { quotient > 0.0 } else { ahead > 0.0 && approach != 0.0 };
        let t = if quotient < farthest { quotient } else { farthest };
        let t = if t > nearest { t } else { nearest };
        (is_ahead && t >= 0.0).then_some(t)
    }
}

/// One to four triangles side by side; 160 bytes.
#[repr(C, align(32))]
#[derive(Clone, Copy, Debug)]
pub struct TriangleBlock {
    /// Per axis and corner that coordinate of all triangles; zeros where there is none.
    rows: [[Vec4; 3]; 3],
    /// Indices in the scene; [`Hit::NONE`] where there is none.
    triangles: [u32; 4],
}

impl TriangleBlock {
    /// How many triangles it has room for.
    pub const TRIANGLES: usize = 4;

    /// None.
    pub const EMPTY: Self = Self { rows: [[Vec4::ZERO; 3]; 3], triangles: [Hit::NONE; 4] };

    /// From one to four.
    pub fn new(leaves: &[LeafTriangle]) -> Self {
        let mut block = Self::EMPTY;
        for (lane, leaf) in leaves.iter().enumerate() {
            for (rows, row) in block.rows.iter_mut().zip(&leaf.rows) {
                rows.iter_mut().zip(row).for_each(|(rows, &value)| rows[lane] = value);
            }
            block.triangles[lane] = leaf.triangle();
        }
        block
    }

    /// How many there are.
    pub fn count(&self) -> u32 {
        self.triangles.iter().take_while(|&&triangle| triangle != Hit::NONE).count() as u32
    }

    /// One of them, 0 to 3, with its mask.
    #[inline(always)]
    pub fn triangle(&self, lane: usize, masks: &Masks) -> LeafTriangle {
        let row = |axis: usize, extra: u32| {
            let [a, b, c] = self.rows[axis].map(|row| row.to_array()[lane]);
            [a, b, c, f32::from_bits(extra)]
        };
        let triangle = self.triangles[lane];
        LeafTriangle { rows: [row(0, triangle), row(1, masks.number(triangle)), row(2, 0)] }
    }
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
