//! The header's own numbers, the scene's arrays and the picture.

use std::collections::BTreeSet;

use sha2::{Digest, Sha256};

use super::{Check, Subject};
use crate::key::method::UNSORTED;
use crate::key::{Extent, KEY_BITS_MIN, LAYOUT_BITS, LayoutText, Termination};
use crate::length_table::LONGEST_SUMMED;
use crate::manifest::{Header, IMPORTED_HITS, MethodRecord, Outcome, Place, SceneArray, Source};
use crate::npy::MaterialMask;
use crate::reader::DumpState;
use crate::summary::hexadecimal;
use crate::text::shown;

pub(super) fn check(subject: &Subject<'_>) -> [Check; 3] {
    [check_header(subject), check_scene(subject), check_image(subject)]
}

fn check_header(subject: &Subject<'_>) -> Check {
    let manifest = subject.dump.manifest();
    let mut check = Check::new("header");
    check.checked += 1;
    manifest.header.problems().into_iter().for_each(|problem| check.problems.add(problem));
    if let Source::Replayed { name, .. } = &manifest.header.source {
        check.require(subject.dump.source().is_some(), || {
            let name = shown(name);
            format!(
                "it is a replay of {name}, which is not in the same folder, or is another recording by now; put that recording beside it to check both"
            )
        });
    }
    if let Some(source) = subject.dump.source() {
        let differing = differing(&manifest.header, &source.manifest().header);
        check.require(differing.is_empty(), || {
            format!("its {} are not those of the recording that it is a replay of", differing.join(", "))
        });
    }
    for method in &manifest.methods {
        let problem = method_problem(method, manifest.header.extent());
        check.find(problem, || format!("method {}", shown(&method.name)));
    }
    check
}

/// What was found at import of the hits that came with the rays, if any came.
pub(super) fn check_imported_hits(subject: &Subject<'_>) -> Option<Check> {
    let found = &subject.dump.manifest().header.self_check;
    let found = found.iter().find(|found| found.name == IMPORTED_HITS)?;
    let mut check = Check::new(IMPORTED_HITS);
    check.require(found.outcome != "failed", || found.detail.clone());
    Some(check)
}

/// What of a replay's header should be its source's, and is not.
fn differing(replay: &Header, source: &Header) -> Vec<&'static str> {
    let picture = |header: &Header| (header.options.width, header.options.height, header.options.seed);
    let path =
        |header: &Header| (header.options.passes, header.options.bounces, header.options.russian_roulette);
    let parts = [
        ("scene", replay.scene == source.scene),
        ("camera", replay.camera == source.camera),
        ("lights", replay.lights == source.lights),
        ("width, height and seed", picture(replay) == picture(source)),
        ("passes, bounces and roulette", path(replay) == path(source)),
    ];
    parts.into_iter().filter(|(_, is_same)| !is_same).map(|(part, _)| part).collect()
}

/// What is wrong with the record of a method, if anything.
pub(super) fn method_problem(method: &MethodRecord, extent: Extent) -> Option<String> {
    if !(KEY_BITS_MIN..=LAYOUT_BITS).contains(&method.key_bits) {
        return Some(format!("keys of {} bits, expected {KEY_BITS_MIN} to {LAYOUT_BITS}", method.key_bits));
    }
    if !(0.0..=LONGEST_SUMMED).contains(&method.two_point_length) {
        let length = method.two_point_length;
        return Some(format!("it assumes a length of {length}, expected 0 to {LONGEST_SUMMED}"));
    }
    if method.base == UNSORTED {
        return Some(format!("it is a variant of {UNSORTED}, which has no key"));
    }
    if !method.has_layout() {
        let is_plain = method.layout.is_empty() && method.termination == Termination::Unused;
        return (!is_plain).then(|| "it has bits or a length, but no layout that they are of".to_owned());
    }
    let parsed = LayoutText::parse(&method.text).and_then(|text| Ok((text.length(), text.expand(extent)?)));
    let (length, layout) = match parsed {
        Ok(parsed) => parsed,
        Err(error) => return Some(error.message),
    };
    let text = shown(&method.text);
    if layout.names() != method.layout {
        return Some(format!(
            "its bits are not those of '{text}' for {} lights and a picture of {} × {} pixels",
            extent.lights, extent.picture[0], extent.picture[1]
        ));
    }
    let is_said = length.is_none_or(|length| length == method.termination);
    (!method.termination.fits(&layout) || !is_said).then(|| {
        let found = method.termination;
        format!("its length is {found:?}, which does not fit '{text}'; only ex, ey and ez need one")
    })
}

