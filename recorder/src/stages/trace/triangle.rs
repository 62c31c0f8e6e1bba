//! Triangles as kernels hold them, and the watertight test of [`formats::intersect`] by itself and side by side.

use formats::intersect::{Intersection, Rows, Shear};
use formats::ray::{Hit, Ray};
use glam::{Vec3, Vec4};

use super::cpu_vector::Vector;

/// A ray as a triangle test takes it.
pub trait TriangleRay: Sized {
    /// Prepares for a ray with a direction that is not zero, given its reciprocals.
    fn new(ray: &Ray, inverse: [f32; 3]) -> Self;

    /// Where the line hits a triangle, ahead of its origin or not; `t` may be anything, also NaN.
    fn intersect(&self, leaf: &LeafTriangle) -> Option<Intersection>;

    /// The same for a triangle of which [`TriangleRay::candidates`] has a bit, if the distance `counts`. Without
    /// `WEIGHTS` those may be anything.
    fn confirm<const WEIGHTS: bool>(
        &self,
        leaf: &LeafTriangle,
        counts: impl FnOnce(f32) -> bool,
    ) -> Option<Intersection>;

    /// Bit `lane` set for each triangle of a block that may be hit at `farthest` or nearer: all that are, and few
    /// others.
    fn candidates(&self, block: &TriangleBlock, farthest: f32) -> u32;
}

impl TriangleRay for Shear {
    #[inline(always)]
    fn new(ray: &Ray, inverse: [f32; 3]) -> Self {
        Shear::new(ray, inverse)
    }

    #[inline(always)]
    fn intersect(&self, leaf: &LeafTriangle) -> Option<Intersection> {
        self.meet(&leaf.rows)
    }

    #[inline(always)]
    fn confirm<const WEIGHTS: bool>(
        &self,
        leaf: &LeafTriangle,
        counts: impl FnOnce(f32) -> bool,
    ) -> Option<Intersection> {
        let t = self.reach(&leaf.rows).filter(|&t| counts(t))?;
        let [u, v] = if WEIGHTS { self.weights(&leaf.rows) } else { [0.0; 2] };
        Some(Intersection { t, u, v })
    }

    /// By the arithmetic of [`Shear::meet`]: the signs of the edge functions, and the depth of the nearest
    /// corner, which no hit is in front of. Where that corner is behind the origin, as one is of the triangle that a
    /// ray leaves, the plane is looked at, too.
    #[inline(always)]
    fn candidates(&self, block: &TriangleBlock, farthest: f32) -> u32 {
        let [rows_x, rows_y, rows_z] = self.axes.map(|axis| &block.rows[axis]);
        let [origin_x, origin_y, origin_z] = self.origin.map(Vec4::splat);
        let [shear_x, shear_y, inverse_z] = [self.shear[0], self.shear[1], self.inverse_z].map(Vec4::splat);
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
        let may_be_hit = (is_inside & has_area & ahead.cmple(Vec4::splat(farthest))).bitmask();
        let is_around = may_be_hit & ahead.is_negative_bitmask();
        if is_around == 0 {
            return may_be_hit;
        }
        may_be_hit & !(is_around & self.leaves_behind(&block.rows))
    }
}

/// The transformations of eight rays side by side, each with a triangle of its own.
#[derive(Clone, Copy, Debug)]
pub(super) struct ShearLanes<V> {
    axes: [[u32; 8]; 3],
    origin: [V; 3],
    shear: [V; 2],
    inverse_z: V,
}

impl<V: Vector> ShearLanes<V> {
    /// Of eight rays.
    #[inline(always)]
    pub(super) fn new(rays: [&Shear; 8]) -> Self {
        let [x, y, z] = [0, 1, 2].map(|axis| rays.map(|ray| ray.origin[axis]));
        let [shear_x, shear_y] = [0, 1].map(|axis| rays.map(|ray| ray.shear[axis]));
        Self {
            axes: [0, 1, 2].map(|axis| rays.map(|ray| ray.axes[axis] as u32)),
            origin: [V::load(&x), V::load(&y), V::load(&z)],
            shear: [V::load(&shear_x), V::load(&shear_y)],
            inverse_z: V::load(&rays.map(|ray| ray.inverse_z)),
        }
    }

    /// Which axis of a ray's triangle is its first, second and third; a lane per ray.
    #[inline(always)]
    pub(super) fn axes(&self) -> &[[u32; 8]; 3] {
        &self.axes
    }

    /// Bit `lane` set for each ray that may hit its triangle at `farthest` or nearer: all that do, and few others,
    /// as [`Shear::candidates`]. The corners have their coordinates in the order of [`ShearLanes::axes`].
    #[inline(always)]
    pub(super) fn candidates(&self, corners: [[V; 3]; 3], farthest: V) -> u32 {
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
    rows: Rows,
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
    pub const TRIANGLES: u32 = 4;

    /// None.
    pub const EMPTY: Self = Self { rows: [[Vec4::ZERO; 3]; 3], triangles: [Hit::NONE; 4] };

    /// From one to four.
    pub fn new(leaves: impl IntoIterator<Item = LeafTriangle>) -> Self {
        let mut block = Self::EMPTY;
        for (lane, leaf) in leaves.into_iter().enumerate() {
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

    /// One of them, 0 to 3, with the number of its mask, given by its index.
    #[inline(always)]
    pub fn triangle(&self, lane: usize, mask: impl Fn(u32) -> u32) -> LeafTriangle {
        // Numbers are read where they lie and rows made in registers: a copy of the block that is read one by one,
        // or a row that is written so and read as a whole, would have to reach the cache first.
        let value = |row: &Vec4| AsRef::<[f32; 4]>::as_ref(row)[lane];
        let row = |axis: usize, extra: u32| {
            let [a, b, c] = &self.rows[axis];
            Vec4::new(value(a), value(b), value(c), f32::from_bits(extra)).to_array()
        };
        let triangle = self.triangles[lane];
        LeafTriangle { rows: [row(0, triangle), row(1, mask(triangle)), row(2, 0)] }
    }
}
