//! Materials, and the textures of those that a triangle uses.

use ::gltf::json::extensions::material::PbrSpecularGlossiness;
use ::gltf::json::material::{AlphaMode, Material as JsonMaterial};
use ::gltf::json::texture::{Info, Texture as JsonTexture, WrappingMode};
use ::gltf::json::{Index, image::Image, validation::Checked};

use super::Document;
use super::error::GltfError;
use super::images::{self, Decoded, Wanted};
use super::notices::Notices;
use crate::shown::shown;
use crate::{Material, Texture};

/// All materials of the file in its order, and one matt grey for primitives that have none: the
/// white metal that glTF gives them (§3.9.6) would never absorb a ray. Only base-colour textures are
/// kept; of the others the mean counts. `is_used` says for each whether a triangle has it;
/// images of unused materials are not read.
pub(super) fn read(
    document: &Document,
    is_used: &[bool],
    notices: &mut Notices,
) -> Result<(Vec<Material>, Vec<Texture>), GltfError> {
    let json = &document.root.materials;
    let used = || json.iter().zip(is_used).enumerate().filter(|(_, (_, is_used))| **is_used);

    let mut wanted: Vec<Wanted> = Vec::new();
    for (index, (material, _)) in used() {
        let maps = Maps::of(document, index, material)?;
        for (image, texels) in [
            (maps.base_color, true),
            (maps.metallic_roughness, false),
            (maps.specular_glossiness, false),
            (maps.emissive, false),
        ] {
            if let Some(image) = image {
                want(&mut wanted, image, texels);
            }
        }
        note_what_is_ignored(document, material, notices);
    }
    let mut decoded = images::decode_all(document, &wanted)?;

    // Textures are numbered in the order in which materials first mention them.
    let mut textures = Vec::new();
    let texture_of: Vec<Option<u32>> = decoded
        .iter_mut()
        .map(|decoded| {
            let texture = decoded.texture.take()?;
            textures.push(texture);
            Some(textures.len() as u32 - 1)
        })
        .collect();
    let place_of =
        |image: Index<Image>| wanted.iter().position(|wanted| wanted.image.value() == image.value());

    let mut materials = Vec::with_capacity(json.len() + 1);
    for (index, material) in json.iter().enumerate() {
        let mut read = convert(index, material)?;
        if is_used[index] {
            let maps = Maps::of(document, index, material)?;
            read.base_color_texture = maps.base_color.and_then(place_of).and_then(|place| texture_of[place]);
            let mean = |image: Option<Index<Image>>| image.and_then(place_of).map(|place| &decoded[place]);
            apply_means(&mut read, mean(maps.metallic_roughness), mean(maps.emissive));
            if let Some(map) = mean(maps.specular_glossiness) {
                let [_, _, _, gloss] = map.mean;
                read.roughness = 1.0 - (1.0 - read.roughness) * gloss;
            }
        }
        materials.push(read);
    }
    if is_used[json.len()] || materials.is_empty() {
        materials.push(Material::default());
    }
    Ok((materials, textures))
}

/// Adds an image to those to decode, each once.
fn want(wanted: &mut Vec<Wanted>, image: Index<Image>, texels: bool) {
    let known = wanted.iter_mut().find(|wanted| wanted.image.value() == image.value());
    match known {
        Some(known) => {
            known.texels |= texels;
            known.mean |= !texels;
        }
        None => wanted.push(Wanted { image, texels, mean: !texels }),
    }
}

/// The images behind a material's textures.
struct Maps {
    base_color: Option<Index<Image>>,
    metallic_roughness: Option<Index<Image>>,
    specular_glossiness: Option<Index<Image>>,
    emissive: Option<Index<Image>>,
}

impl Maps {
    fn of(document: &Document, material: usize, json: &JsonMaterial) -> Result<Self, GltfError> {
        let image = |info: Option<&Info>| -> Result<Option<Index<Image>>, GltfError> {
            let Some(info) = info else { return Ok(None) };
            let from = || describe(material, json);
            Ok(source(document.get(info.index, from, "texture")?))
        };
        Ok(Self {
            base_color: image(base_color_texture(json))?,
            metallic_roughness: image(json.pbr_metallic_roughness.metallic_roughness_texture.as_ref())?,
            specular_glossiness: image(specular_glossiness_texture(json))?,
            emissive: image(json.emissive_texture.as_ref())?,
        })
    }
}

/// What `KHR_materials_pbrSpecularGlossiness` says, if the material has no factors of glTF's own.
fn specular_glossiness(json: &JsonMaterial) -> Option<&PbrSpecularGlossiness> {
    json.extensions.as_ref()?.pbr_specular_glossiness.as_ref()
}

fn specular_glossiness_texture(json: &JsonMaterial) -> Option<&Info> {
    specular_glossiness(json)?.specular_glossiness_texture.as_ref()
}

/// The texture of a material's base colour, which may be called its diffuse one.
pub(super) fn base_color_texture(json: &JsonMaterial) -> Option<&Info> {
    match specular_glossiness(json) {
        Some(factors) => factors.diffuse_texture.as_ref(),
        None => json.pbr_metallic_roughness.base_color_texture.as_ref(),
    }
}

