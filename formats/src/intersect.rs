//! How a ray meets boxes and triangles, bit for bit: what hits and work mean.
//!
//! Triangles: the watertight test of Woop, Benthin and Wald 2013.
//!
//! The ray is sheared and scaled so that it runs along +z from the origin; a triangle is hit if
//! the origin lies in its projection. Both triangles at an edge see the same two sheared corners
//! and compute the same edge function up to its sign, so no ray passes between them: both products of
//! `a·b − c·d` are rounded, on GPUs that would contract it, too (`recorder::device::rounding`).
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
//!
//! What this costs: the plane of an obtuse sliver whose longest edge is 2·10^6 times its height or more is always
//! hidden by rounding, and a ray that starts beside one, so that a corner lies behind it, may pass through
//! (docs/measurements/trust.md).

use glam::{BVec4A, Mat4, Vec4, Vec4Swizzles};

use crate::ray::Ray;

/// Bound of the relative error of 8 roundings in a row, `nε / (1 − nε)` with ε = 2⁻²⁴.
pub const GAMMA_8: f32 = 4.768_374e-7;

/// Factor on far planes and on the nearest hit: 1 + 2^-19, which is 32 roundings. Box and triangle
/// tests add up to about 20 where division is exact, 28 where a GPU divides to 2.5 ulp.
pub const PADDING: f32 = 1.0 + 1.0 / (1 << 19) as f32;

/// A product of three coordinates whose sign no underflow of its parts can have turned, with coordinates below 2^40.
const LEAST_SIGNED: f32 = 1.0 / (1u128 << 100) as f32;

/// Largest reciprocal of a direction: 2^80.
pub const RECIPROCAL_LIMIT: f32 = (1u128 << 80) as f32;

/// The reciprocal of a component of a direction, as box tests use it.
pub fn reciprocal(direction: f32) -> f32 {
    let quotient = 1.0 / direction;
    if direction.abs() > 1.0 / RECIPROCAL_LIMIT { quotient } else { RECIPROCAL_LIMIT.copysign(direction) }
}

/// The farthest `t` that counts: `t_max`, but finite.
pub fn farthest(ray: &Ray) -> f32 {
    ray.t_max.min(f32::MAX)
}

/// The coordinates of a triangle's corners, a row per axis; what stands in the fourth column does not matter.
pub type Rows = [[f32; 4]; 3];

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

/// A ray's transformation: which axes are sheared, and by how much.
#[derive(Clone, Copy, Debug)]
pub struct Shear {
    /// Axes x, y, z after permutation; z is the one with the largest component of the direction,
    /// x and y are swapped where that is negative, so that windings are preserved.
    pub axes: [usize; 3],
    /// `d_x/d_z`, `d_y/d_z` with permuted axes.
    pub shear: [f32; 2],
    /// The ray's origin, axes permuted.
    pub origin: [f32; 3],
    /// The reciprocal of the direction's largest component.
    pub inverse_z: f32,
    /// The ray's origin, direction and reciprocals of that, axes as they are.
    line: [Vec4; 3],
}

impl Shear {
    /// Prepares for a ray with a direction that is not zero, given its reciprocals.
    #[inline(always)]
    pub fn new(ray: &Ray, inverse: [f32; 3]) -> Self {
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
        Self {
            axes: [x, y, z],
            shear: [d[x] / d[z], d[y] / d[z]],
            origin: [o[x], o[y], o[z]],
            inverse_z: inverse[z],
            line: [o, d, inverse].map(|[x, y, z]| Vec4::new(x, y, z, 0.0)),
        }
    }

    /// Where the line hits a triangle ahead of the ray's origin; the ray's ends are not looked at.
    #[inline(always)]
    pub fn meet(&self, rows: &Rows) -> Option<Intersection> {
        let edges = self.edges(rows);
        // What overflowed is on no side, and so outside.
        let have_side = |mask: BVec4A| mask.bitmask() & 0b111 == 0b111;
        let is_inside = have_side(edges.cmpge(Vec4::ZERO)) || have_side(edges.cmple(Vec4::ZERO));
        if !is_inside || sum(edges) == 0.0 {
            return None;
        }
        // Few triangles come this far, so that what follows costs little.
        let t = self.reach(rows)?;
        let [u, v] = weights(edges);
        Some(Intersection { t, u, v })
    }

    /// The distance alone, to a triangle in whose projection the origin is known to lie.
    #[inline(always)]
    pub fn reach(&self, rows: &Rows) -> Option<f32> {
        distance(rows, &self.line, self.axes[2])
    }

    /// The weights of the second and third corner of a triangle that is hit.
    #[inline(always)]
    pub fn weights(&self, rows: &Rows) -> [f32; 2] {
        weights(self.edges(rows))
    }

