//! Makes tiny glTF files.

use std::error::Error;
use std::fs;
use std::path::Path;

use scenes::Scene;
use serde_json::{Value, json};

/// Component types of accessors.
pub(crate) const I8: u32 = 5120;
pub(crate) const U8: u32 = 5121;
pub(crate) const I16: u32 = 5122;
pub(crate) const U16: u32 = 5123;
pub(crate) const U32: u32 = 5125;
pub(crate) const F32: u32 = 5126;

/// A triangle in the plane z = 0 that faces +z.
pub(crate) const TRIANGLE: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

/// A glTF file that grows.
#[derive(Clone)]
pub(crate) struct Fixture {
    /// All of the JSON but the buffer.
    pub(crate) json: Value,
    /// Buffer 0.
    pub(crate) binary: Vec<u8>,
}

impl Fixture {
    /// A file with an empty scene.
    pub(crate) fn new() -> Self {
        Self {
            json: json!({ "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [] }] }),
            binary: Vec::new(),
        }
    }

    /// A file with [`TRIANGLE`] at the origin: node 0, mesh 0, accessor 0.
    pub(crate) fn triangle() -> Self {
        let mut fixture = Self::new();
        let positions = fixture.vectors(&TRIANGLE);
        fixture.primitive(json!({ "attributes": { "POSITION": positions } }));
        fixture
    }

    /// Appends to one of the lists of the file and returns the number of the new item.
    pub(crate) fn push(&mut self, list: &str, item: Value) -> usize {
        let list = &mut self.json[list];
        if list.is_null() {
            *list = json!([]);
        }
        let list = list.as_array_mut().expect("it was made a list");
        list.push(item);
        list.len() - 1
    }

    /// A node at the root of the scene.
    pub(crate) fn node(&mut self, node: Value) -> usize {
        let index = self.push("nodes", node);
        let roots = self.json["scenes"][0]["nodes"].as_array_mut().expect("the scene lists nodes");
        roots.push(json!(index));
        index
    }

    /// A mesh of one primitive in a node of its own.
    pub(crate) fn primitive(&mut self, primitive: Value) -> usize {
        let mesh = self.push("meshes", json!({ "primitives": [primitive] }));
        self.node(json!({ "mesh": mesh }))
    }

    /// A buffer view of these bytes.
    pub(crate) fn view(&mut self, bytes: &[u8]) -> usize {
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        let start = self.binary.len();
        self.binary.extend_from_slice(bytes);
        self.push("bufferViews", json!({ "buffer": 0, "byteOffset": start, "byteLength": bytes.len() }))
    }

    /// An accessor that reads a view of its own.
    pub(crate) fn accessor(&mut self, bytes: &[u8], component: u32, kind: &str, count: usize) -> usize {
        let view = self.view(bytes);
        let accessor =
            json!({ "bufferView": view, "componentType": component, "type": kind, "count": count });
        self.push("accessors", accessor)
    }

    /// An accessor of vectors of f32.
    pub(crate) fn vectors<const N: usize>(&mut self, vectors: &[[f32; N]]) -> usize {
        let bytes = le_bytes(vectors.as_flattened());
        self.accessor(&bytes, F32, &format!("VEC{N}"), vectors.len())
    }

    /// An accessor of u32 indices.
    pub(crate) fn indices(&mut self, indices: &[u32]) -> usize {
        let bytes: Vec<u8> = indices.iter().flat_map(|index| index.to_le_bytes()).collect();
        self.accessor(&bytes, U32, "SCALAR", indices.len())
    }

    /// The JSON with its buffer, which has this URI or is the binary chunk.
    pub(crate) fn json_with_buffer(&self, uri: Option<&str>) -> Vec<u8> {
        let mut json = self.json.clone();
        if json["buffers"].is_null() && !self.binary.is_empty() {
            json["buffers"] = json!([{ "byteLength": self.binary.len() }]);
            if let Some(uri) = uri {
                json["buffers"][0]["uri"] = json!(uri);
            }
        }
        serde_json::to_vec(&json).expect("JSON values serialise")
    }

    /// The whole as a GLB file.
    pub(crate) fn glb(&self) -> Vec<u8> {
        let mut json = self.json_with_buffer(None);
        json.resize(json.len().next_multiple_of(4), b' ');
        let mut binary = self.binary.clone();
        binary.resize(binary.len().next_multiple_of(4), 0);
        let mut chunks = chunk(b"JSON", &json);
        if !binary.is_empty() {
            chunks.extend(chunk(b"BIN\0", &binary));
        }
        glb_of_chunks(&chunks)
    }

    /// Loads it as a GLB file. A refusal comes as the sentence that users read, without the path.
    pub(crate) fn load(&self) -> Result<Scene, String> {
        load_bytes("scene.glb", &self.glb())
    }

    /// Loads what must load.
    #[track_caller]
    pub(crate) fn scene(&self) -> Scene {
        match self.load() {
            Ok(scene) => {
                check_invariants(&scene);
                scene
            }
            Err(message) => panic!("refused: {message}"),
        }
    }
}

/// One chunk of a GLB file.
pub(crate) fn chunk(kind: &[u8; 4], data: &[u8]) -> Vec<u8> {
    [&(data.len() as u32).to_le_bytes()[..], kind, data].concat()
}

/// A GLB file with a truthful header.
pub(crate) fn glb_of_chunks(chunks: &[u8]) -> Vec<u8> {
    let length = (12 + chunks.len() as u32).to_le_bytes();
    [b"glTF".as_slice(), &2_u32.to_le_bytes(), &length, chunks].concat()
}

/// Writes a file of this name into a folder of its own and loads it.
pub(crate) fn load_bytes(name: &str, bytes: &[u8]) -> Result<Scene, String> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    fs::write(folder.path().join(name), bytes).expect("a temporary file");
    load_in(folder.path(), name)
}

/// Loads a file of a folder; an error becomes its whole sentence, without the folder.
pub(crate) fn load_in(folder: &Path, name: &str) -> Result<Scene, String> {
    let path = folder.join(name);
    let path = path.to_str().expect("temporary folders have plain names");
    scenes::load(path).map_err(|error| sentence(&error).replace(&path.replace(name, ""), ""))
}

/// An error with all its causes, as anyhow prints it with `{:#}`.
pub(crate) fn sentence(error: &dyn Error) -> String {
    match error.source() {
        Some(source) => format!("{error}: {}", sentence(source)),
        None => error.to_string(),
    }
}

pub(crate) fn le_bytes(floats: &[f32]) -> Vec<u8> {
    floats.iter().flat_map(|x| x.to_le_bytes()).collect()
}

/// What holds for the scene of any file.
#[track_caller]
pub(crate) fn check_invariants(scene: &Scene) {
    let vertices = scene.positions.len();
    assert!(!scene.triangles.is_empty() && !scene.cameras.is_empty() && !scene.materials.is_empty());
    assert!(!scene.lights.is_empty());
    assert!(scene.positions.iter().flatten().all(|x| x.is_finite()));
    assert!(scene.triangles.iter().flatten().all(|&vertex| (vertex as usize) < vertices));
    assert_eq!(scene.triangle_materials.len(), scene.triangles.len());
    assert!(scene.triangle_materials.iter().all(|&material| (material as usize) < scene.materials.len()));
    assert!(scene.normals.is_empty() || scene.normals.len() == vertices);
    for normal in &scene.normals {
        let length = normal.iter().map(|x| x * x).sum::<f32>().sqrt();
        assert!(length == 0.0 || (length - 1.0).abs() < 1e-5, "normal {normal:?}");
    }
    let is_textured = scene.materials.iter().any(|material| material.base_color_texture.is_some());
    assert_eq!(scene.uvs.len(), if is_textured { vertices } else { 0 });
    assert!(scene.uvs.iter().flatten().all(|x| x.is_finite()));
    for material in &scene.materials {
        assert!(material.base_color_texture.is_none_or(|texture| (texture as usize) < scene.textures.len()));
    }
    for texture in &scene.textures {
        assert_eq!(texture.rgba.len(), (texture.width * texture.height) as usize);
    }
    for (place, camera) in scene.cameras.iter().enumerate() {
        assert!(scene.cameras[..place].iter().all(|other| other.name != camera.name));
    }
}

/// The world-space corners of all triangles.
pub(crate) fn corners(scene: &Scene) -> Vec<[[f32; 3]; 3]> {
    (0..scene.triangles.len()).map(|triangle| scene.corners(triangle)).collect()
}
