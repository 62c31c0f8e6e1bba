//! Holes of alpha masks (FORMAT.md, `masks.npy`): no hit lies in one.

use std::collections::BTreeMap;

use crate::manifest::{Place, SceneArray};
use crate::npy::MaterialMask;
use crate::reader::{Dump, Loaded, ReadError};

/// How far a texture coordinate may be off by rounding, relative to the larger of it and 1.
const TOLERANCE: f32 = 1e-5;

/// The alpha masks of a scene.
#[derive(Debug)]
pub struct Holes {
    materials: Loaded<u32>,
    masks: Loaded<MaterialMask>,
    uvs: Option<Loaded<[f32; 2]>>,
    /// Alpha bytes of a texture, row by row, with its width and height.
    textures: BTreeMap<u32, (Loaded<u8>, [usize; 2])>,
}

impl Holes {
    /// Those of the scene; `None` where nothing has a mask.
    ///
    /// # Errors
    /// If an array that masks need is not there, or cannot be read.
    pub fn open(dump: &Dump) -> Result<Option<Self>, ReadError> {
        let place = Place::Scene;
        if !dump.has(&place(SceneArray::Masks)) {
            return Ok(None);
        }
        let masks = dump.array::<MaterialMask>(&place(SceneArray::Masks))?;
        let mut textures = BTreeMap::new();
        for &MaterialMask { texture, .. } in masks.iter() {
            let place = place(SceneArray::Mask(texture));
            if texture == MaterialMask::NO_TEXTURE || textures.contains_key(&texture) {
                continue;
            }
            let alphas = dump.array::<u8>(&place)?;
            if let Some(&[height, width]) = dump.shape(&place)
                && !alphas.is_empty()
            {
                textures.insert(texture, (alphas, [width as usize, height as usize]));
            }
        }
        let has_uvs = dump.has(&place(SceneArray::Uvs));
        Ok(Some(Self {
            materials: dump.array(&place(SceneArray::Materials))?,
            textures,
            uvs: has_uvs.then(|| dump.array(&place(SceneArray::Uvs))).transpose()?,
            masks,
        }))
    }

    /// Whether the point with the barycentric weights u and v of a triangle is a hole, as trace kernels have it.
    /// What the arrays do not say is none.
    pub fn is_hole(&self, triangle: u32, corners: [u32; 3], weights: [f32; 2]) -> bool {
        self.is_hole_around(triangle, corners, weights, &[0.0])
    }

    /// Whether it is, and its neighbours within rounding are too.
    pub fn is_surely_hole(&self, triangle: u32, corners: [u32; 3], weights: [f32; 2]) -> bool {
        self.is_hole_around(triangle, corners, weights, &[0.0, -1.0, 1.0])
    }

    fn is_hole_around(&self, triangle: u32, corners: [u32; 3], [u, v]: [f32; 2], steps: &[f32]) -> bool {
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
        threshold > 0.0 && steps.iter().all(|&y| steps.iter().all(|&x| is_below(x, y)))
    }
}
