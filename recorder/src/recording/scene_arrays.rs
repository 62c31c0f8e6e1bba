//! The scene's arrays, for the inspector and for replays, and its hierarchy.

use anyhow::{Result, bail};
use formats::manifest::{Place, SceneArray};
use formats::npy::MaterialMask;
use scenes::Scene;
use scenes::bvh::{Bvh, WideNode};

use crate::capture::Capture;
use crate::stages::trace::TraceKernel;

/// Writes geometry and colours, and alpha masks where a material has one.
pub(super) fn write(capture: &mut Capture, scene: &Scene) -> Result<()> {
    let place = Place::Scene;
    let (vertices, triangles) = (scene.positions.len() as u64, scene.triangles.len() as u64);
    capture.whole_array(place(SceneArray::Positions), &[vertices, 3], &scene.positions)?;
    capture.whole_array(place(SceneArray::Triangles), &[triangles, 3], &scene.triangles)?;
    capture.whole_array(place(SceneArray::Materials), &[triangles], &scene.triangle_materials)?;
    let colours = scenes::base_colour::of_triangles(scene);
    capture.whole_array(place(SceneArray::Colours), &[triangles, 3], &colours)?;
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

/// Writes the hierarchy that the kernel `wide` walks, whichever kernel traces.
pub(super) fn write_hierarchy(capture: &mut Capture, scene: &Scene) -> Result<()> {
    let Some((Bvh::Wide { nodes, order }, _)) = TraceKernel::Wide.hierarchy(scene)? else {
        bail!("the kernel wide walks no wide hierarchy; please report this");
    };
    let (count, slots) = (nodes.len() as u64, order.len() as u64);
    let corners = |node: &WideNode| {
        let planes = node.planes;
        let coordinate = move |slot: usize, side: usize| [0, 1, 2].map(|axis| planes[axis][side][slot]);
        (0..8).flat_map(move |slot| [0, 1].map(|side| coordinate(slot, side)))
    };
    let boxes: Vec<[f32; 3]> = nodes.iter().flat_map(corners).collect();
    let children: Vec<[u32; 8]> = nodes.iter().map(|node| node.children).collect();
    capture.whole_array(Place::Scene(SceneArray::NodeBoxes), &[count, 8, 6], &boxes)?;
    capture.whole_array(Place::Scene(SceneArray::NodeChildren), &[count, 8], &children)?;
    capture.whole_array(Place::Scene(SceneArray::LeafTriangles), &[slots], &order)
}
