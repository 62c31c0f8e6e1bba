//! Small GLB files for the tests: one triangle, and whatever a test makes of it.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use serde_json::{Value, json};

/// The JSON of a scene with one triangle and a camera that sees it; its buffer is [`triangle_bytes`].
pub fn triangle_json() -> Value {
    json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": [0, 1] }],
        "nodes": [
            { "name": "triangle", "mesh": 0 },
            { "name": "view", "camera": 0, "translation": [0.3, 0.3, 3.0] },
        ],
        "cameras": [{ "name": "front", "type": "perspective", "perspective": { "yfov": 0.7, "znear": 0.1 } }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1 }] }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0] },
            { "bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR" },
        ],
        "bufferViews": [
            { "buffer": 0, "byteOffset": 0, "byteLength": 36 },
            { "buffer": 0, "byteOffset": 36, "byteLength": 6 },
        ],
        "buffers": [{ "byteLength": 44 }],
    })
}

/// Three positions, three 16-bit indices, two bytes of padding.
pub fn triangle_bytes() -> Vec<u8> {
    let positions: [f32; 9] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let indices: [u16; 4] = [0, 1, 2, 0];
    let mut bytes: Vec<u8> = positions.iter().flat_map(|value| value.to_le_bytes()).collect();
    bytes.extend(indices.iter().flat_map(|index| index.to_le_bytes()));
    bytes
}

/// A GLB file of a JSON chunk and a binary one.
///
/// # Panics
/// If a chunk does not fit 32 bits.
pub fn glb(json: &Value, binary: &[u8]) -> Vec<u8> {
    let length = |bytes: usize| u32::try_from(bytes).expect("the chunk is small").to_le_bytes();
    let mut text = json.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut chunks = Vec::new();
    for (kind, bytes) in [(b"JSON", &text[..]), (b"BIN\0", binary)] {
        chunks.extend(length(bytes.len()));
        chunks.extend(kind);
        chunks.extend(bytes);
    }
    let mut file = b"glTF".to_vec();
    file.extend(2u32.to_le_bytes());
    file.extend(length(chunks.len() + 12));
    file.extend(chunks);
    file
}

/// A GLB file of the triangle with a second one behind it; the front one's texture is a chessboard of holes.
///
/// # Panics
/// If the texture cannot be encoded.
pub fn masked() -> Vec<u8> {
    let mut json = triangle_json();
    let mut bytes = triangle_bytes();
    let mut add = |data: &[u8]| {
        let offset = bytes.len();
        bytes.extend(data);
        bytes.resize(bytes.len().next_multiple_of(4), 0);
        json!({ "buffer": 0, "byteOffset": offset, "byteLength": data.len() })
    };
    let uvs: [f32; 6] = [0.0, 0.0, 1.0, 0.0, 0.0, 1.0];
    let uvs: Vec<u8> = uvs.iter().flat_map(|value| value.to_le_bytes()).collect();
    let views = [add(&uvs), add(&chessboard())];
    json["bufferViews"].as_array_mut().unwrap().extend(views);
    json["accessors"].as_array_mut().unwrap().push(json!(
        { "bufferView": 2, "componentType": 5126, "count": 3, "type": "VEC2" }
    ));
    json["images"] = json!([{ "bufferView": 3, "mimeType": "image/png" }]);
    json["textures"] = json!([{ "source": 0 }]);
    json["materials"] = json!([
        { "alphaMode": "MASK", "alphaCutoff": 0.5, "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } },
        { "pbrMetallicRoughness": { "metallicFactor": 0 } },
    ]);
    json["meshes"] = json!([
        { "primitives": [{ "attributes": { "POSITION": 0, "TEXCOORD_0": 2 }, "indices": 1, "material": 0 }] },
        { "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1, "material": 1 }] },
    ]);
    json["nodes"].as_array_mut().unwrap().push(json!({ "mesh": 1, "translation": [0, 0, -0.5] }));
    json["scenes"][0]["nodes"].as_array_mut().unwrap().push(json!(2));
    json["buffers"][0]["byteLength"] = json!(bytes.len());
    glb(&json, &bytes)
}

/// An 8 × 8 PNG, every other texel transparent.
fn chessboard() -> Vec<u8> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, 8, 8);
    encoder.set_color(png::ColorType::Rgba);
    let texels: Vec<u8> =
        (0..64u8).flat_map(|at| [200, 180, 160, if (at / 8 + at) % 2 == 0 { 255 } else { 0 }]).collect();
    encoder.write_header().unwrap().write_image_data(&texels).unwrap();
    file
}
