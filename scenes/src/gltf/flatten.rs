//! From placed nodes to one list of world-space triangles.

use ::gltf::json::mesh::{Mesh, Mode, Primitive, Semantic};
use ::gltf::json::texture::Info;
use ::gltf::json::validation::Checked;
use glam::{DAffine3, DMat3, DVec3};

use super::Document;
use super::accessor;
use super::error::GltfError;
use super::materials;
use super::nodes::{self, PlacedNode};
use super::notices::Notices;
use super::primitive::{self, LIMIT, LocalMesh};
use super::skins::Skins;
use crate::bvh::{BYTES_PER_TRIANGLE, TRIANGLE_LIMIT};
use crate::memory;

/// The triangles of the whole scene. `normals` are as in [`crate::Scene`]; `uvs` end with the last
/// vertex that has any.
#[derive(Default)]
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
}

/// Where the triangles of one primitive of one instance lie.
pub(super) struct PlacedPrimitive {
    pub(super) first_triangle: u32,
    pub(super) triangle_count: u32,
    pub(super) material: u32,
}

/// One primitive of a mesh that has triangles.
struct LocalPrimitive {
    /// Its number in the mesh.
    number: usize,
    triangles: LocalMesh,
    material: u32,
}

/// Flattens the meshes of all placed nodes.
pub(super) fn flatten(
    document: &Document,
    nodes: &[PlacedNode],
    notices: &mut Notices,
) -> Result<Flat, GltfError> {
    let root = &document.root;
    let mut instances: Vec<(&PlacedNode, usize)> = Vec::new();
    for node in nodes {
        let json = &root.nodes[node.index];
        let Some(mesh) = json.mesh else { continue };
        document.get(mesh, || nodes::describe(root, node.index), "mesh")?;
        instances.push((node, mesh.value()));
    }
    // Nothing large is made before its size is known, so that too large a scene is refused at once.
    check_claim(document, &instances, memory::free())?;
    let mut meshes: Vec<Option<Vec<LocalPrimitive>>> = Vec::new();
    meshes.resize_with(root.meshes.len(), || None);
    for &(node, mesh) in &instances {
        if meshes[mesh].is_none() {
            let read = read_mesh(document, &root.meshes[mesh], notices);
            meshes[mesh] = Some(read.map_err(|(number, source)| at(document, node, mesh, number, source))?);
        }
    }
    let mut flat = Flat::new(root.materials.len());
    let placed = instances.iter().flat_map(|&(_, mesh)| meshes[mesh].iter().flatten());
    flat.reserve(placed, LIMIT, memory::free())?;
    let mut skins = Skins::of(document, nodes);
    for &(node, mesh) in &instances {
        let of_node = Placement::of(node.world_from_node);
        for primitive in meshes[mesh].iter().flatten() {
            let failed = |source| at(document, node, mesh, primitive.number, source);
            let json = &root.meshes[mesh].primitives[primitive.number];
            let vertices = &primitive.triangles.vertices;
            let influences = skins.influences(node.index, json, vertices, notices).map_err(failed)?;
            let appended = match influences {
                Some(influences) => {
                    flat.append(primitive, |vertex| Placement::of(influences.world_from_mesh(vertex)))
                }
                None => flat.append(primitive, |_| of_node),
            };
            appended.map_err(failed)?;
        }
    }
    if flat.triangles.is_empty() {
        let mut primitives = instances.iter().flat_map(|&(_, mesh)| &root.meshes[mesh].primitives);
        return Err(GltfError::NoTriangles { has_others: primitives.any(primitive::is_points_or_lines) });
    }
    Ok(flat.finish(notices))
}

/// Refuses instances that have more triangles than can be numbered or than fit into `free` bytes, by what
/// the accessors of their meshes claim.
fn check_claim(document: &Document, instances: &[(&PlacedNode, usize)], free: u64) -> Result<(), GltfError> {
    let of_mesh: Vec<u64> = document
        .root
        .meshes
        .iter()
        .map(|mesh| mesh.primitives.iter().map(|primitive| claimed_triangles(document, primitive)).sum())
        .collect();
    let found = instances.iter().fold(0_u64, |all, &(_, mesh)| all.saturating_add(of_mesh[mesh]));
    let limit = TRIANGLE_LIMIT as u64;
    if found > limit {
        return Err(GltfError::TooLarge { what: "triangles", found, limit });
    }
    memory::check(found * BYTES_PER_TRIANGLE, free)
        .map_err(|source| GltfError::Memory { what: format!("its {found} triangles, flattened,"), source })
}

/// Triangles of a primitive, as far as its accessors can be right; 0 if it has none.
fn claimed_triangles(document: &Document, primitive: &Primitive) -> u64 {
    let positions = primitive.attributes.get(&Checked::Valid(Semantic::Positions));
    let Some(&positions) = positions else { return 0 };
    let count = accessor::plausible_count(document, primitive.indices.unwrap_or(positions));
    match primitive.mode {
        Checked::Valid(Mode::Triangles) => count / 3,
        Checked::Valid(Mode::TriangleStrip | Mode::TriangleFan) => count.saturating_sub(2),
        _ => 0,
    }
}

