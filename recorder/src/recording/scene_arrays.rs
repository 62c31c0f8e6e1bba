//! The scene's arrays, for the inspector and for replays.

use anyhow::Result;
use formats::manifest::{Place, SceneArray};
use formats::npy::MaterialMask;
use scenes::Scene;

use crate::capture::Capture;

/// Writes geometry, and alpha masks where a material has one.
pub(super) fn write(capture: &mut Capture, scene: &Scene) -> Result<()> {
    let place = Place::Scene;
    let (vertices, triangles) = (scene.positions.len() as u64, scene.triangles.len() as u64);
    capture.whole_array(place(SceneArray::Positions), &[vertices, 3], &scene.positions)?;
    capture.whole_array(place(SceneArray::Triangles), &[triangles, 3], &scene.triangles)?;
    capture.whole_array(place(SceneArray::Materials), &[triangles], &scene.triangle_materials)?;
    if scene.materials.iter().all(|material| material.alpha_cutoff.is_none()) {
        return Ok(());
    }
    if !scene.uvs.is_empty() {
        capture.whole_array(place(SceneArray::Uvs), &[vertices, 2], &scene.uvs)?;
    }
    let mut textures: Vec<u32> = Vec::new();
    let mut masks = Vec::new();
    for material in &scene.materials {
        let mut mask = MaterialMask { texture: MaterialMask::NO_TEXTURE, cutoff: 0.0 };
        if material.alpha_cutoff.is_some() {
            mask.cutoff = material.alpha_threshold() as f32 / 255.0;
            if let Some(texture) = material.base_color_texture {
                let known = textures.iter().position(|&known| known == texture);
                mask.texture = known.unwrap_or(textures.len()) as u32;
                if known.is_none() {
                    textures.push(texture);
                }
            }
        }
        masks.push(mask);
    }
    capture.whole_array(place(SceneArray::Masks), &[masks.len() as u64], &masks)?;
    for (number, &texture) in (0u32..).zip(&textures) {
        let texture = &scene.textures[texture as usize];
        let alpha: Vec<u8> = texture.rgba.iter().map(|texel| texel[3]).collect();
        let shape = [u64::from(texture.height), u64::from(texture.width)];
        capture.whole_array(place(SceneArray::Mask(number)), &shape, &alpha)?;
    }
    Ok(())
}
