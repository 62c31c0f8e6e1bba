//! From placed nodes to one soup of world-space triangles.

use std::collections::HashMap;
use std::rc::Rc;

use ::gltf::json::mesh::{Mesh, Primitive, Semantic};
use ::gltf::json::validation::Checked;
use glam::{DMat3, DVec3};

use super::Document;
use super::error::GltfError;
use super::nodes::{self, PlacedNode};
use super::notices::Notices;
use super::primitive::{self, LocalMesh};

/// The triangles of the whole scene. `normals` are as in [`crate::Scene`]; `uvs` end with the last
/// vertex that has any.
pub(super) struct Flat {
    pub(super) positions: Vec<[f32; 3]>,
    pub(super) normals: Vec<[f32; 3]>,
    pub(super) uvs: Vec<[f32; 2]>,
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) triangle_materials: Vec<u32>,
    /// One per primitive and instance, in order.
    pub(super) ranges: Vec<PlacedPrimitive>,
    /// Per material of the file, and one more for primitives without a material.
    pub(super) material_is_used: Vec<bool>,
    /// The largest number of vertices, and of triangles.
    limit: u64,
}

/// Where the triangles of one primitive of one instance lie.
pub(super) struct PlacedPrimitive {
    pub(super) first_triangle: u32,
    pub(super) triangle_count: u32,
    pub(super) material: u32,
}

/// Flattens the meshes of all placed nodes.
pub(super) fn flatten(
    document: &Document,
    nodes: &[PlacedNode],
    notices: &mut Notices,
) -> Result<Flat, GltfError> {
    let root = &document.root;
    let mesh_of = |node: &PlacedNode| root.nodes[node.index].mesh;
    let mut uses = vec![0_usize; root.meshes.len()];
    for mesh in nodes.iter().filter_map(mesh_of) {
        if let Some(uses) = uses.get_mut(mesh.value()) {
            *uses += 1;
        }
    }

    let mut flat = Flat::new(root.materials.len());
    let mut instanced: HashMap<(usize, usize), Option<Rc<LocalMesh>>> = HashMap::new();
    for node in nodes {
        let Some(index) = mesh_of(node) else { continue };
        let mesh = document.get(index, || nodes::describe(root, node.index), "mesh")?;
        note_what_is_ignored(document, node, mesh, notices);
        let placement = Placement::of(node);
        for (number, primitive) in mesh.primitives.iter().enumerate() {
            let in_primitive = |source| GltfError::Primitive {
                node: nodes::describe(root, node.index),
                mesh: index.value(),
                primitive: number,
                source: Box::new(source),
            };
            let uv_set = uv_set(document, primitive).map_err(in_primitive)?;
            let read = || Ok(primitive::read(document, primitive, uv_set)?.map(Rc::new));
            // Only what is met again is worth its memory.
            let local = if uses[index.value()] > 1 {
                let key = (index.value(), number);
                match instanced.get(&key) {
                    Some(known) => known.clone(),
                    None => instanced.entry(key).or_insert(read().map_err(in_primitive)?).clone(),
                }
            } else {
                read().map_err(in_primitive)?
            };
            let Some(local) = local else {
                notices.count("primitives of points or lines are skipped", 1);
                continue;
            };
            if uv_set.is_some() && local.uvs.is_empty() {
                notices.count("textured primitives without texture coordinates show one texel", 1);
            }
            let material = primitive.material.map_or(root.materials.len(), |material| material.value());
            flat.append(&local, &placement, material as u32).map_err(in_primitive)?;
        }
    }
    flat.finish(notices)
}

/// The set of texture coordinates that a primitive's base-colour texture uses.
fn uv_set(document: &Document, primitive: &Primitive) -> Result<Option<u32>, GltfError> {
    let Some(material) = primitive.material else {
        return Ok(None);
    };
    let material = document.get(material, || "the primitive".into(), "material")?;
    let texture = material.pbr_metallic_roughness.base_color_texture.as_ref();
    Ok(texture.map(|texture| texture.tex_coord))
}

fn note_what_is_ignored(document: &Document, node: &PlacedNode, mesh: &Mesh, notices: &mut Notices) {
    if document.root.nodes[node.index].skin.is_some() {
        notices.count("skinned meshes are shown in their bind pose", 1);
    }
    for primitive in &mesh.primitives {
        if primitive.targets.as_ref().is_some_and(|targets| !targets.is_empty()) {
            notices.count("primitives have morph targets, which are ignored", 1);
        }
        if primitive.attributes.contains_key(&Checked::Valid(Semantic::Colors(0))) {
            notices.count("primitives have vertex colours, which are ignored", 1);
        }
    }
}

/// How one node's meshes get into the world.
struct Placement {
    world_from_node: glam::DAffine3,
    /// For normals: the inverse transpose up to a positive factor.
    normal_matrix: DMat3,
    /// Whether it mirrors, which turns the winding of triangles round.
    mirrors: bool,
}

