//! What can be wrong with a glTF file. Each message is the rest of a sentence that names the file.

use std::path::PathBuf;

use crate::memory::Shortage;
use crate::shown::{shown, shown_path};

/// Why a glTF file was refused. Byte offsets and counts are the file's own.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "each message says what its fields mean")]
pub enum GltfError {
    /// Neither of the two formats.
    #[error("it is neither GLB (no \"glTF\" at its start) nor glTF (no JSON object)")]
    NotGltf,
    /// The JSON does not parse, or is not shaped as glTF is.
    #[error("its JSON is not valid glTF: {}", shown(problem))]
    Json { problem: String },
    /// Not glTF 2.
    #[error("it is glTF version \"{}\", expected 2.0; convert it first", shown(found))]
    Version { found: String },
    /// A GLB container of another version.
    #[error("its GLB container has version {found}, expected 2")]
    ContainerVersion { found: u32 },
    /// The GLB is shorter than its header says.
    #[error("its GLB header promises {stated} bytes, but the file has {found}: it is truncated")]
    Truncated { stated: u64, found: u64 },
    /// A GLB chunk that does not fit.
    #[error("its GLB chunk {chunk}, at byte {offset}, promises {stated} bytes, but only {left} are left")]
    ChunkLength { chunk: usize, offset: u64, stated: u64, left: u64 },
    /// A GLB whose first chunk is not JSON.
    #[error("its first GLB chunk is not JSON")]
    NoJsonChunk,
    /// An extension in `extensionsRequired` that is not supported.
    #[error(
        "it requires the extension {}, which is not supported (supported: {supported}); export it without",
        shown(name)
    )]
    RequiredExtension { name: String, supported: String },
    /// An index to something that does not exist.
    #[error("{from} refers to {to} {index}, which does not exist")]
    Reference { from: String, to: &'static str, index: usize },
    /// A node that is reached more than once, so that the nodes are no forest.
    #[error(
        "{node} is reached a second time, from {parent}; nodes must form trees, without cycles and with one parent each"
    )]
    NodeReachedTwice { node: String, parent: String },
    /// A transform that is not finite or cannot be inverted where it has to be.
    #[error("{node} has a transform that is not usable: {problem}")]
    Transform { node: String, problem: &'static str },
    /// Something about a primitive; the source says what.
    #[error("{node}, primitive {primitive} of mesh {mesh}")]
    Primitive { node: String, mesh: usize, primitive: usize, source: Box<GltfError> },
    /// A primitive mode that glTF does not have.
    #[error("its mode is none of glTF's seven")]
    Mode,
    /// A vertex index that is too large.
    #[error("index {place} is {index}, but there are only {vertices} vertices")]
    IndexOutOfRange { place: usize, index: u32, vertices: usize },
    /// A vertex attribute with another count than the positions.
    #[error("its {attribute} has {found} values for {expected} positions")]
    AttributeCount { attribute: String, found: usize, expected: usize },
    /// A vertex that is NaN or infinite, or becomes so in world space.
    #[error("vertex {vertex} is ({}, {}, {}){}, expected finite numbers", position[0], position[1], position[2], space)]
    VertexNotFinite { vertex: usize, position: [f64; 3], space: &'static str },
    /// An accessor that cannot be read; `problem` says why.
    #[error("accessor {accessor} {problem}")]
    Accessor { accessor: usize, problem: String },
    /// A buffer view that does not lie in its buffer.
    #[error("buffer view {view} covers bytes {start} to {end} of buffer {buffer}, which has {found}")]
    View { view: usize, start: u64, end: u64, buffer: usize, found: usize },
    /// A buffer that has no bytes.
    #[error("buffer {buffer} has no URI, and the file has no binary chunk for it")]
    NoBinaryChunk { buffer: usize },
    /// A buffer that is shorter than it says.
    #[error("buffer {buffer} promises {stated} bytes, but has {found}")]
    BufferLength { buffer: usize, stated: u64, found: u64 },
    /// A buffer or image whose URI cannot be read; the source says why.
    #[error("{what} cannot be read")]
    Uri { what: String, source: UriError },
    /// An image with neither a URI nor a buffer view.
    #[error("image {image} has neither a URI nor a buffer view")]
    NoImageData { image: usize },
    /// An image that does not decode.
    #[error("image {image} cannot be decoded as PNG or JPEG")]
    Image { image: usize, source: image::ImageError },
    /// A material whose numbers make no sense.
    #[error("{material} has {field} {found}, expected {expected}")]
    Material { material: String, field: &'static str, found: String, expected: &'static str },
    /// A light whose numbers make no sense.
    #[error("{light} has {field} {found}, expected {expected}")]
    Light { light: String, field: &'static str, found: String, expected: &'static str },
    /// More triangles or vertices than 32-bit indices can number.
    #[error(
        "flattened, it has {found} {what}, more than the {limit} that can be numbered; use fewer instances"
    )]
    TooLarge { what: &'static str, found: u64, limit: u64 },
    /// What would not fit into memory; the source says how much is missing.
    #[error("{what} do not fit; use smaller images, a simpler scene or fewer instances")]
    Memory { what: String, source: Shortage },
    /// The chosen scene of the file has no nodes.
    #[error("its scene {scene} has no nodes, so there is nothing to trace; make another one its default")]
    EmptyScene { scene: usize },
    /// A file with nothing to trace.
    #[error("it has no triangles in its scene")]
    NoTriangles,
}

/// Why the bytes behind a URI were not read.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "each message says what its fields mean")]
pub enum UriError {
    /// `http:` and its like.
    #[error(
        "its URI has the scheme \"{}\"; only relative paths and base64 data URIs are read",
        shown(scheme)
    )]
    Scheme { scheme: String },
    /// A data URI that is not base64.
    #[error("its data URI is not base64")]
    NotBase64,
    /// Bad base64.
    #[error("its data URI has invalid base64")]
    Base64 { source: base64::DecodeError },
    /// A path that is not UTF-8 when decoded.
    #[error("its URI \"{}\" is not UTF-8 when decoded", shown(uri))]
    NotUtf8 { uri: String },
    /// An absolute path.
    #[error("its URI \"{}\" is an absolute path, expected one relative to the glTF file", shown(uri))]
    Absolute { uri: String },
    /// A file that cannot be read, or a folder or device.
    #[error("cannot read {}", shown_path(path))]
    File { path: PathBuf, source: std::io::Error },
}
