//! Import of glTF 2.0 files, `.gltf` and `.glb`: world-space triangles, materials, lights, cameras.
//!
//! The `gltf` crate gives the types that the JSON becomes; every index and every byte range is
//! checked here, since the files come from anywhere.
//!
//! What is read: node hierarchies (each instance is flattened), triangles, strips and fans, skins in
//! the pose of their nodes, perspective cameras, metallic-roughness materials with base-colour textures and alpha masks,
//! and [`SUPPORTED_EXTENSIONS`]. What is not is named in the scene's notices.

mod accessor;
mod buffers;
mod cameras;
mod container;
mod error;
mod flatten;
mod images;
mod lights;
mod lists;
mod materials;
mod nodes;
mod notices;
mod primitive;
mod skins;
mod uri;

use std::borrow::Cow;
use std::path::Path;

use ::gltf::json::{Index, Root, Value, root::Get};

use crate::{Light, Scene};

pub use container::SUPPORTED_EXTENSIONS;
pub use error::{GltfError, UriError};
use flatten::Flat;
use lists::Lists;
use notices::Notices;

/// A parsed file and the bytes that its accessors read.
struct Document<'a> {
    root: Root,
    /// As they stand in the file.
    cameras: Vec<Value>,
    /// As they stand in the file.
    skins: Vec<Value>,
    /// `None` where a buffer has no bytes of its own.
    buffers: Vec<Option<Cow<'a, [u8]>>>,
    /// Where relative URIs start.
    folder: &'a Path,
}

impl Document<'_> {
    /// What `index` refers to. `from` says whose reference it is, `to` what it should be ("mesh").
    fn get<T>(
        &self,
        index: Index<T>,
        from: impl FnOnce() -> String,
        to: &'static str,
    ) -> Result<&T, GltfError>
    where
        Root: Get<T>,
    {
        self.root.get(index).ok_or_else(|| GltfError::Reference { from: from(), to, index: index.value() })
    }
}

/// Reads a glTF file into a scene. It may lack cameras; its lights are the punctual ones, then the
/// emissive mesh primitives.
///
/// `bytes` are the file's, `folder` is where its relative URIs start, `name` becomes the scene's.
///
/// # Errors
/// What is wrong with the file or with a file that it refers to, with the node, primitive,
/// accessor or image at fault.
pub fn import(name: String, bytes: &[u8], folder: &Path) -> Result<Scene, GltfError> {
    let mut notices = Notices::default();
    let parsed = container::parse(bytes, &mut notices)?;
    container::note_extensions(&parsed.lists.root, &mut notices);
    let buffers = buffers::read(&parsed, folder)?;
    let Lists { root, cameras, skins } = parsed.lists;
    let document = Document { root, cameras, skins, buffers, folder };

    let nodes = nodes::place(&document)?;
    let flat = flatten::flatten(&document, &nodes, &mut notices)?;
    let (materials, textures) = materials::read(&document, &flat.material_is_used, &mut notices)?;
    let mut lights = lights::read(&document, &nodes, &mut notices)?;
    lights.extend(emissive_lights(&flat, &materials));
    let cameras = cameras::read(&document, &nodes, &mut notices)?;

    let Flat { positions, normals, mut uvs, triangles, triangle_materials, .. } = flat;
    if !textures.is_empty() {
        // Also for vertices without coordinates, and where no primitive has any.
        uvs.resize(positions.len(), [0.0; 2]);
    }
    Ok(Scene {
        name,
        positions,
        normals,
        uvs,
        triangles,
        triangle_materials,
        materials,
        textures,
        lights,
        cameras,
        notices: notices.into_sentences(),
    })
}

/// One light for each placed primitive whose material emits.
fn emissive_lights(flat: &Flat, materials: &[crate::Material]) -> impl Iterator<Item = Light> {
    flat.ranges.iter().filter(|range| materials[range.material as usize].is_emissive()).map(|range| {
        Light::Emissive { first_triangle: range.first_triangle, triangle_count: range.triangle_count }
    })
}
