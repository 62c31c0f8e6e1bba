//! The surfaces at eight hits: where they are, how they face, what colour they have, where rays leave them.

use std::array::from_fn;

use fearless_simd::prelude::*;
use fearless_simd::{Level, dispatch, f32x8, i32x8, u32x8};
use glam::Vec3;

use super::tables::ShadeTables;
use crate::stages::eight::{LANES, Vec3x8, cross3, dot3, largest, normalize3};
use crate::stages::shared::MaterialData;

/// How far a ray starts off its surface, in parts of the point's largest coordinate: 8 ulps, since the
/// point itself is rounded.
pub const OFFSET_OF_POINT: f32 = 1.0 / 1_048_576.0;
/// The same in parts of the triangle's largest extent, with which the error of the triangle test grows.
pub const OFFSET_OF_TRIANGLE: f32 = 1.0 / 262_144.0;

/// Points on the side of `normal` from which the triangle test cannot find the triangle again.
///
/// Offsetting each coordinate by its own ulps (Wächter & Binder, Ray Tracing Gems 2019) is not enough: a
/// floor at a height of nearly 0 is a large triangle whose other coordinates decide how much the test is
/// off. So the step is proportional to the largest coordinate of the point and to the extent of the
/// triangle, `pq` and `pr` being two of its edges, as error bounds of the test are (Pharr, Jakob &
/// Humphreys, Physically Based Rendering, §6.8.3).
#[inline(always)]
pub(super) fn offset_origins<S: Simd>(
    point: Vec3x8<S>,
    normal: Vec3x8<S>,
    pq: Vec3x8<S>,
    pr: Vec3x8<S>,
) -> Vec3x8<S> {
    let step = largest(point) * OFFSET_OF_POINT + largest(pq).max(largest(pr)) * OFFSET_OF_TRIANGLE;
    point + normal * step
}

/// The point where rays leave one surface.
pub fn offset_origin(point: Vec3, normal: Vec3, pq: Vec3, pr: Vec3) -> Vec3 {
    let [x, y, z] = dispatch!(Level::new(), simd => {
        let [point, normal, pq, pr] = [point, normal, pq, pr].map(|v| Vec3x8::splat(simd, v));
        offset_origins(point, normal, pq, pr).to_arrays()
    });
    Vec3::new(x[0], y[0], z[0])
}

/// Hit surfaces, seen from the side that each ray came from.
#[derive(Clone, Copy, Debug)]
pub struct HitSurface<'a, S: Simd> {
    /// Where rays leave them.
    pub origin: Vec3x8<S>,
    /// Unit normals of the triangles.
    pub geometric_normal: Vec3x8<S>,
    /// Unit normals to shade with.
    pub shading_normal: Vec3x8<S>,
    /// What they are made of.
    pub materials: [&'a MaterialData; LANES],
    /// Linear RGB.
    pub base_color: Vec3x8<S>,
}

/// The surfaces that rays along `direction` hit.
#[inline(always)]
pub fn hit_surface<S: Simd>(
    tables: &ShadeTables,
    direction: Vec3x8<S>,
    triangles: u32x8<S>,
    u: f32x8<S>,
    v: f32x8<S>,
) -> HitSurface<'_, S> {
    let simd = u.token();
    let triangles: [&[u32; 4]; LANES] = from_fn(|lane| &tables.triangles[triangles[lane] as usize]);
    let materials = from_fn(|lane| &tables.materials[triangles[lane][3] as usize]);
    let corner = |corner: usize, of: &[[f32; 3]]| {
        Vec3x8::from_lanes(simd, |lane| of[triangles[lane][corner] as usize])
    };
    let [p, q, r] = [0, 1, 2].map(|at| corner(at, &tables.positions));
    let (pq, pr) = (q - p, r - p);
    let normal = normalize3(cross3(pq, pr));
    let geometric_normal = normal.negated_where(dot3(normal, direction).simd_gt(0.0));
    let mut shading_normal = geometric_normal;
    if !tables.normals.is_empty() {
        let corners = [0, 1, 2].map(|at| corner(at, &tables.normals));
        shading_normal = interpolated_normal(corners, u, v, geometric_normal, direction);
    }
    let mut base_color = Vec3x8::from_lanes(simd, |lane| materials[lane].base_color);
    if materials.iter().any(|material| material.texture_width != 0) {
        let at = |axis: usize| {
            let corner = |corner: usize| {
                f32x8::from_fn(simd, |lane| tables.uvs[triangles[lane][corner] as usize][axis])
            };
            let [a, b, c] = [0, 1, 2].map(corner);
            a + (b - a) * u + (c - a) * v
        };
        base_color = base_color * texture_color(tables, &materials, at(0), at(1));
    }
    let point = p + pq * u + pr * v;
    let origin = offset_origins(point, geometric_normal, pq, pr);
    HitSurface { origin, geometric_normal, shading_normal, materials, base_color }
}

