//! The surface at a hit: where it is, how it faces, what colour it has, where rays leave it.

use glam::Vec3;

use super::tables::ShadeTables;
use crate::stages::shared::MaterialData;
use crate::stages::vector::{cross3, dot3, normalize3};

/// How far a ray starts off its surface, in parts of the point's largest coordinate: 8 ulps, since the
/// point itself is rounded.
pub const OFFSET_OF_POINT: f32 = 1.0 / 1_048_576.0;
/// The same in parts of the triangle's largest extent, with which the error of the triangle test grows.
pub const OFFSET_OF_TRIANGLE: f32 = 1.0 / 262_144.0;

/// The corners of a triangle of the scene.
#[inline(always)]
pub fn triangle_corners(tables: &ShadeTables, triangle: u32) -> [Vec3; 3] {
    let [a, b, c, _] = tables.triangles[triangle as usize];
    [a, b, c].map(|index| Vec3::from(tables.positions[index as usize]))
}

/// A point on the side of `normal` from which the triangle test cannot find the triangle again.
///
/// Offsetting each coordinate by its own ulps (Wächter & Binder, Ray Tracing Gems 2019) is not enough: a
/// floor at a height of nearly 0 is a large triangle whose other coordinates decide how much the test is
/// off. So the step is proportional to the largest coordinate of the point and to the extent of the
/// triangle, `pq` and `pr` being two of its edges, as error bounds of the test are (Pharr, Jakob &
/// Humphreys, Physically Based Rendering, §6.8.3).
#[inline(always)]
pub fn offset_origin(point: Vec3, normal: Vec3, pq: Vec3, pr: Vec3) -> Vec3 {
    let largest = |v: Vec3| v.x.abs().max(v.y.abs()).max(v.z.abs());
    let step = largest(point) * OFFSET_OF_POINT + largest(pq).max(largest(pr)) * OFFSET_OF_TRIANGLE;
    point + normal * step
}

/// A hit surface, seen from the side that the ray came from.
#[derive(Clone, Copy, Debug)]
pub struct HitSurface {
    /// The hit point, from the triangle's corners (more exact than along the ray).
    pub point: Vec3,
    /// Where rays leave it.
    pub origin: Vec3,
    /// Unit normal of the triangle.
    pub geometric_normal: Vec3,
    /// Unit normal to shade with.
    pub shading_normal: Vec3,
    /// What it is made of.
    pub material: MaterialData,
    /// Linear RGB.
    pub base_color: Vec3,
}

/// The surface that a ray along `direction` hit.
#[inline(always)]
pub fn hit_surface<const TEXTURES: bool, const NORMALS: bool>(
    tables: &ShadeTables,
    direction: Vec3,
    triangle: u32,
    u: f32,
    v: f32,
) -> HitSurface {
    let [a, b, c, material] = tables.triangles[triangle as usize];
    let material = tables.materials[material as usize];
    let [p, q, r] = triangle_corners(tables, triangle);
    let (pq, pr) = (q - p, r - p);
    let mut geometric_normal = normalize3(cross3(pq, pr));
    if dot3(geometric_normal, direction) > 0.0 {
        geometric_normal = -geometric_normal;
    }
    let mut shading_normal = geometric_normal;
    if NORMALS {
        let [na, nb, nc] = [a, b, c].map(|index| Vec3::from(tables.normals[index as usize]));
        shading_normal = interpolated_normal([na, nb, nc], u, v, geometric_normal, direction);
    }
    let mut base_color = Vec3::from(material.base_color);
    if TEXTURES && material.texture_width != 0 {
        let [ta, tb, tc] = [a, b, c].map(|index| tables.uvs[index as usize]);
        let at = |axis: usize| ta[axis] + (tb[axis] - ta[axis]) * u + (tc[axis] - ta[axis]) * v;
        base_color *= texture_color(tables, &material, at(0), at(1));
    }
    let point = p + pq * u + pr * v;
    let origin = offset_origin(point, geometric_normal, pq, pr);
    HitSurface { point, origin, geometric_normal, shading_normal, material, base_color }
}

/// Falls back to the geometric normal where vertices have none or the ray would come from behind.
#[inline(always)]
fn interpolated_normal(corners: [Vec3; 3], u: f32, v: f32, geometric_normal: Vec3, direction: Vec3) -> Vec3 {
    let [a, b, c] = corners;
    let sum = a * (1.0 - u - v) + b * u + c * v;
    let length2 = dot3(sum, sum);
    if length2 < 1e-12 {
        return geometric_normal;
    }
    let mut normal = sum * (1.0 / length2.sqrt());
    if dot3(normal, geometric_normal) < 0.0 {
        normal = -normal;
    }
    if dot3(normal, direction) > -1e-3 { geometric_normal } else { normal }
}

/// Linear RGB of a material's texture at (u, v), bilinear, repeating.
#[inline(always)]
fn texture_color(tables: &ShadeTables, material: &MaterialData, u: f32, v: f32) -> Vec3 {
    let (width, height) = (material.texture_width as i32, material.texture_height as i32);
    let x = (u - u.floor()) * width as f32 - 0.5;
    let y = (v - v.floor()) * height as f32 - 0.5;
    let (left, top) = (x.floor(), y.floor());
    let (fx, fy) = (x - left, y - top);
    let texel = |x: i32, y: i32| {
        let column = ((x + width) % width).clamp(0, width - 1);
        let row = ((y + height) % height).clamp(0, height - 1);
        let rgba = tables.texels[(material.texture_first as i32 + row * width + column) as usize];
        let linear = |shift: u32| f32::from_bits(tables.texels[(rgba >> shift & 255) as usize]);
        Vec3::new(linear(0), linear(8), linear(16))
    };
    let (left, top) = (left as i32, top as i32);
    let above = texel(left, top) * (1.0 - fx) + texel(left + 1, top) * fx;
    let below = texel(left, top + 1) * (1.0 - fx) + texel(left + 1, top + 1) * fx;
    above * (1.0 - fy) + below * fy
}

#[cfg(test)]
mod tests {
    use formats::intersect::{Shear, reciprocal};
    use formats::ray::Ray;

    use super::*;
    use crate::stages::trace::triangle::{LeafTriangle, TriangleRay};

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
