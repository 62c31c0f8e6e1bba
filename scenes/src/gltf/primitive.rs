//! One mesh primitive in its own space: only the vertices it uses, and a list of triangles.

use std::ops::Range;

use ::gltf::json::accessor::{Accessor, ComponentType, Type};
use ::gltf::json::mesh::{Mode, Primitive, Semantic};
use ::gltf::json::{Index, validation::Checked};

use super::Document;
use super::accessor::Elements;
use super::error::GltfError;
use super::notices::Notices;

/// The largest number of vertices: all have 32-bit numbers.
pub(super) const LIMIT: u64 = u32::MAX as u64;

/// Triangles of one primitive, not yet placed.
pub(super) struct LocalMesh {
    /// Which vertex of the file each one is.
    pub(super) vertices: Vec<u32>,
    pub(super) positions: Vec<[f32; 3]>,
    /// One per position, or empty.
    pub(super) normals: Vec<[f32; 3]>,
    /// One per position, or empty.
    pub(super) uvs: Vec<[f32; 2]>,
    pub(super) triangles: Vec<[u32; 3]>,
}

/// Reads a primitive that has these positions. `None` if it consists of points or lines. `uv_set` is the
/// set of texture coordinates that its material's texture uses, if it has one.
pub(super) fn read(
    document: &Document,
    primitive: &Primitive,
    positions: Index<Accessor>,
    uv_set: Option<u32>,
    notices: &mut Notices,
) -> Result<Option<LocalMesh>, GltfError> {
    if is_points_or_lines(primitive) {
        return Ok(None);
    }
    let Checked::Valid(mode) = primitive.mode else {
        return Err(GltfError::Mode);
    };
    let positions = Elements::open(document, positions, Type::Vec3, || "the primitive".into())?;
    let mut indices = vertex_indices(document, primitive.indices, positions.len())?;
    if mode == Mode::Triangles && indices.len() % 3 != 0 {
        notices.count("primitives end in an incomplete triangle, which is ignored", 1);
        indices.truncate(indices.len() / 3 * 3);
    }
    let (vertices, indices) = compact(indices);
    let triangles = triangles(mode, &indices);

    let normals = attribute(document, primitive, Semantic::Normals, Type::Vec3)?;
    let uvs = match uv_set {
        Some(set) => attribute(document, primitive, Semantic::TexCoords(set), Type::Vec2)?,
        None => None,
    };
    Ok(Some(LocalMesh {
        positions: finite_positions(&positions, &vertices)?,
        normals: normals.map_or_else(Vec::new, |normals| gather(&normals, &vertices)),
        // A texel cannot be found at NaN; there is one at zero.
        uvs: uvs.map_or_else(Vec::new, |uvs| {
            let finite = |uv: [f32; 2]| uv.map(|x| if x.is_finite() { x } else { 0.0 });
            gather(&uvs, &vertices).into_iter().map(finite).collect()
        }),
        triangles,
        vertices,
    }))
}

/// Whether a primitive has nothing that a ray could hit.
pub(super) fn is_points_or_lines(primitive: &Primitive) -> bool {
    use Mode::{LineLoop, LineStrip, Lines, Points};

    matches!(primitive.mode, Checked::Valid(Points | Lines | LineLoop | LineStrip))
}

/// The values of an attribute, as many as there are positions; `None` if the primitive does not have it.
pub(super) fn attribute<'a>(
    document: &'a Document,
    primitive: &Primitive,
    semantic: Semantic,
    shape: Type,
) -> Result<Option<Elements<'a>>, GltfError> {
    let accessor = |semantic: &Semantic| primitive.attributes.get(&Checked::Valid(semantic.clone())).copied();
    let Some(values) = accessor(&semantic) else {
        return Ok(None);
    };
    let values = Elements::open(document, values, shape, || "the primitive".into())?;
    let positions = accessor(&Semantic::Positions).and_then(|positions| document.root.get(positions));
    let expected = positions.map_or(0, |positions| positions.count.0 as usize);
    match values.len() {
        found if found == expected => Ok(Some(values)),
        found => Err(GltfError::AttributeCount { attribute: semantic.to_string(), found, expected }),
    }
}

/// The primitive's vertex indices, in range; `0, 1, 2 …` if it has none.
fn vertex_indices(
    document: &Document,
    accessor: Option<Index<Accessor>>,
    vertices: usize,
) -> Result<Vec<u32>, GltfError> {
    let Some(accessor) = accessor else {
        return match u32::try_from(vertices) {
            Ok(count) => Ok((0..count).collect()),
            Err(_) => Err(GltfError::TooLarge { what: "vertices", found: vertices as u64, limit: LIMIT }),
        };
    };
    let elements = Elements::open(document, accessor, Type::Scalar, || "the primitive".into())?;
    if !matches!(elements.component(), ComponentType::U8 | ComponentType::U16 | ComponentType::U32) {
        return Err(GltfError::Accessor {
            accessor: accessor.value(),
            problem: format!("has {:?} indices, expected U8, U16 or U32", elements.component()),
        });
    }
    (0..elements.len())
        .map(|place| match elements.unsigned(place, 0) {
            index if (index as usize) < vertices => Ok(index),
            index => Err(GltfError::IndexOutOfRange { place, index, vertices }),
        })
        .collect()
}

/// The vertices that are used, ascending, and the indices into them. Exporters let hundreds of
/// primitives share one array of vertices; flattening must not copy all of it for each.
fn compact(mut indices: Vec<u32>) -> (Vec<u32>, Vec<u32>) {
    let range: Range<usize> = match (indices.iter().min(), indices.iter().max()) {
        (Some(&min), Some(&max)) => min as usize..max as usize + 1,
        _ => 0..0,
    };
    let mut place_of = vec![u32::MAX; range.len()];
    for &index in &indices {
        place_of[index as usize - range.start] = 0;
    }
    let mut vertices = Vec::new();
    for (place, index) in place_of.iter_mut().zip(range.clone()).filter(|(place, _)| **place == 0) {
        *place = vertices.len() as u32;
        vertices.push(index as u32);
    }
    for index in &mut indices {
        *index = place_of[*index as usize - range.start];
    }
    (vertices, indices)
}

/// Triangles from a list, strip or fan (glTF 2.0 §3.7.2.1), all with the same winding.
fn triangles(mode: Mode, indices: &[u32]) -> Vec<[u32; 3]> {
    let windows = indices.windows(3);
    match mode {
        // Every other triangle of a strip would be turned round.
        Mode::TriangleStrip => windows
            .enumerate()
            .map(|(place, three)| [three[0], three[1 + place % 2], three[2 - place % 2]])
            .collect(),
        Mode::TriangleFan => windows.map(|three| [three[1], three[2], indices[0]]).collect(),
        _ => indices.as_chunks().0.to_vec(),
    }
}

fn finite_positions(positions: &Elements, vertices: &[u32]) -> Result<Vec<[f32; 3]>, GltfError> {
    let read = |&vertex: &u32| {
        let position = positions.vector::<3>(vertex as usize);
        if position.iter().all(|x| x.is_finite()) {
            return Ok(position);
        }
        let position = position.map(f64::from);
        Err(GltfError::VertexNotFinite { vertex: vertex as usize, position, space: "" })
    };
    vertices.iter().map(read).collect()
}

fn gather<const N: usize>(elements: &Elements, vertices: &[u32]) -> Vec<[f32; N]> {
    vertices.iter().map(|&vertex| elements.vector(vertex as usize)).collect()
}