/// Falls back to the geometric normal where vertices have none or the ray would come from behind.
#[inline(always)]
fn interpolated_normal<S: Simd>(
    [a, b, c]: [Vec3x8<S>; 3],
    u: f32x8<S>,
    v: f32x8<S>,
    geometric_normal: Vec3x8<S>,
    direction: Vec3x8<S>,
) -> Vec3x8<S> {
    let sum = a * (1.0 - u - v) + b * u + c * v;
    let length2 = dot3(sum, sum);
    let normal = sum * (1.0 / length2.sqrt());
    let normal = normal.negated_where(dot3(normal, geometric_normal).simd_lt(0.0));
    let is_none = length2.simd_lt(1e-12) | dot3(normal, direction).simd_gt(-1e-3);
    geometric_normal.where_or(is_none, normal)
}

/// Linear RGB of the materials' textures at (u, v), bilinear, repeating; 1 where there is none.
#[inline(always)]
fn texture_color<S: Simd>(
    tables: &ShadeTables,
    materials: &[&MaterialData; LANES],
    u: f32x8<S>,
    v: f32x8<S>,
) -> Vec3x8<S> {
    let simd = u.token();
    let size = |of: fn(&MaterialData) -> u32| i32x8::from_fn(simd, |lane| of(materials[lane]) as i32).max(1);
    let (width, height) = (size(|material| material.texture_width), size(|material| material.texture_height));
    let first = i32x8::from_fn(simd, |lane| materials[lane].texture_first as i32);
    let texture = Texture { texels: &tables.texels, first, width, height };
    let x = (u - u.floor()) * width.to_float::<f32x8<S>>() - 0.5;
    let y = (v - v.floor()) * height.to_float::<f32x8<S>>() - 0.5;
    let (left, top) = (x.floor(), y.floor());
    let (fx, fy) = (x - left, y - top);
    let (left, top): (i32x8<S>, i32x8<S>) = (left.to_int(), top.to_int());
    let above = texture.texel(left, top) * (1.0 - fx) + texture.texel(left + 1, top) * fx;
    let below = texture.texel(left, top + 1) * (1.0 - fx) + texture.texel(left + 1, top + 1) * fx;
    let color = above * (1.0 - fy) + below * fy;
    let is_plain = i32x8::from_fn(simd, |lane| materials[lane].texture_width as i32).simd_eq(0);
    Vec3x8::splat(simd, Vec3::ONE).where_or(is_plain, color)
}

struct Texture<'a, S: Simd> {
    texels: &'a [u32],
    first: i32x8<S>,
    width: i32x8<S>,
    height: i32x8<S>,
}

impl<S: Simd> Texture<'_, S> {
    #[inline(always)]
    fn texel(&self, x: i32x8<S>, y: i32x8<S>) -> Vec3x8<S> {
        let at = self.first + wrapped(y, self.height) * self.width + wrapped(x, self.width);
        let rgba = u32x8::from_fn(x.token(), |lane| self.texels[at[lane] as usize]);
        Vec3x8::new(self.linear(rgba), self.linear(rgba >> 8), self.linear(rgba >> 16))
    }

    /// What the lowest bytes stand for.
    #[inline(always)]
    fn linear(&self, bytes: u32x8<S>) -> f32x8<S> {
        let bytes = bytes & 255;
        f32x8::from_fn(bytes.token(), |lane| f32::from_bits(self.texels[bytes[lane] as usize]))
    }
}

/// Places from one before the first to one after the last, as those of a texture that repeats.
#[inline(always)]
fn wrapped<S: Simd>(at: i32x8<S>, size: i32x8<S>) -> i32x8<S> {
    let at = at.simd_lt(0).select(at + size, at);
    let at = at.simd_ge(size).select(at - size, at);
    at.max(0).min(size - 1)
}

