//! What can be wrong with a glTF file. Each message is the rest of a sentence that names the file.

use std::path::PathBuf;

use crate::memory::Shortage;
use crate::shown::{shown, shown_path};

/// Why a glTF file was refused. Byte offsets and counts are the file's own.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "each message says what it and its fields mean")]
pub enum GltfError {
    #[error("it is neither GLB (no \"glTF\" at its start) nor glTF (no JSON object)")]
    NotGltf,
    /// The JSON does not parse, or is not shaped as glTF is.
    #[error("its JSON is not valid glTF: {}", shown(problem))]
    Json { problem: String },
    #[error("it is glTF version \"{}\", expected 2.0; convert it first", shown(found))]
    Version { found: String },
    #[error("its GLB container has version {found}, expected 2")]
    ContainerVersion { found: u32 },
    #[error("its GLB header promises {stated} bytes, but the file has {found}: it is truncated")]
    Truncated { stated: u64, found: u64 },
    #[error("its GLB chunk {chunk}, at byte {offset}, promises {stated} bytes, but only {left} are left")]
    ChunkLength { chunk: usize, offset: u64, stated: u64, left: u64 },
    #[error("its first GLB chunk is not JSON")]
    NoJsonChunk,
    #[error(
        "it requires the extension {}, which is not supported (supported: {supported}); export it without",
        shown(name)
    )]
    RequiredExtension { name: String, supported: String },
    #[error("{from} refers to {to} {index}, which does not exist")]
    Reference { from: String, to: &'static str, index: usize },
    #[error(
        "{node} is reached a second time, from {parent}; nodes must form trees, without cycles and with one parent each"
    )]
    NodeReachedTwice { node: String, parent: String },
    #[error("{node} has a transform that is not usable: {problem}")]
    Transform { node: String, problem: &'static str },
    /// Something about a primitive; the source says what.
    #[error("{node}, primitive {primitive} of mesh {mesh}")]
    Primitive { node: String, mesh: usize, primitive: usize, source: Box<GltfError> },
    #[error("its mode is none of glTF's seven")]
    Mode,
    #[error("index {place} is {index}, but there are only {vertices} vertices")]
    IndexOutOfRange { place: usize, index: u32, vertices: usize },
    #[error("its {attribute} has {found} values for {expected} positions")]
    AttributeCount { attribute: String, found: usize, expected: usize },
    /// A vertex that is NaN or infinite, or becomes so in world space.
    #[error("vertex {vertex} is ({}, {}, {}){}, expected finite numbers", position[0], position[1], position[2], space)]
    VertexNotFinite { vertex: usize, position: [f64; 3], space: &'static str },
    /// An accessor that cannot be read; `problem` says why.
    #[error("accessor {accessor} {problem}")]
    Accessor { accessor: usize, problem: String },
    #[error("buffer view {view} covers bytes {start} to {end} of buffer {buffer}, which has {found}")]
    View { view: usize, start: u64, end: u64, buffer: usize, found: usize },
    #[error("buffer {buffer} has no URI, and the file has no binary chunk for it")]
    NoBinaryChunk { buffer: usize },
    #[error("buffer {buffer} promises {stated} bytes, but has {found}")]
    BufferLength { buffer: usize, stated: u64, found: u64 },
    /// A buffer or image whose URI cannot be read; the source says why.
    #[error("{what} cannot be read")]
    Uri { what: String, source: UriError },
    #[error("image {image} has neither a URI nor a buffer view")]
    NoImageData { image: usize },
    #[error("image {image} cannot be decoded as PNG or JPEG")]
    Image { image: usize, source: image::ImageError },
    #[error("{what} has {field} {found}, expected {expected}")]
    Value { what: String, field: &'static str, found: String, expected: &'static str },
    /// More triangles or vertices than 32-bit indices can number.
    #[error(
        "flattened, it has {found} {what}, more than the {limit} that can be numbered; use fewer instances"
    )]
    TooLarge { what: &'static str, found: u64, limit: u64 },
    /// What would not fit into memory; the source says how much is missing.
    #[error("{what} do not fit; use smaller images, a simpler scene or fewer instances")]
    Memory { what: String, source: Shortage },
    #[error("its scene {scene} has no nodes, so there is nothing to trace; make another one its default")]
    EmptyScene { scene: usize },
    #[error("it has no triangles in its scene{}", if *has_others { ", only points or lines, which rays cannot hit" } else { "" })]
    NoTriangles { has_others: bool },
}

/// Why the bytes behind a URI were not read.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "each message says what it and its fields mean")]
pub enum UriError {
    /// `http:` and its like.
    #[error(
        "its URI has the scheme \"{}\"; only relative paths and base64 data URIs are read",
        shown(scheme)
    )]
    Scheme { scheme: String },
    #[error("its data URI is not base64")]
    NotBase64,
    #[error("its data URI has invalid base64")]
    Base64 { source: base64::DecodeError },
    #[error("its URI \"{}\" is not UTF-8 when decoded", shown(uri))]
    NotUtf8 { uri: String },
    #[error("its URI \"{}\" is an absolute path, expected one relative to the glTF file", shown(uri))]
    Absolute { uri: String },
    /// A file that cannot be read, or a folder or device.
    #[error("cannot read {}", shown_path(path))]
    File { path: PathBuf, source: std::io::Error },
}
