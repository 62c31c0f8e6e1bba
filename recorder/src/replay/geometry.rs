//! The scene as a recording holds it: triangles and their alpha masks.

use anyhow::{Context, Result, bail};
use formats::manifest::{Place, SceneArray};
use formats::npy::MaterialMask;
use formats::reader::Dump;
use scenes::{Material, Scene, Texture};

use super::queues::NEEDED;

/// What rays can be traced through.
///
/// # Errors
/// If the scene was not kept, or its arrays do not belong together.
pub(super) fn scene(dump: &Dump) -> Result<Scene> {
    let positions = dump.checked_array::<[f32; 3]>(&Place::Scene(SceneArray::Positions)).context(NEEDED)?;
    let triangles = dump.checked_array::<[u32; 3]>(&Place::Scene(SceneArray::Triangles)).context(NEEDED)?;
    if let Some(at) = positions.iter().position(|point| !point.iter().all(|along| along.is_finite())) {
        bail!("scene/positions.npy: vertex {at} is {:?}, expected finite numbers", positions[at]);
    }
    check_below(triangles.iter().flatten(), positions.len(), "a vertex")?;
    let name = dump.manifest().header.scene.name.clone();
    let mut scene = Scene::of_geometry(name, positions.to_vec(), triangles.to_vec());
    if dump.has(&Place::Scene(SceneArray::Masks)) {
        add_masks(dump, &mut scene)?;
    }
    Ok(scene)
}

fn add_masks(dump: &Dump, scene: &mut Scene) -> Result<()> {
    let masks = dump.checked_array::<MaterialMask>(&Place::Scene(SceneArray::Masks))?;
    let materials = dump.checked_array::<u32>(&Place::Scene(SceneArray::Materials))?;
    anyhow::ensure!(
        materials.len() == scene.triangles.len(),
        "the recording has {} triangles, but materials for {}; run `inspector verify` on it",
        scene.triangles.len(),
        materials.len()
    );
    check_below(materials.iter(), masks.len(), "a material")?;
    if let Some(at) = masks.iter().position(|mask| !mask.is_valid()) {
        let (found, most) = (masks[at].cutoff, MaterialMask::CUTOFF_MAX);
        bail!("scene/masks.npy: the cutoff of material {at} is {found}, expected 0 to {most}");
    }
    scene.triangle_materials = materials.to_vec();
    if dump.has(&Place::Scene(SceneArray::Uvs)) {
        scene.uvs = dump.checked_array::<[f32; 2]>(&Place::Scene(SceneArray::Uvs))?.to_vec();
    }
    let used = masks.iter().map(|mask| mask.texture).filter(|&texture| texture != MaterialMask::NO_TEXTURE);
    let textures = used.map(|texture| texture as usize + 1).max().unwrap_or(0);
    scene.textures = (0..textures).map(|number| texture(dump, number as u32)).collect::<Result<_>>()?;
    scene.materials = masks.iter().map(material).collect();
    Ok(())
}

fn texture(dump: &Dump, number: u32) -> Result<Texture> {
    let place = Place::Scene(SceneArray::Mask(number));
    let alpha = dump.checked_array::<u8>(&place)?;
    let shape = dump.record(&place).map(|record| record.shape.clone()).unwrap_or_default();
    let [height, width] = shape.as_slice() else { bail!("{place} is no picture") };
    anyhow::ensure!(!alpha.is_empty(), "{place} has no texels");
    let rgba = alpha.iter().map(|&alpha| [0, 0, 0, alpha]).collect();
    Ok(Texture { width: *width as u32, height: *height as u32, rgba })
}

/// A material whose threshold is that of the mask.
fn material(mask: &MaterialMask) -> Material {
    let threshold = (mask.cutoff * 255.0).round();
    Material {
        base_color_texture: (mask.texture != MaterialMask::NO_TEXTURE).then_some(mask.texture),
        // Half a step below, so that rounding cannot lift it to the next threshold.
        alpha_cutoff: (threshold > 0.0).then_some((threshold - 0.5) / 255.0),
        ..Material::default()
    }
}

fn check_below<'a>(indices: impl Iterator<Item = &'a u32>, count: usize, what: &str) -> Result<()> {
    match indices.copied().find(|&index| index as usize >= count) {
        None => Ok(()),
        Some(index) => bail!(
            "a triangle of the recording has {what} {index}, but there are {count}; run `inspector verify` on it"
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thresholds_come_back() {
        for threshold in 0..=256u32 {
            let mask = MaterialMask { texture: 0, cutoff: threshold as f32 / 255.0 };
            assert_eq!(material(&mask).alpha_threshold(), threshold);
        }
    }
}
