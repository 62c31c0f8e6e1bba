//! The surface at a hit: where it is, how it faces, what colour it has, where rays leave it.

use glam::Vec3;

use super::tables::{NO_TEXTURE, ShadeTables};
use crate::stages::shared::MaterialData;
use crate::stages::vector::{cross3, dot3, normalize3};

/// Coordinates below this are offset by a fixed step instead of by ulps (Wächter & Binder).
pub const OFFSET_ORIGIN: f32 = 1.0 / 32.0;
/// That fixed step.
pub const OFFSET_STEP: f32 = 1.0 / 65_536.0;
/// Ulps of the offset along a unit normal.
pub const OFFSET_ULPS: f32 = 256.0;

/// The corners of a triangle of the scene.
pub fn triangle_corners(tables: &ShadeTables, triangle: u32) -> [Vec3; 3] {
    let [a, b, c, _] = tables.triangles[triangle as usize];
    [a, b, c].map(|index| Vec3::from(tables.positions[index as usize]))
}

/// A point on the side of `normal` that no rounding puts back into the surface (Wächter & Binder,
/// "A Fast and Robust Method for Avoiding Self-Intersection", Ray Tracing Gems, 2019).
pub fn offset_origin(point: Vec3, normal: Vec3) -> Vec3 {
    let along = |p: f32, n: f32| {
        if p.abs() < OFFSET_ORIGIN {
            return p + OFFSET_STEP * n;
        }
        let ulps = (OFFSET_ULPS * n) as i32;
        f32::from_bits((p.to_bits() as i32).wrapping_add(if p < 0.0 { -ulps } else { ulps }) as u32)
    };
    Vec3::new(along(point.x, normal.x), along(point.y, normal.y), along(point.z, normal.z))
}

/// A hit surface, seen from the side that the ray came from.
#[derive(Clone, Copy, Debug)]
pub struct HitSurface {
    /// The hit point, from the triangle's corners (more exact than along the ray).
    pub point: Vec3,
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
    if TEXTURES && material.texture != NO_TEXTURE {
        let [ta, tb, tc] = [a, b, c].map(|index| tables.uvs[index as usize]);
        let at = |axis: usize| ta[axis] + (tb[axis] - ta[axis]) * u + (tc[axis] - ta[axis]) * v;
        base_color *= texture_color(tables, material.texture, at(0), at(1));
    }
    HitSurface { point: p + pq * u + pr * v, geometric_normal, shading_normal, material, base_color }
}

/// Falls back to the geometric normal where vertices have none or the ray would come from behind.
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

/// Linear RGB of a texture at (u, v), bilinear, repeating.
fn texture_color(tables: &ShadeTables, texture: u32, u: f32, v: f32) -> Vec3 {
    let data = &tables.textures[texture as usize];
    let (width, height) = (data.width as i32, data.height as i32);
    let x = (u - u.floor()) * data.width as f32 - 0.5;
    let y = (v - v.floor()) * data.height as f32 - 0.5;
    let (left, top) = (x.floor(), y.floor());
    let (fx, fy) = (x - left, y - top);
    let texel = |x: i32, y: i32| {
        let column = ((x + width) % width).clamp(0, width - 1);
        let row = ((y + height) % height).clamp(0, height - 1);
        let rgba = tables.texels[(data.first as i32 + row * width + column) as usize];
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
    use super::*;

    #[test]
    fn offsets_leave_the_surface_on_the_right_side_at_any_scale() {
        for scale in [1e-4f32, 1.0, 1e3, 1e6] {
            for point in [Vec3::new(0.3, -0.7, 0.01), Vec3::new(-5.0, 2.0, 900.0)].map(|p| p * scale) {
                for normal in [Vec3::X, -Vec3::Y, Vec3::new(0.6, 0.0, -0.8)] {
                    let moved = offset_origin(point, normal) - point;
                    assert!(dot3(moved, normal) > 0.0, "{point} {normal}");
                    assert!(moved.length() < 1e-3 * scale.max(1.0) * 1e2, "{point} {normal} {moved}");
                }
            }
        }
    }
}
