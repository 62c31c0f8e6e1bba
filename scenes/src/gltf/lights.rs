//! Lights of `KHR_lights_punctual`, in the order of their nodes. Intensities keep the numbers of the
//! file (candela and lux there, watts here): only their ratios matter to a picture. One that makes no sense
//! is left out and said: the file may have others.

use ::gltf::json::extensions::scene::khr_lights_punctual::{Light as JsonLight, Type};
use ::gltf::json::validation::Checked;
use glam::DVec3;

use super::Document;
use super::error::GltfError;
use super::nodes::{self, PlacedNode};
use super::notices::Notices;
use crate::Light;

/// The smallest difference of the cosines of a spot's two cones: the extension's own sample code
/// divides by no less, and exporters write equal angles for a hard edge.
const MIN_CONE_COS_DIFFERENCE: f32 = 0.001;

/// Reads the lights of all placed nodes.
pub(super) fn read(
    document: &Document,
    nodes: &[PlacedNode],
    notices: &mut Notices,
) -> Result<Vec<Light>, GltfError> {
    let mut lights = Vec::new();
    for placed in nodes {
        let extensions = document.root.nodes[placed.index].extensions.as_ref();
        let Some(reference) = extensions.and_then(|extensions| extensions.khr_lights_punctual.as_ref())
        else {
            continue;
        };
        let node = || nodes::describe(&document.root, placed.index);
        let json = document.get(reference.light, node, "light")?;
        let description = || format!("light {} of {}", reference.light.value(), node());
        let light = match convert(json, placed, &description) {
            Ok(light) => light,
            Err(problem) => {
                notices.say(format!("{problem}; it is left out"));
                continue;
            }
        };
        match json.intensity > 0.0 && json.color.iter().any(|&channel| channel > 0.0) {
            true => {
                // The extension gives it to these alone.
                if matches!(light, Light::Point { .. } | Light::Spot { .. }) && json.range.is_some() {
                    notices.count("lights have a range, which is ignored", 1);
                }
                lights.push(light);
            }
            false => notices.count("lights without intensity are left out", 1),
        }
    }
    Ok(lights)
}

/// A light, or what is wrong with it.
fn convert(
    json: &JsonLight,
    placed: &PlacedNode,
    description: &dyn Fn() -> String,
) -> Result<Light, GltfError> {
    let refuse = |field, found, expected| GltfError::Value { what: description(), field, found, expected };
    let intensity = json.color.map(|channel| channel * json.intensity);
    if !intensity.iter().all(|channel| channel.is_finite() && *channel >= 0.0) {
        let found = format!("{:?} times {}", json.color, json.intensity);
        return Err(refuse("a colour and intensity of", found, "finite numbers of at least 0"));
    }
    let world_from_node = &placed.world_from_node;
    let position = world_from_node.translation.to_array().map(|x| x as f32);
    if !position.iter().all(|x| x.is_finite()) {
        return Err(refuse("the position", format!("{position:?}"), "finite numbers"));
    }
    let direction = || {
        let direction = world_from_node.transform_vector3(DVec3::NEG_Z).try_normalize();
        let direction = direction.map(|direction| direction.to_array().map(|x| x as f32));
        direction.ok_or_else(|| refuse("the scale", "0".into(), "one that leaves it a direction"))
    };
    match (json.type_, &json.spot) {
        (Checked::Valid(Type::Point), _) => Ok(Light::Point { position, intensity }),
        (Checked::Valid(Type::Directional), _) => {
            Ok(Light::Directional { direction: direction()?, irradiance: intensity })
        }
        (Checked::Valid(Type::Spot), Some(spot)) => {
            // The angles' ranges are the extension's; NaN cannot come out of JSON.
            let outer_angle = spot.outer_cone_angle.clamp(0.0, std::f32::consts::FRAC_PI_2);
            let inner_angle = spot.inner_cone_angle.clamp(0.0, outer_angle);
            let inner_cone_cos = inner_angle.cos();
            let outer_cone_cos = outer_angle.cos().min(inner_cone_cos - MIN_CONE_COS_DIFFERENCE);
            Ok(Light::Spot { position, direction: direction()?, intensity, inner_cone_cos, outer_cone_cos })
        }
        (Checked::Valid(Type::Spot), None) => Err(refuse("the type", "spot".into(), "its cone beside it")),
        (Checked::Invalid, _) => {
            Err(refuse("a type", "that is unknown".into(), "point, spot or directional"))
        }
    }
}
