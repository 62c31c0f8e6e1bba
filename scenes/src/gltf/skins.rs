//! Skins (glTF 2.0 §3.7.3.3): joints place the vertices of a mesh, in the pose that the nodes have in the file.

use ::gltf::json::accessor::{Accessor, ComponentType, Type};
use ::gltf::json::deserialize::from_value;
use ::gltf::json::mesh::{Primitive, Semantic};
use ::gltf::json::{Index, Node, validation::Checked};
use glam::{DAffine3, DMat3, DVec3};
use serde::Deserialize;

use super::Document;
use super::accessor::Elements;
use super::error::GltfError;
use super::nodes::{self, PlacedNode};
use super::notices::Notices;
use super::primitive;

/// What is read of a skin.
#[derive(Deserialize)]
struct JsonSkin {
    joints: Vec<Index<Node>>,
    #[serde(rename = "inverseBindMatrices")]
    inverse_bind_matrices: Option<Index<Accessor>>,
}

/// The skins of a file, each read when it is first asked for.
pub(super) struct Skins<'a> {
    document: &'a Document<'a>,
    /// By the number of a node; `None` for nodes that the scene does not have.
    world_from_node: Vec<Option<DAffine3>>,
    /// By the number of a skin and that of a joint: from the mesh, in its bind pose, to the world.
    world_from_mesh: Vec<Option<Vec<DAffine3>>>,
}

/// What moves the vertices of one primitive.
pub(super) struct Influences<'a> {
    joints: Elements<'a>,
    weights: Elements<'a>,
    /// By the number of a joint.
    world_from_mesh: &'a [DAffine3],
}

impl<'a> Skins<'a> {
    pub(super) fn of(document: &'a Document, nodes: &[PlacedNode]) -> Self {
        let mut world_from_node = vec![None; document.root.nodes.len()];
        for node in nodes {
            world_from_node[node.index] = Some(node.world_from_node);
        }
        Self { document, world_from_node, world_from_mesh: vec![None; document.skins.len()] }
    }

    /// What moves the vertices of a primitive of the mesh of `node`; `None` if that node itself does.
    /// `vertices` are those that it uses.
    ///
    /// # Errors
    /// A skin, joints or weights that cannot be read, or joints that are not there.
    pub(super) fn influences(
        &mut self,
        node: usize,
        primitive: &Primitive,
        vertices: &[u32],
        notices: &mut Notices,
    ) -> Result<Option<Influences<'_>>, GltfError> {
        let document = self.document;
        let Some(skin) = document.root.nodes[node].skin else { return Ok(None) };
        let accessor = |semantic: Semantic| primitive.attributes.get(&Checked::Valid(semantic)).copied();
        let open = |semantic| primitive::attribute(document, primitive, semantic, Type::Vec4);
        let (Some(accessor_of_joints), Some(joints)) =
            (accessor(Semantic::Joints(0)), open(Semantic::Joints(0))?)
        else {
            notices.count("skinned primitives without joints stand where their node is", 1);
            return Ok(None);
        };
        let weights = open(Semantic::Weights(0))?.ok_or_else(|| GltfError::AttributeCount {
            attribute: Semantic::Weights(0).to_string(),
            found: 0,
            expected: joints.len(),
        })?;
        if accessor(Semantic::Joints(1)).is_some() {
            notices.count("skinned primitives have more than four joints a vertex, of which four count", 1);
        }
        let world_from_mesh = self.world_from_mesh(node, skin.value())?;
        let influences = Influences { joints, weights, world_from_mesh };
        match influences.problem(vertices) {
            Some(problem) => Err(GltfError::Accessor { accessor: accessor_of_joints.value(), problem }),
            None => Ok(Some(influences)),
        }
    }

    /// Of each joint of a skin, which `node` refers to.
    fn world_from_mesh(&mut self, node: usize, skin: usize) -> Result<&[DAffine3], GltfError> {
        if skin >= self.world_from_mesh.len() {
            let from = nodes::describe(&self.document.root, node);
            return Err(GltfError::Reference { from, to: "skin", index: skin });
        }
        if self.world_from_mesh[skin].is_none() {
            self.world_from_mesh[skin] = Some(self.read(skin)?);
        }
        Ok(self.world_from_mesh[skin].as_deref().unwrap_or_default())
    }

    fn read(&self, skin: usize) -> Result<Vec<DAffine3>, GltfError> {
        let document = self.document;
        let from = || format!("skin {skin}");
        let JsonSkin { joints, inverse_bind_matrices } = from_value(document.skins[skin].clone())
            .map_err(|error| GltfError::Json { problem: format!("skins[{skin}]: {error}") })?;
        let inverses = match inverse_bind_matrices {
            Some(accessor) => {
                let inverses = Elements::open(document, accessor, Type::Mat4, from)?;
                if inverses.len() < joints.len() {
                    let (found, expected) = (inverses.len(), joints.len());
                    let problem = format!(
                        "has {found} inverse bind matrices, expected one for each of {expected} joints"
                    );
                    return Err(GltfError::Accessor { accessor: accessor.value(), problem });
                }
                Some(inverses)
            }
            None => None,
        };
        let world_from_mesh = joints.iter().enumerate().map(|(place, &joint)| {
            document.get(joint, from, "node")?;
            let world_from_joint = self.world_from_node[joint.value()].ok_or_else(|| GltfError::Value {
                what: from(),
                field: "the joint",
                found: nodes::describe(&document.root, joint.value()),
                expected: "a node of the scene",
            })?;
            let inverse = inverses.as_ref().map(|inverses| nodes::affine(&inverses.vector(place)));
            Ok(world_from_joint * inverse.unwrap_or(DAffine3::IDENTITY))
        });
        world_from_mesh.collect()
    }
}

impl Influences<'_> {
    /// What is wrong with the joints of these vertices, as the rest of a sentence about their accessor.
    fn problem(&self, vertices: &[u32]) -> Option<String> {
        if !matches!(self.joints.component(), ComponentType::U8 | ComponentType::U16) {
            return Some(format!("has {:?} joints, expected U8 or U16", self.joints.component()));
        }
        let count = self.world_from_mesh.len();
        let all = vertices.iter().flat_map(|&vertex| (0..4).map(move |place| (vertex, place)));
        let mut joints = all.map(|(vertex, place)| (vertex, self.joints.unsigned(vertex as usize, place)));
        let (vertex, joint) = joints.find(|&(_, joint)| joint as usize >= count)?;
        Some(format!("gives vertex {vertex} the joint {joint}, but its skin has {count}"))
    }

    /// The weighted mean of what the joints of a vertex do. Weights need not sum up to 1; where they sum up to
    /// 0, the first joint has all.
    pub(super) fn world_from_mesh(&self, vertex: u32) -> DAffine3 {
        let weights = self.weights.vector(vertex as usize).map(f64::from);
        let weights = match weights.iter().sum::<f64>() {
            0.0 => [1.0, 0.0, 0.0, 0.0],
            sum => weights.map(|weight| weight / sum),
        };
        let mut mean = DAffine3 { matrix3: DMat3::ZERO, translation: DVec3::ZERO };
        for (place, weight) in weights.into_iter().enumerate() {
            let joint = self.world_from_mesh[self.joints.unsigned(vertex as usize, place) as usize];
            mean.matrix3 += joint.matrix3 * weight;
            mean.translation += joint.translation * weight;
        }
        mean
    }
}