/// A texture's image. It may lack one, and leave it to an extension.
pub(super) fn source(texture: &JsonTexture) -> Option<Index<Image>> {
    /// What the parser puts in place of an image that is not there.
    const NO_IMAGE: usize = u32::MAX as usize;

    (texture.source.value() != NO_IMAGE).then_some(texture.source)
}

fn describe(index: usize, json: &JsonMaterial) -> String {
    match &json.name {
        Some(name) => format!("material {index} (\"{}\")", shown(name)),
        None => format!("material {index}"),
    }
}

fn note_what_is_ignored(document: &Document, json: &JsonMaterial, notices: &mut Notices) {
    if specular_glossiness(json).is_some() {
        let sentence =
            "specular-glossiness materials have their diffuse colour and gloss, but no specular colour";
        notices.count(sentence, 1);
    }
    if specular_glossiness_texture(json).is_some() {
        notices.count("specular-glossiness textures are replaced by their mean gloss", 1);
    }
    if json.alpha_mode == Checked::Valid(AlphaMode::Blend) {
        notices.count("materials with alpha blending are treated as opaque", 1);
    }
    if json.normal_texture.is_some() {
        notices.count("normal maps are ignored", 1);
    }
    let metallic_roughness_texture = json.pbr_metallic_roughness.metallic_roughness_texture.as_ref();
    if metallic_roughness_texture.is_some() {
        notices.count("metallic-roughness textures are replaced by their means", 1);
    }
    if json.emissive_texture.is_some() {
        notices.count("emissive textures are replaced by their means", 1);
    }
    for info in [
        base_color_texture(json),
        metallic_roughness_texture,
        specular_glossiness_texture(json),
        json.emissive_texture.as_ref(),
    ] {
        let texture = info.and_then(|info| document.root.get(info.index));
        if texture.is_some_and(|texture| source(texture).is_none()) {
            notices.count("textures without an image count as white", 1);
        }
    }
    let texture = base_color_texture(json).and_then(|info| document.root.get(info.index));
    let sampler = texture.and_then(|texture| texture.sampler).and_then(|sampler| document.root.get(sampler));
    let wraps = |mode| mode == Checked::Valid(WrappingMode::Repeat);
    if sampler.is_some_and(|sampler| !wraps(sampler.wrap_s) || !wraps(sampler.wrap_t)) {
        notices.count("textures wrap around, although the file wants them clamped or mirrored", 1);
    }
}

/// A material without its textures (glTF 2.0 §3.9, `KHR_materials_emissive_strength` and of
/// `KHR_materials_pbrSpecularGlossiness` what a dielectric has here, whose specular colour is always the same).
fn convert(index: usize, json: &JsonMaterial) -> Result<Material, GltfError> {
    let refuse = |field, found, expected| {
        Err(GltfError::Value { what: describe(index, json), field, found, expected })
    };
    let Checked::Valid(alpha_mode) = json.alpha_mode else {
        return refuse("an alpha mode", "that glTF does not have".into(), "OPAQUE, MASK or BLEND");
    };
    let (base_color, metallic, roughness) = match specular_glossiness(json) {
        Some(factors) => (factors.diffuse_factor.0, 0.0, 1.0 - factors.glossiness_factor.0),
        None => {
            let factors = &json.pbr_metallic_roughness;
            (factors.base_color_factor.0, factors.metallic_factor.0, factors.roughness_factor.0)
        }
    };
    let [red, green, blue, alpha] = base_color.map(|factor| factor.clamp(0.0, 1.0));
    let strength = json.extensions.as_ref().and_then(|extensions| extensions.emissive_strength.as_ref());
    let strength = strength.map_or(1.0, |strength| strength.emissive_strength.0);
    let emission = json.emissive_factor.0.map(|factor| factor * strength);
    if !emission.iter().all(|channel| channel.is_finite() && *channel >= 0.0) {
        return refuse("the emission", format!("{emission:?}"), "finite numbers of at least 0");
    }
    let cutoff = json.alpha_cutoff.unwrap_or_default().0;
    Ok(Material {
        name: json.name.as_deref().map(shown).unwrap_or_default(),
        base_color: [red, green, blue],
        base_color_texture: None,
        metallic: metallic.clamp(0.0, 1.0),
        roughness: roughness.clamp(0.0, 1.0),
        emission,
        alpha_cutoff: (alpha_mode == AlphaMode::Mask).then_some(cutoff),
        alpha,
    })
}

/// Multiplies factors by the means of their textures: a factor of 1 with a texture next to it
/// rarely means a surface that is all metal, or all lamp.
fn apply_means(material: &mut Material, metallic_roughness: Option<&Decoded>, emissive: Option<&Decoded>) {
    if let Some(map) = metallic_roughness {
        let [_, roughness, metallic, _] = map.mean;
        material.roughness *= roughness;
        material.metallic *= metallic;
    }
    if let Some(map) = emissive {
        for (channel, mean) in material.emission.iter_mut().zip(map.mean_linear) {
            *channel *= mean;
        }
    }
}