impl Placement {
    fn of(node: &PlacedNode) -> Self {
        let matrix = node.world_from_node.matrix3;
        let mirrors = matrix.determinant() < 0.0;
        // The cofactors are the inverse transpose times the determinant, and exist where the
        // inverse does not: a mesh scaled flat keeps its normals.
        let sign = if mirrors { -1.0 } else { 1.0 };
        let [x, y, z] = [matrix.x_axis, matrix.y_axis, matrix.z_axis];
        let normal_matrix = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y)) * sign;
        Self { world_from_node: node.world_from_node, normal_matrix, mirrors }
    }

    fn position(&self, position: [f32; 3]) -> [f64; 3] {
        let position = DVec3::from_array(position.map(f64::from));
        self.world_from_node.transform_point3(position).to_array()
    }

    /// A unit vector, or zero if there is no direction to be had.
    fn normal(&self, normal: [f32; 3]) -> [f32; 3] {
        let normal = self.normal_matrix * DVec3::from_array(normal.map(f64::from));
        normal.normalize_or_zero().to_array().map(|x| x as f32)
    }
}

impl Flat {
    fn new(materials: usize) -> Self {
        Self {
            positions: Vec::new(),
            normals: Vec::new(),
            uvs: Vec::new(),
            triangles: Vec::new(),
            triangle_materials: Vec::new(),
            ranges: Vec::new(),
            material_is_used: vec![false; materials + 1],
            limit: u64::from(u32::MAX),
        }
    }

    /// Adds one instance of a primitive.
    fn append(&mut self, local: &LocalMesh, placement: &Placement, material: u32) -> Result<(), GltfError> {
        if local.triangles.is_empty() {
            return Ok(());
        }
        let first_vertex = grow(&mut self.positions, local.positions.len(), "vertices", self.limit)?;
        let first_triangle = grow(&mut self.triangles, local.triangles.len(), "triangles", self.limit)?;
        grow(&mut self.triangle_materials, local.triangles.len(), "triangles", self.limit)?;

        for (&vertex, &position) in local.vertices.iter().zip(&local.positions) {
            let exact = placement.position(position);
            let position = exact.map(|x| x as f32);
            if !position.iter().all(|x| x.is_finite()) {
                let (vertex, space) = (vertex as usize, " in world space");
                return Err(GltfError::VertexNotFinite { vertex, position: exact, space });
            }
            self.positions.push(position);
        }
        if !local.normals.is_empty() {
            self.normals.resize(first_vertex as usize, [0.0; 3]);
            self.normals.extend(local.normals.iter().map(|&normal| placement.normal(normal)));
        }
        if !local.uvs.is_empty() {
            self.uvs.resize(first_vertex as usize, [0.0; 2]);
            self.uvs.extend_from_slice(&local.uvs);
        }
        self.triangles.extend(local.triangles.iter().map(|&[a, b, c]| {
            let [b, c] = if placement.mirrors { [c, b] } else { [b, c] };
            [a, b, c].map(|vertex| first_vertex + vertex)
        }));
        self.triangle_materials.resize(self.triangles.len(), material);
        self.material_is_used[material as usize] = true;
        let triangle_count = local.triangles.len() as u32;
        self.ranges.push(PlacedPrimitive { first_triangle, triangle_count, material });
        Ok(())
    }

    /// Fills up what only some primitives have, and counts degenerate triangles.
    fn finish(mut self, notices: &mut Notices) -> Result<Self, GltfError> {
        if self.triangles.is_empty() {
            return Err(GltfError::NoTriangles);
        }
        if !self.normals.is_empty() {
            self.normals.resize(self.positions.len(), [0.0; 3]);
        }
        let degenerate = self.triangles.iter().filter(|triangle| self.is_degenerate(triangle)).count();
        notices.count("degenerate triangles stay in the scene and are never hit", degenerate);
        Ok(self)
    }

    /// Whether a triangle has no area.
    fn is_degenerate(&self, triangle: &[u32; 3]) -> bool {
        let [a, b, c] =
            triangle.map(|vertex| DVec3::from_array(self.positions[vertex as usize].map(f64::from)));
        (b - a).cross(c - a) == DVec3::ZERO
    }
}

/// Makes room for `count` more items and returns the number of the first. At most `limit` in all.
fn grow<T>(items: &mut Vec<T>, count: usize, what: &'static str, limit: u64) -> Result<u32, GltfError> {
    if (items.len() + count) as u64 > limit {
        return Err(GltfError::TooLarge { what, limit });
    }
    match items.try_reserve(count) {
        Ok(()) => Ok(items.len() as u32),
        Err(_) => Err(GltfError::Memory { what, count: items.len() + count }),
    }
}