#[cfg(test)]
mod tests {
    use formats::intersect::{Shear, reciprocal};
    use formats::ray::Ray;

    use super::*;
    use crate::stages::trace::triangle::{LeafTriangle, TriangleRay};
    use crate::stages::vector::{cross3, dot3, normalize3};

    /// Whether a ray meets a triangle.
    fn finds(leaf: &LeafTriangle, origin: Vec3, direction: Vec3) -> bool {
        let (origin, direction) = (origin.to_array(), normalize3(direction).to_array());
        let ray = Ray { origin, t_min: 0.0, direction, t_max: f32::INFINITY };
        Shear::new(&ray, direction.map(reciprocal)).intersect(leaf).is_some_and(|at| at.t >= 0.0)
    }

    /// No ray that leaves a triangle finds it again, however far away, large, thin or grazing.
    #[test]
    fn rays_do_not_find_the_triangle_that_they_leave() {
        let mut generator = fastrand::Rng::with_seed(7);
        let mut random = || 2.0 * generator.f32() - 1.0;
        let mut again = 0;
        for round in 0..4000 {
            let scale = |exponent: u32| 10f32.powi(exponent as i32 % 9 - 4);
            let (size, distance) = (scale(round), scale(round / 9));
            let centre = Vec3::new(random(), random(), random()) * distance;
            let mut corner = || centre + Vec3::new(random(), random(), random()) * size;
            let mut corners = [corner(), corner(), corner()];
            if round % 4 == 0 {
                // A floor at a height of almost 0, as in scenes in millimetres.
                corners.iter_mut().for_each(|corner| corner.y *= 1e-6);
            }
            let [p, q, r] = corners;
            let normal = cross3(q - p, r - p);
            // Triangles of a few ulps have no normal to speak of.
            let fine = [p, q, r].map(|v| v.abs().max_element()).into_iter().fold(0.0, f32::max) * 1e-4;
            if normal.length() < fine * (q - p).length().max((r - p).length()) {
                continue;
            }
            let normal = normalize3(normal);
            let leaf = LeafTriangle::new(&corners.map(|corner| corner.to_array()), 0, 0);
            for _ in 0..50 {
                let (a, b) = (random().abs().sqrt(), random().abs());
                let point = p + (q - p) * (a * (1.0 - b)) + (r - p) * (a * b);
                let origin = offset_origin(point, normal, q - p, r - p);
                let mut direction = Vec3::new(random(), random(), random());
                let up = dot3(direction, normal);
                // Mostly grazing.
                direction += normal * (up.abs() * random().abs().powi(4) - up);
                again += usize::from(finds(&leaf, origin, direction));
            }
        }
        assert_eq!(again, 0);
    }

    /// Nor does it find a large triangle in the same plane: seen in a room in millimetres, where a ceiling
    /// of small and large triangles shadowed itself.
    #[test]
    fn rays_do_not_find_a_larger_triangle_in_the_plane_that_they_leave() {
        let mut generator = fastrand::Rng::with_seed(11);
        let mut random = || 2.0 * generator.f32() - 1.0;
        let mut again = 0;
        for height in [0.0f32, 6.5e-4, 2126.5] {
            for _ in 0..500 {
                let at = |x: f32, z: f32| Vec3::new(1e4 + 5e3 * x, height, -6e3 + 5e3 * z);
                // Long and thin, as the rim of a ceiling with holes for lamps.
                let (p, q) = (at(random(), random()), at(random(), random()));
                let r = p.lerp(q, random().abs()) + Vec3::new(q.z - p.z, 0.0, p.x - q.x) * (random() * 0.01);
                let leaf = LeafTriangle::new(&[p, q, r].map(|corner| corner.to_array()), 0, 0);
                let (a, b) = (random().abs().sqrt(), random().abs());
                let point = p + (q - p) * (a * (1.0 - b)) + (r - p) * (a * b);
                let origin = offset_origin(point, Vec3::Y, Vec3::X * 0.7, Vec3::Z * 0.9);
                let direction = Vec3::new(random(), random().abs().powi(3), random());
                again += usize::from(finds(&leaf, origin, direction));
            }
        }
        assert_eq!(again, 0);
    }
}