/// An error, and the primitive at fault.
fn at(document: &Document, node: &PlacedNode, mesh: usize, primitive: usize, source: GltfError) -> GltfError {
    let node = nodes::describe(&document.root, node.index);
    GltfError::Primitive { node, mesh, primitive, source: Box::new(source) }
}

/// Reads the primitives of a mesh, without those of points and lines. An error comes with the
/// number of its primitive.
fn read_mesh(
    document: &Document,
    mesh: &Mesh,
    notices: &mut Notices,
) -> Result<Vec<LocalPrimitive>, (usize, GltfError)> {
    let mut read = Vec::with_capacity(mesh.primitives.len());
    for (number, primitive) in mesh.primitives.iter().enumerate() {
        let Some(&positions) = primitive.attributes.get(&Checked::Valid(Semantic::Positions)) else {
            notices.count("primitives without positions are skipped", 1);
            continue;
        };
        let uv_set = uv_set(document, primitive).map_err(|error| (number, error))?;
        let triangles = primitive::read(document, primitive, positions, uv_set, notices)
            .map_err(|error| (number, error))?;
        let Some(triangles) = triangles else {
            notices.count("primitives of points or lines are skipped", 1);
            continue;
        };
        if uv_set.is_some() && triangles.uvs.is_empty() {
            notices.count("textured primitives without texture coordinates show one texel", 1);
        }
        if primitive.targets.as_ref().is_some_and(|targets| !targets.is_empty()) {
            notices.count("primitives have morph targets, which are ignored", 1);
        }
        if primitive.attributes.contains_key(&Checked::Valid(Semantic::Colors(0))) {
            notices.count("primitives have vertex colours, which are ignored", 1);
        }
        let material = primitive.material.map_or(document.root.materials.len(), |material| material.value());
        if !triangles.triangles.is_empty() {
            read.push(LocalPrimitive { number, triangles, material: material as u32 });
        }
    }
    Ok(read)
}

/// The set of texture coordinates that a primitive's base-colour texture uses.
fn uv_set(document: &Document, primitive: &Primitive) -> Result<Option<u32>, GltfError> {
    let Some(material) = primitive.material else {
        return Ok(None);
    };
    let material = document.get(material, || "the primitive".into(), "material")?;
    let has_image = |texture: &&Info| document.root.get(texture.index).and_then(materials::source).is_some();
    Ok(materials::base_color_texture(material).filter(has_image).map(|texture| texture.tex_coord))
}

/// How a node's meshes, or single vertices of a skinned one, get into the world.
#[derive(Clone, Copy)]
struct Placement {
    world_from_mesh: DAffine3,
    /// For normals: the inverse transpose up to a positive factor.
    normal_matrix: DMat3,
    /// Whether it mirrors, which turns the winding of triangles round.
    mirrors: bool,
}

impl Placement {
    fn of(world_from_mesh: DAffine3) -> Self {
        let matrix = world_from_mesh.matrix3;
        let mirrors = matrix.determinant() < 0.0;
        // The cofactors are the inverse transpose times the determinant, and exist where the
        // inverse does not: a mesh scaled flat keeps its normals.
        let sign = if mirrors { -1.0 } else { 1.0 };
        let [x, y, z] = [matrix.x_axis, matrix.y_axis, matrix.z_axis];
        let normal_matrix = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y)) * sign;
        Self { world_from_mesh, normal_matrix, mirrors }
    }

    fn position(&self, position: [f32; 3]) -> [f64; 3] {
        let position = DVec3::from_array(position.map(f64::from));
        self.world_from_mesh.transform_point3(position).to_array()
    }

    /// A unit vector, or zero if there is no direction to be had.
    fn normal(&self, normal: [f32; 3]) -> [f32; 3] {
        let normal = self.normal_matrix * DVec3::from_array(normal.map(f64::from));
        normal.normalize_or_zero().to_array().map(|x| x as f32)
    }
}

impl Flat {
    fn new(materials: usize) -> Self {
        Self { material_is_used: vec![false; materials + 1], ..Self::default() }
    }

