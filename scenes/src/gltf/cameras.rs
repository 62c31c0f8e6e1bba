//! Perspective cameras, in the order of their nodes.

use ::gltf::json::camera::Type;
use ::gltf::json::validation::Checked;
use glam::DVec3;

use super::Document;
use super::error::GltfError;
use super::nodes::{self, PlacedNode};
use super::notices::Notices;
use crate::Camera;

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
        let from = || nodes::describe(&document.root, placed.index);
        let json = document.get(index, from, "camera")?;
        let (Checked::Valid(Type::Perspective), Some(perspective)) = (json.type_, &json.perspective) else {
            notices.count("cameras without perspective are skipped", 1);
            continue;
        };
        let name = node.name.as_ref().or(json.name.as_ref());
        let name = name.map_or_else(|| format!("camera {}", index.value()), String::clone);
        // Cameras look along −z with +y up (glTF 2.0 §3.10); what scales and mirrors does not count.
        let world_from_node = &placed.world_from_node;
        let eye = world_from_node.translation;
        let forward = world_from_node.transform_vector3(DVec3::NEG_Z);
        let up = world_from_node.transform_vector3(DVec3::Y);
        let camera = Camera::from_axes(&name, eye, forward, up, perspective.yfov);
        cameras.push(camera.map_err(|source| GltfError::Camera {
            camera: format!("camera {} of {}", index.value(), from()),
            source,
        })?);
    }
    Ok(cameras)
}
