//! Holes of alpha masks (FORMAT.md, `masks.npy`): no hit lies in one.

use std::collections::BTreeMap;

use super::Subject;
use crate::manifest::{Place, SceneArray};
use crate::npy::MaterialMask;
use crate::reader::Loaded;

/// How far a texture coordinate may be off by rounding, relative to the larger of it and 1.
const TOLERANCE: f32 = 1e-5;

/// The alpha masks of a scene.
pub(super) struct Holes {
    materials: Loaded<u32>,
    masks: Loaded<MaterialMask>,
    uvs: Option<Loaded<[f32; 2]>>,
    /// Alpha bytes of a texture, row by row, with its width and height.
    textures: BTreeMap<u32, (Loaded<u8>, [usize; 2])>,
}

impl Holes {
    /// Those of the scene; `None` where nothing has a mask, or it was not kept.
    pub(super) fn of(subject: &Subject<'_>) -> Option<Self> {
        let place = |array| Place::Scene(array);
        let masks = subject.array::<MaterialMask>(&place(SceneArray::Masks))?;
        let used =
            masks.iter().map(|mask| mask.texture).filter(|&texture| texture != MaterialMask::NO_TEXTURE);
        let texture = |number: u32| {
            let place = place(SceneArray::Mask(number));
            let alphas = subject.array::<u8>(&place)?;
            let owner = [Some(subject.dump), subject.dump.source()];
            let record = owner.into_iter().flatten().find_map(|dump| dump.record(&place))?;
            let &[height, width] = record.shape.as_slice() else { return None };
            (!alphas.is_empty()).then_some((number, (alphas, [width as usize, height as usize])))
        };
        Some(Self {
            materials: subject.array(&place(SceneArray::Materials))?,
            textures: used.filter_map(texture).collect(),
            uvs: subject.array(&place(SceneArray::Uvs)),
            masks,
        })
    }

    /// Whether the point with the barycentric weights u and v of a triangle is a hole, and its neighbours
    /// within rounding are too. What the arrays do not say is none: other checks find it.
    pub(super) fn is_hole(&self, triangle: u32, corners: [u32; 3], [u, v]: [f32; 2]) -> bool {
        let material = self.materials.get(triangle as usize).and_then(|&at| self.masks.get(at as usize));
        let Some(&MaterialMask { texture, cutoff }) = material else { return false };
        let threshold = (cutoff * 255.0).round();
        if texture == MaterialMask::NO_TEXTURE {
            return 255.0 < threshold;
        }
        let Some((alphas, size)) = self.textures.get(&texture) else { return false };
        let corner = |vertex: u32| self.uvs.as_ref().and_then(|uvs| uvs.get(vertex as usize)).copied();
        let [a, b, c] = corners.map(|vertex| corner(vertex).unwrap_or_default());
        let w = (1.0 - u) - v;
        let at = [0, 1].map(|axis| (w * a[axis] + u * b[axis]) + v * c[axis]);
        let texel = |axis: usize, step: f32| {
            let along = at[axis] + step * TOLERANCE * at[axis].abs().max(1.0);
            (((along - along.floor()) * size[axis] as f32) as usize).min(size[axis] - 1)
        };
        let is_below = |x: f32, y: f32| f32::from(alphas[texel(1, y) * size[0] + texel(0, x)]) < threshold;
        let steps = [0.0, -1.0, 1.0];
        threshold > 0.0 && steps.iter().all(|&y| steps.iter().all(|&x| is_below(x, y)))
    }
}
