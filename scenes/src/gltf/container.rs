//! From bytes to JSON and binary chunk: the GLB container (glTF 2.0 §4) and the checks that come
//! before the JSON is believed.

use ::gltf::json::{Root, Value, deserialize::from_slice};
use serde::Deserialize;

use super::error::GltfError;
use super::lists::{self, Lists};
use super::notices::Notices;
use crate::shown::shown;

/// Extensions that a file may require.
pub const SUPPORTED_EXTENSIONS: [&str; 4] = [
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    lists::SPECULAR_GLOSSINESS,
    "KHR_mesh_quantization",
];

const GLB_MAGIC: &[u8] = b"glTF";
const BYTE_ORDER_MARK: &[u8] = "\u{feff}".as_bytes();
const GLB_HEADER_BYTES: usize = 12;
const CHUNK_HEADER_BYTES: usize = 8;
const CHUNK_JSON: u32 = u32::from_le_bytes(*b"JSON");
const CHUNK_BINARY: u32 = u32::from_le_bytes(*b"BIN\0");

/// The JSON of a file, and its binary chunk if it has one.
pub(super) struct Parsed<'a> {
    pub(super) lists: Lists,
    pub(super) binary: Option<&'a [u8]>,
}

/// The part of the JSON that says whether the rest can be understood.
#[derive(Deserialize)]
struct Preamble {
    asset: PreambleAsset,
    #[serde(default, rename = "extensionsRequired")]
    extensions_required: Vec<String>,
}

#[derive(Deserialize)]
struct PreambleAsset {
    version: Value,
    #[serde(rename = "minVersion")]
    min_version: Option<Value>,
}

/// Splits and parses a file.
pub(super) fn parse<'a>(bytes: &'a [u8], notices: &mut Notices) -> Result<Parsed<'a>, GltfError> {
    // JSON must not start with a byte order mark, and some editors write one (RFC 8259 §8.1).
    let bytes = bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(bytes);
    let (json, binary) = if bytes.starts_with(GLB_MAGIC) {
        split_glb(bytes)?
    } else if bytes.trim_ascii_start().starts_with(b"{") {
        (bytes, None)
    } else {
        return Err(GltfError::NotGltf);
    };
    let preamble: Preamble =
        from_slice(json).map_err(|error| GltfError::Json { problem: error.to_string() })?;
    check_preamble(preamble)?;
    Ok(Parsed { lists: lists::parse(json, notices)?, binary })
}

/// Refuses other versions and required extensions by name, before their effect on the rest of the
/// JSON becomes a puzzling error.
fn check_preamble(preamble: Preamble) -> Result<(), GltfError> {
    let PreambleAsset { version, min_version } = preamble.asset;
    let (version, min_version) = (version_text(&version), min_version.as_ref().map(version_text));
    let needed = min_version.as_ref().unwrap_or(&version);
    let is_supported = match min_version {
        Some(_) => needed == "2.0",
        None => version.starts_with("2."),
    };
    if !is_supported {
        return Err(GltfError::Version { found: needed.clone() });
    }
    let is_supported = |name: &String| SUPPORTED_EXTENSIONS.contains(&name.as_str());
    match preamble.extensions_required.into_iter().find(|name| !is_supported(name)) {
        Some(name) => Err(GltfError::RequiredExtension { name, supported: SUPPORTED_EXTENSIONS.join(", ") }),
        None => Ok(()),
    }
}

/// A version, which some files have as a number: 1 is version 1.0.
fn version_text(version: &Value) -> String {
    match (version.as_str(), version.as_f64()) {
        (Some(text), _) => text.into(),
        (None, Some(number)) => format!("{number:?}"),
        (None, None) => version.to_string(),
    }
}

/// One notice for each extension that the file uses and that has no effect here.
pub(super) fn note_extensions(root: &Root, notices: &mut Notices) {
    let mut names: Vec<&str> = root.extensions_used.iter().map(String::as_str).collect();
    names.sort_unstable();
    names.dedup();
    for name in names.into_iter().filter(|name| !SUPPORTED_EXTENSIONS.contains(name)) {
        notices.say(format!("the extension {} is not supported and has no effect", shown(name)));
    }
}

/// The JSON and binary chunks of a GLB file.
fn split_glb(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), GltfError> {
    let truncated = |stated: usize| GltfError::Truncated { stated: stated as u64, found: bytes.len() as u64 };
    let version = word(bytes, 4).ok_or_else(|| truncated(GLB_HEADER_BYTES))?;
    let length = word(bytes, 8).ok_or_else(|| truncated(GLB_HEADER_BYTES))? as usize;
    if version != 2 {
        return Err(GltfError::ContainerVersion { found: version });
    }
    let bytes = bytes.get(..length).ok_or_else(|| truncated(length))?;

    let mut chunks = Vec::new();
    let mut offset = GLB_HEADER_BYTES;
    while let (Some(stated), Some(kind)) = (word(bytes, offset), word(bytes, offset + 4)) {
        let start = offset + CHUNK_HEADER_BYTES;
        let rest = &bytes[start..];
        let data = rest.get(..stated as usize).ok_or(GltfError::ChunkLength {
            chunk: chunks.len(),
            offset: offset as u64,
            stated: u64::from(stated),
            left: rest.len() as u64,
        })?;
        chunks.push((kind, data));
        offset = start + data.len();
    }
    match chunks.first() {
        Some(&(CHUNK_JSON, json)) => {
            let binary = chunks.iter().find(|(kind, _)| *kind == CHUNK_BINARY);
            // It should be padded by spaces.
            let end = json.iter().rposition(|&byte| byte != 0).map_or(0, |last| last + 1);
            Ok((&json[..end], binary.map(|&(_, data)| data)))
        }
        _ => Err(GltfError::NoJsonChunk),
    }
}

/// The little-endian word at byte `offset`, if there is one.
fn word(bytes: &[u8], offset: usize) -> Option<u32> {
    bytes.get(offset..)?.first_chunk().map(|&four| u32::from_le_bytes(four))
}
