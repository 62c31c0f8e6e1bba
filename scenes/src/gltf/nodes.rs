//! The node hierarchy: which nodes the scene has, and where in the world each one is.

use ::gltf::json::scene::UnitQuaternion;
use ::gltf::json::{Index, Node, Root, Scene};
use glam::{DAffine3, DMat3, DQuat, DVec3};

use super::Document;
use super::error::GltfError;
use crate::shown::shown;

/// A node of the scene, in the order of a depth-first walk.
pub(super) struct PlacedNode {
    /// Its number in the file.
    pub(super) index: usize,
    /// From its own space to the world. In f64: deep hierarchies would lose bits in f32.
    pub(super) world_from_node: DAffine3,
}

/// How messages call a node.
pub(super) fn describe(root: &Root, node: usize) -> String {
    match root.nodes.get(node).and_then(|node| node.name.as_ref()) {
        Some(name) => format!("node {node} (\"{}\")", shown(name)),
        None => format!("node {node}"),
    }
}

/// Walks the default scene; without one the first scene, without any scene all root nodes.
pub(super) fn place(document: &Document) -> Result<Vec<PlacedNode>, GltfError> {
    let root = &document.root;
    let mut placed = Vec::new();
    let mut parent_of = vec![None; root.nodes.len()];
    let mut to_visit: Vec<(Index<Node>, String, DAffine3)> = Vec::new();
    let (roots, whose) = roots(document)?;
    to_visit.extend(roots.iter().rev().map(|&node| (node, whose.clone(), DAffine3::IDENTITY)));
    // A stack of our own, since a file may nest deeper than the thread's.
    while let Some((index, parent, world_from_parent)) = to_visit.pop() {
        let node = document.get(index, || parent.clone(), "node")?;
        let index = index.value();
        let description = describe(root, index);
        if parent_of[index].replace(()).is_some() {
            return Err(GltfError::NodeReachedTwice { node: description, parent });
        }
        let world_from_node = world_from_parent * parent_from_node(node);
        if !world_from_node.is_finite() {
            let has_length = |rotation: &UnitQuaternion| rotation.0.iter().any(|&x| x != 0.0);
            let problem = match node.rotation.as_ref().is_none_or(has_length) {
                true => "it is not finite",
                false => "its rotation has no length",
            };
            return Err(GltfError::Transform { node: description, problem });
        }
        let children = node.children.iter().flatten().rev();
        to_visit.extend(children.map(|&child| (child, description.clone(), world_from_node)));
        placed.push(PlacedNode { index, world_from_node });
    }
    Ok(placed)
}

/// The nodes to start from, and who lists them.
fn roots(document: &Document) -> Result<(Vec<Index<Node>>, String), GltfError> {
    let root = &document.root;
    let scene = root.scene.or((!root.scenes.is_empty()).then(|| Index::<Scene>::new(0)));
    if let Some(scene) = scene {
        let nodes = &document.get(scene, || "the file".into(), "scene")?.nodes;
        if nodes.is_empty() {
            return Err(GltfError::EmptyScene { scene: scene.value() });
        }
        return Ok((nodes.clone(), format!("scene {}", scene.value())));
    }
    let mut is_child = vec![false; root.nodes.len()];
    for child in root.nodes.iter().flat_map(|node| &node.children).flatten() {
        if let Some(flag) = is_child.get_mut(child.value()) {
            *flag = true;
        }
    }
    let is_root = |&index: &u32| !is_child[index as usize];
    let nodes = (0..root.nodes.len() as u32).filter(is_root).map(Index::new).collect();
    Ok((nodes, "the file".into()))
}

/// A node's own transform (glTF 2.0 §3.5.2).
fn parent_from_node(node: &Node) -> DAffine3 {
    if let Some(matrix) = node.matrix {
        return affine(&matrix);
    }
    let vector =
        |values: Option<[f32; 3]>, default| values.map_or(default, |v| DVec3::from_array(v.map(f64::from)));
    // Unit in the file only to the precision of f32.
    let rotation = node
        .rotation
        .map_or(DQuat::IDENTITY, |rotation| DQuat::from_array(rotation.0.map(f64::from)).normalize());
    DAffine3::from_scale_rotation_translation(
        vector(node.scale, DVec3::ONE),
        rotation,
        vector(node.translation, DVec3::ZERO),
    )
}

/// A column-major matrix of 4 × 4 without its last row, which is (0, 0, 0, 1).
pub(super) fn affine(matrix: &[f32; 16]) -> DAffine3 {
    let column = |start: usize| DVec3::from_array([0, 1, 2].map(|row| f64::from(matrix[start + row])));
    DAffine3 { matrix3: DMat3::from_cols(column(0), column(4), column(8)), translation: column(12) }
}