    /// Makes room for all primitives: at most `limit` vertices and as many triangles, in `free` bytes.
    fn reserve<'a>(
        &mut self,
        primitives: impl Iterator<Item = &'a LocalPrimitive>,
        limit: u64,
        free: u64,
    ) -> Result<(), GltfError> {
        let (mut vertices, mut triangles, mut has_normals, mut has_uvs) = (0, 0, false, false);
        for LocalPrimitive { triangles: local, .. } in primitives {
            vertices += local.positions.len() as u64;
            triangles += local.triangles.len() as u64;
            has_normals |= !local.normals.is_empty();
            has_uvs |= !local.uvs.is_empty();
        }
        if vertices > limit {
            return Err(GltfError::TooLarge { what: "vertices", found: vertices, limit });
        }
        if triangles > limit {
            return Err(GltfError::TooLarge { what: "triangles", found: triangles, limit });
        }
        let (normals, uvs) = (u64::from(has_normals) * vertices, u64::from(has_uvs) * vertices);
        let needed = 12 * (vertices + normals) + 8 * uvs + BYTES_PER_TRIANGLE * triangles;
        memory::check(needed, free).map_err(|source| {
            let what = format!("its {triangles} triangles with {vertices} vertices, flattened,");
            GltfError::Memory { what, source }
        })?;
        self.positions.reserve_exact(vertices as usize);
        self.normals.reserve_exact(normals as usize);
        self.uvs.reserve_exact(uvs as usize);
        self.triangles.reserve_exact(triangles as usize);
        self.triangle_materials.reserve_exact(triangles as usize);
        Ok(())
    }

    /// Adds one instance of a primitive. `placement_of` takes vertices by their numbers in the file; the first
    /// one of a triangle says whether it is mirrored.
    fn append(
        &mut self,
        primitive: &LocalPrimitive,
        placement_of: impl Fn(u32) -> Placement,
    ) -> Result<(), GltfError> {
        let &LocalPrimitive { triangles: ref local, material, .. } = primitive;
        let first_vertex = self.positions.len() as u32;
        let first_triangle = self.triangles.len() as u32;
        for (&vertex, &position) in local.vertices.iter().zip(&local.positions) {
            let exact = placement_of(vertex).position(position);
            let position = exact.map(|x| x as f32);
            if !position.iter().all(|x| x.is_finite()) {
                let (vertex, space) = (vertex as usize, " in world space");
                return Err(GltfError::VertexNotFinite { vertex, position: exact, space });
            }
            self.positions.push(position);
        }
        if !local.normals.is_empty() {
            self.normals.resize(first_vertex as usize, [0.0; 3]);
            let normals = local.vertices.iter().zip(&local.normals);
            self.normals.extend(normals.map(|(&vertex, &normal)| placement_of(vertex).normal(normal)));
        }
        if !local.uvs.is_empty() {
            self.uvs.resize(first_vertex as usize, [0.0; 2]);
            self.uvs.extend_from_slice(&local.uvs);
        }
        self.triangles.extend(local.triangles.iter().map(|&[a, b, c]| {
            let mirrors = placement_of(local.vertices[a as usize]).mirrors;
            let [b, c] = if mirrors { [c, b] } else { [b, c] };
            [a, b, c].map(|vertex| first_vertex + vertex)
        }));
        self.triangle_materials.resize(self.triangles.len(), material);
        self.material_is_used[material as usize] = true;
        let triangle_count = local.triangles.len() as u32;
        self.ranges.push(PlacedPrimitive { first_triangle, triangle_count, material });
        Ok(())
    }

    /// Fills up what only some primitives have, and counts degenerate triangles.
    fn finish(mut self, notices: &mut Notices) -> Self {
        if !self.normals.is_empty() {
            self.normals.resize(self.positions.len(), [0.0; 3]);
        }
        let degenerate = self.triangles.iter().filter(|triangle| self.is_degenerate(triangle)).count();
        notices.count("degenerate triangles stay in the scene and are never hit", degenerate);
        self
    }

    /// Whether a triangle has no area.
    fn is_degenerate(&self, triangle: &[u32; 3]) -> bool {
        let [a, b, c] =
            triangle.map(|vertex| DVec3::from_array(self.positions[vertex as usize].map(f64::from)));
        (b - a).cross(c - a) == DVec3::ZERO
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_32_bits_cannot_number_is_refused_before_it_is_made() {
        let triangles = LocalMesh {
            vertices: vec![0, 1, 2],
            positions: vec![[0.0; 3]; 3],
            normals: Vec::new(),
            uvs: Vec::new(),
            triangles: vec![[0, 1, 2]; 4],
        };
        let primitive = LocalPrimitive { number: 0, triangles, material: 0 };
        let refusal = |count: usize, limit: u64, free: u64| {
            let mut flat = Flat::new(0);
            let error = flat.reserve(std::iter::repeat_n(&primitive, count), limit, free).unwrap_err();
            assert_eq!(flat.triangles.capacity(), 0);
            error.to_string()
        };
        let needed = 5 * 3 * 12 + 20 * BYTES_PER_TRIANGLE;
        assert!(Flat::new(0).reserve(std::iter::repeat_n(&primitive, 5), 20, needed).is_ok());
        assert!(refusal(5, 19, needed).contains("has 20 triangles, more than the 19 that"));
        assert!(refusal(5, 14, needed).contains("has 15 vertices, more than the 14 that"));
        let expected = "its 20 triangles with 15 vertices, flattened, do not fit";
        assert!(refusal(5, 20, needed - 1).starts_with(expected));
    }
}