    /// Bit `lane` set for each of four triangles whose plane the ray surely leaves behind: [`Shear::meet`] finds none of
    /// them that has a corner at the origin's depth or behind. Given are, per axis and corner, the coordinates of all
    /// four.
    ///
    /// Beyond the bounds that `meet` has, too, the signs of a plane's height and approach are those without rounding,
    /// whichever corner they are taken from.
    #[inline(always)]
    pub fn leaves_behind(&self, corners: &[[Vec4; 3]; 3]) -> u32 {
        let [origin, direction, _] = self.line.map(|line| line.to_array());
        let a = corners.map(|[base, next, _]| next - base);
        let b = corners.map(|[base, _, last]| last - base);
        let to_base = [0, 1, 2].map(|axis| corners[axis][0] - Vec4::splat(origin[axis]));
        let along = [0, 1, 2].map(|axis| Vec4::splat(direction[axis]));
        let products = [(1, 2), (2, 0), (0, 1)].map(|(y, z)| [a[y] * b[z], a[z] * b[y]]);
        let normal = products.map(|[plus, minus]| plus - minus);
        let sizes = products.map(|[plus, minus]| plus.abs() + minus.abs());
        let dot = |a: [Vec4; 3], b: [Vec4; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let sign = |of: [Vec4; 3]| {
            let (value, size) = (dot(normal, of), dot(sizes, of.map(Vec4::abs)));
            let bound = (GAMMA_8 * size).max(Vec4::splat(LEAST_SIGNED));
            (value.is_negative_bitmask(), value.abs().cmpgt(bound).bitmask())
        };
        let (height, is_height_certain) = sign(to_base);
        let (approach, is_approach_certain) = sign(along);
        (height ^ approach) & is_height_certain & is_approach_certain
    }

    /// The corners as seen from the ray's origin, axes permuted. Four lanes at a time; what the last one holds and
    /// becomes is of no interest, here and below.
    #[inline(always)]
    fn moved(&self, rows: &Rows) -> [Vec4; 3] {
        [0, 1, 2].map(|axis| Vec4::from_array(rows[self.axes[axis]]) - Vec4::splat(self.origin[axis]))
    }

    /// For each corner the edge function of the two others.
    #[inline(always)]
    fn edges(&self, rows: &Rows) -> Vec4 {
        let [moved_x, moved_y, z] = self.moved(rows);
        let x = moved_x - Vec4::splat(self.shear[0]) * z;
        let y = moved_y - Vec4::splat(self.shear[1]) * z;
        x.zxyw() * y.yzxw() - y.zxyw() * x.yzxw()
    }
}

fn sum(edges: Vec4) -> f32 {
    (edges.x + edges.y) + edges.z
}

/// Quotients of numbers of the same sign: `abs` only removes the sign of a zero, which depends on the order of an
/// edge's corners.
#[inline(always)]
fn weights(edges: Vec4) -> [f32; 2] {
    let sum = sum(edges);
    [(edges.y / sum).abs(), (edges.z / sum).abs()]
}

/// Distance along a line, given with its reciprocals and the axis that it runs along most, to the triangle's plane;
/// `None` if that is not to be believed.
#[inline(always)]
fn distance(rows: &Rows, &[origin, direction, inverse]: &[Vec4; 3], axis: usize) -> Option<f32> {
    let [x, y, z] = rows.map(Vec4::from_array);
    // Of the edge across from each corner.
    let [to_x, to_y, to_z] = [x, y, z].map(|row| row.zxyw() - row.yzxw());
    let [across_p, across_q, across_r, _] = (to_x * to_x + to_y * to_y + to_z * to_z).to_array();
    let [p, q, r, _] = transposed([x, y, z, Vec4::ZERO]);
    // The corner opposite the longest edge, and the two others.
    let (base, next, last) = if across_p >= across_q && across_p >= across_r {
        (p, q, r)
    } else if across_q >= across_r {
        (q, r, p)
    } else {
        (r, p, q)
    };
    let (a, b, to_base) = (next - base, last - base, base - origin);
    // The normal of the plane is their difference.
    let (plus, minus) = (a.yzxw() * b.zxyw(), a.zxyw() * b.yzxw());
    let (normal, sizes) = (plus - minus, plus.abs() + minus.abs());
    let products = [normal * to_base, normal * direction, sizes * to_base.abs(), sizes * direction.abs()];
    let [x, y, z, _] = transposed(products);
    let [height, approach, height_size, approach_size] = (x + y + z).to_array();
    let is_certain = height.abs() > GAMMA_8 * height_size && approach.abs() > GAMMA_8 * approach_size;
    // Where the line comes to the corners' x, y and z.
    let [p, q, r] = [p, q, r].map(|corner| inverse * (corner - origin));
    let (first, last) = (p.min(q.min(r)), p.max(q.max(r)));
    let (ahead, farthest) = (first.to_array()[axis], last.to_array()[axis]);
    let nearest = first.x.max(first.y).max(first.z);
    let quotient = height / approach;
    let is_ahead = if is_certain { quotient > 0.0 } else { ahead > 0.0 && approach != 0.0 };
    let t = if quotient < farthest { quotient } else { farthest };
    let t = if t > nearest { t } else { nearest };
    (is_ahead && t >= 0.0).then_some(t)
}

#[inline(always)]
fn transposed([x, y, z, w]: [Vec4; 4]) -> [Vec4; 4] {
    let Mat4 { x_axis, y_axis, z_axis, w_axis } = Mat4::from_cols(x, y, z, w).transpose();
    [x_axis, y_axis, z_axis, w_axis]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Nothing says on which side of an edge a ray runs whose products overflow.
    #[test]
    fn what_overflows_is_not_hit() {
        let rows = [[0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0; 4]];
        let meets = |far: f32| {
            let origin = [-1.235_644_2 * far, -1.235_644_2 * far, 1.235_644_2 * far];
            let direction = [0.577_350_85, 0.577_350_1, -0.577_349_84];
            let ray = Ray { origin, t_min: 0.0, direction, t_max: f32::INFINITY };
            Shear::new(&ray, direction.map(reciprocal)).meet(&rows).is_some()
        };
        assert_eq!([1e-2, 1e18, 1e25].map(meets), [true, false, false]);
    }
}
