//! Bounds of triangles, padded so that box tests in f32 never lose a hit.

use rayon::prelude::*;

use super::BvhError;
use crate::Scene;
use crate::bounds::Bounds;

/// Largest absolute coordinate, world units (2^40).
///
/// The kernels clamp reciprocals of directions at 2^80. With coordinates up to 2^40 and origins up to
/// 2^60 a product of a box test may overflow to infinity, but is never 0 · ∞: no NaN reaches a
/// comparison.
pub const COORDINATE_LIMIT: f32 = 1_099_511_627_776.0;

/// Smallest extent of a scene along its longest axis, world units (2^-76).
///
/// Whether a ray hits a triangle is told by products of two of its extents, which in f32 are 0 where a scene is
/// hardly smaller than this.
pub const EXTENT_LIMIT: f32 = 1.0 / (1u128 << 76) as f32;

/// Most triangles in a scene: leaf slots fit into 28 bits, so that a kernel's stack entry has four
/// to spare for a leaf's count.
pub const TRIANGLE_LIMIT: usize = (1 << 28) - 1;

/// Padding as a part of a triangle's largest extent.
///
/// A watertight test evaluated in f32 accepts rays that pass up to a few 2^-24 of the triangle's
/// extent outside of it, and its `t` is off by as much; a box must hold those points too, or a
/// hierarchy would lose hits that testing every triangle finds. (Errors that grow with the
/// distance to the ray's origin are covered by the kernels, which scale the far planes: Ize 2013,
/// "Robust BVH Ray Traversal".)
const PAD_OF_EXTENT: f64 = 1.0 / (1 << 20) as f64;

/// Padding as a part of the scene's magnitude (2^-60).
///
/// Keeps flat boxes open: a ray with direction 0 along an axis is traced as if it moved by 2^-80,
/// so it stays inside for lengths up to 2^20 times the scene's magnitude.
const PAD_OF_MAGNITUDE: f64 = 1.0 / (1u64 << 60) as f64;

/// Boxes of all triangles of a scene.
pub(super) struct Boxes {
    /// Per triangle, padded.
    pub padded: Vec<Bounds>,
    /// Largest absolute coordinate of a vertex that a triangle refers to, at least 2^-40.
    pub magnitude: f64,
}

impl Boxes {
    /// The box around some triangles, padded.
    pub(super) fn around(&self, triangles: &[u32]) -> Bounds {
        let boxes = triangles.iter().map(|&triangle| &self.padded[triangle as usize]);
        boxes.fold(Bounds::EMPTY, |all, one| all.union(one))
    }
}

/// Checks a scene's triangles and finds their boxes.
pub(super) fn padded(scene: &Scene) -> Result<Boxes, BvhError> {
    let count = scene.triangles.len();
    if count == 0 {
        return Err(BvhError::NoTriangles { scene: scene.name.clone() });
    }
    if count > TRIANGLE_LIMIT {
        return Err(BvhError::TooManyTriangles { scene: scene.name.clone(), found: count });
    }
    let is_in_range = |value: f32| value.abs() <= COORDINATE_LIMIT;
    let broken = (0..count)
        .into_par_iter()
        .find_first(|&triangle| !scene.corners(triangle).iter().flatten().all(|&value| is_in_range(value)));
    if let Some(triangle) = broken {
        let corners = scene.corners(triangle);
        let value = corners.iter().flatten().copied().find(|&value| !is_in_range(value));
        return Err(BvhError::Coordinate { triangle, value: value.unwrap_or(f32::NAN) });
    }
    let magnitude = (0..count)
        .into_par_iter()
        .map(|triangle| {
            scene.corners(triangle).iter().flatten().fold(0.0f32, |most, value| most.max(value.abs()))
        })
        .reduce(|| 0.0, f32::max);
    // A floor, so that padding never becomes a denormal number that a GPU would flush to zero.
    let magnitude = f64::from(magnitude).max(1.0 / (1u64 << 40) as f64);
    let padded =
        (0..count).into_par_iter().map(|triangle| padded_box(&scene.corners(triangle), magnitude)).collect();
    Ok(Boxes { padded, magnitude })
}

/// Bounds of a triangle, moved outward by the padding and then to the next f32 beyond.
fn padded_box(corners: &[[f32; 3]; 3], magnitude: f64) -> Bounds {
    let exact = Bounds::of(corners);
    let extent = [0, 1, 2].map(|axis| f64::from(exact.max[axis]) - f64::from(exact.min[axis]));
    let pad = extent.into_iter().fold(0.0, f64::max) * PAD_OF_EXTENT + magnitude * PAD_OF_MAGNITUDE;
    Bounds {
        min: exact.min.map(|value| f32_below(f64::from(value) - pad)),
        max: exact.max.map(|value| f32_above(f64::from(value) + pad)),
    }
}

/// The largest f32 that is less than `value`, which must be well inside the range of f32.
pub(super) fn f32_below(value: f64) -> f32 {
    let nearest = value as f32;
    if f64::from(nearest) < value { nearest } else { nearest.next_down() }
}

/// The smallest f32 that is greater than `value`, which must be well inside the range of f32.
pub(super) fn f32_above(value: f64) -> f32 {
    -f32_below(-value)
}