fn check_scene(subject: &Subject<'_>) -> Check {
    let scene = &subject.dump.manifest().header.scene;
    let mut check = Check::new("scene");
    let array = |array| Place::Scene(array);
    let positions = subject.array::<[f32; 3]>(&array(SceneArray::Positions));
    let triangles = subject.array::<[u32; 3]>(&array(SceneArray::Triangles));
    let (Some(positions), Some(triangles)) = (positions, triangles) else {
        let absence = subject.geometry_absence();
        check.not_checked.push(format!("the scene was {absence}"));
        return check;
    };
    let is_inside = |point: &[f32; 3]| {
        (0..3).all(|axis| point[axis] >= scene.bounds_min[axis] && point[axis] <= scene.bounds_max[axis])
    };
    for (array, things, found, counted) in [
        ("positions", "vertices", positions.len(), scene.vertices),
        ("triangles", "triangles", triangles.len(), scene.triangles),
    ] {
        check.require(found as u64 == counted, || {
            format!("scene/{array}.npy has {found} {things}, the header counts {counted}")
        });
    }
    let in_range =
        |triangle: usize| triangles[triangle].iter().all(|&index| (index as usize) < positions.len());
    check.each(triangles.len(), in_range, |triangle| {
        format!(
            "scene/triangles.npy: triangle {triangle} has corners {:?} of {} vertices",
            triangles[triangle],
            positions.len()
        )
    });
    let corners_inside = |triangle: usize| {
        let corners = triangles[triangle].iter();
        corners.filter_map(|&index| positions.get(index as usize)).all(is_inside)
    };
    check.each(triangles.len(), corners_inside, |triangle| {
        format!("scene/positions.npy: triangle {triangle} leaves the scene's box, or is not finite")
    });
    if let Some(materials) = subject.array::<u32>(&array(SceneArray::Materials)) {
        check.require(materials.len() == triangles.len(), || {
            format!("scene/materials.npy has {} entries for {} triangles", materials.len(), triangles.len())
        });
        check_masks(subject, &mut check, &materials, positions.len());
    }
    if let Some(colours) = subject.array::<[u8; 3]>(&array(SceneArray::Colours)) {
        check.require(colours.len() == triangles.len(), || {
            format!("scene/colours.npy has {} entries for {} triangles", colours.len(), triangles.len())
        });
    }
    check
}

/// Alpha masks: one entry per material, texture coordinates for every vertex, textures that exist and have
/// texels.
fn check_masks(subject: &Subject<'_>, check: &mut Check, materials: &[u32], vertices: usize) {
    let Some(masks) = subject.array::<MaterialMask>(&Place::Scene(SceneArray::Masks)) else { return };
    let in_range = |triangle: usize| (materials[triangle] as usize) < masks.len();
    check.each(materials.len(), in_range, |triangle| {
        format!(
            "scene/materials.npy: triangle {triangle} has material {} of {}",
            materials[triangle],
            masks.len()
        )
    });
    check.each(
        masks.len(),
        |material| masks[material].is_valid(),
        |material| {
            let (found, most) = (masks[material].cutoff, MaterialMask::CUTOFF_MAX);
            format!("scene/masks.npy: the cutoff of material {material} is {found}, expected 0 to {most}")
        },
    );
    let uvs = subject.array::<[f32; 2]>(&Place::Scene(SceneArray::Uvs));
    let is_finite = |vertex: usize| uvs.as_ref().is_none_or(|uvs| uvs[vertex].iter().all(|x| x.is_finite()));
    check.each(uvs.as_ref().map_or(0, |uvs| uvs.len()), is_finite, |vertex| {
        format!("scene/uvs.npy: vertex {vertex} has coordinates that are not finite")
    });
    let uvs = uvs.map(|uvs| uvs.len());
    let textures: BTreeSet<u32> = masks
        .iter()
        .map(|mask| mask.texture)
        .filter(|&texture| texture != MaterialMask::NO_TEXTURE)
        .collect();
    // A recording that was ended early may have got no further, and a recovered one has lost something.
    let may_lack = subject.dump.state() != DumpState::Complete;
    for texture in textures {
        check.require(uvs == Some(vertices) || (uvs.is_none() && may_lack), || {
            format!("scene/uvs.npy has {} entries for {vertices} vertices", uvs.unwrap_or(0))
        });
        let place = Place::Scene(SceneArray::Mask(texture));
        check.require(subject.dump.has(&place) || may_lack, || format!("there is no {place}"));
        let has_texels = subject.dump.record(&place).is_none_or(|record| !record.shape.contains(&0));
        check.require(has_texels, || format!("{place} has no texels"));
    }
}

fn check_image(subject: &Subject<'_>) -> Check {
    let mut check = Check::new("image");
    let end = subject.dump.manifest().end;
    let options = &subject.dump.manifest().header.options;
    if let Some(digest) = end.and_then(|end| end.image) {
        let is_same = (digest.width, digest.height) == (options.width, options.height);
        check.require(is_same, || {
            format!(
                "the picture has {} × {} pixels by the end record, {} × {} by the header",
                digest.width, digest.height, options.width, options.height
            )
        });
    }
    // A replay has no picture of its own.
    let is_own = subject.dump.record(&Place::Image).is_some();
    let Some(image) = subject.array::<f32>(&Place::Image).filter(|_| is_own) else {
        check.not_checked.push(format!("the picture was {}", subject.absence(&Place::Image)));
        return check;
    };
    let is_finite = |at: usize| image[at].is_finite() && image[at] >= 0.0;
    check.each(image.len(), is_finite, |at| format!("image.npy: value {at} is {}", image[at]));
    let Some(digest) = end.and_then(|end| end.image) else {
        if end.is_some_and(|end| end.outcome == Outcome::Complete) {
            check.problems.add("there is an image.npy, but the end record has no hash for it".to_owned());
        }
        return check;
    };
    let shape = subject.dump.record(&Place::Image).map_or(&[][..], |record| &record.shape);
    check.require(shape == [u64::from(digest.height), u64::from(digest.width), 3], || {
        format!("image.npy has shape {shape:?}, the end record says {} × {}", digest.width, digest.height)
    });
    let found: [u8; 32] = Sha256::digest(bytemuck::cast_slice::<f32, u8>(&image)).into();
    check.require(found == digest.sha256, || {
        format!(
            "image.npy has SHA-256 {}, the end record says {}",
            hexadecimal(&found),
            hexadecimal(&digest.sha256)
        )
    });
    check
}
