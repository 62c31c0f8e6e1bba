//! Perspective cameras, in the order of their nodes. One that cannot be used is left out and said: the
//! file may have others.

use ::gltf::json::Value;
use ::gltf::json::deserialize::from_value;
use glam::DVec3;
use serde::Deserialize;

use super::Document;
use super::error::GltfError;
use super::nodes::{self, PlacedNode};
use super::notices::Notices;
use crate::Camera;
use crate::shown::shown;

/// What is read of a camera.
#[derive(Deserialize)]
struct JsonCamera {
    #[serde(rename = "type")]
    kind: String,
    perspective: Option<Perspective>,
}

/// What is read of a perspective. Nothing is clipped, and pictures have the aspect that they are given.
#[derive(Deserialize)]
struct Perspective {
    yfov: f32,
}

/// Reads the cameras of all placed nodes. Each is called by its node, else by its own name, else by
/// its number. Names may repeat.
pub(super) fn read(
    document: &Document,
    nodes: &[PlacedNode],
    notices: &mut Notices,
) -> Result<Vec<Camera>, GltfError> {
    let mut cameras = Vec::new();
    for placed in nodes {
        let node = &document.root.nodes[placed.index];
        let Some(index) = node.camera else { continue };
        let index = index.value();
        let from = || nodes::describe(&document.root, placed.index);
        let json = document.cameras.get(index).ok_or_else(|| GltfError::Reference {
            from: from(),
            to: "camera",
            index,
        })?;
        let names = [node.name.as_deref(), json.get("name").and_then(Value::as_str)];
        let name = names
            .into_iter()
            .flatten()
            .find(|name| !name.is_empty())
            .map_or_else(|| format!("camera {index}"), shown);
        match convert(json, &name, placed) {
            Ok(Some(camera)) => cameras.push(camera),
            Ok(None) => notices.count("cameras without perspective are skipped", 1),
            Err(problem) => notices.say(format!(
                "the camera \"{name}\" (camera {index} of {}) cannot be used: {}",
                from(),
                shown(&problem)
            )),
        }
    }
    Ok(cameras)
}

/// A camera; `None` if it has no perspective; or why it cannot be used.
fn convert(json: &Value, name: &str, placed: &PlacedNode) -> Result<Option<Camera>, String> {
    let JsonCamera { kind, perspective } =
        from_value(json.clone()).map_err(|error: ::gltf::json::Error| error.to_string())?;
    let perspective = match (kind.as_str(), perspective) {
        ("perspective", Some(perspective)) => perspective,
        ("perspective", None) => return Err("it has no perspective".into()),
        _ => return Ok(None),
    };
    // Cameras look along −z with +y up (glTF 2.0 §3.10); what scales and mirrors does not count.
    let world_from_node = &placed.world_from_node;
    let eye = world_from_node.translation;
    let forward = world_from_node.transform_vector3(DVec3::NEG_Z);
    let up = world_from_node.transform_vector3(DVec3::Y);
    let camera = Camera::from_axes(name, eye, forward, up, perspective.yfov);
    camera.map(Some).map_err(|error| error.to_string())
}
