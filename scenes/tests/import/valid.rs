//! Files that look odd and are valid glTF 2.0: each must load, and what has no effect is said.

use std::fs;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};

use crate::fixture::{Fixture, TRIANGLE, U8, U16, chunk, glb_of_chunks, le_bytes, load_bytes, load_in};
use crate::materials::encoded;

/// Writes every integer of the JSON as `4.0`, which JSON Schema takes for the same.
fn with_reals(value: &mut Value) {
    match value {
        Value::Number(number) => *value = json!(number.as_f64()),
        Value::Array(items) => items.iter_mut().for_each(with_reals),
        Value::Object(members) => members.values_mut().for_each(with_reals),
        _ => {}
    }
}

/// Gives every object of the JSON these `extras`.
fn with_extras(value: &mut Value, extras: &Value) {
    match value {
        Value::Array(items) => items.iter_mut().for_each(|item| with_extras(item, extras)),
        Value::Object(members) => {
            members.values_mut().for_each(|member| with_extras(member, extras));
            members.insert("extras".into(), extras.clone());
        }
        _ => {}
    }
}

/// A file with something of everything that has integers.
fn rich() -> Fixture {
    let mut fixture = Fixture::triangle();
    let uvs = fixture.vectors(&[[0.25, 0.75]; 3]);
    let indices = fixture.indices(&[0, 1, 2]);
    let primitive = json!({ "attributes": { "POSITION": 0, "TEXCOORD_0": uvs }, "indices": indices,
                            "material": 0, "mode": 4 });
    fixture.json["meshes"][0]["primitives"][0] = primitive;
    let texture = json!({ "index": 0, "texCoord": 0 });
    fixture.push("materials", json!({ "pbrMetallicRoughness": { "baseColorTexture": texture } }));
    fixture.push("textures", json!({ "sampler": 0 }));
    fixture.push("samplers", json!({ "magFilter": 9729, "minFilter": 9987, "wrapS": 10497, "wrapT": 10497 }));
    fixture.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [{ "type": "point" }] } });
    let extensions = json!({ "KHR_lights_punctual": { "light": 0 } });
    fixture.push("cameras", json!({ "type": "perspective", "perspective": { "yfov": 1, "znear": 0.1 } }));
    fixture.node(json!({ "camera": 0, "extensions": extensions, "children": [] }));
    fixture
}

fn hash(fixture: &Fixture) -> [u8; 32] {
    scenes::hash::content_hash(&fixture.scene())
}

#[test]
fn integers_may_be_written_as_reals() {
    let mut fixture = rich();
    let expected = hash(&fixture);
    with_reals(&mut fixture.json);
    assert!(fixture.json.to_string().contains("\"byteLength\":36.0"));
    assert_eq!(hash(&fixture), expected);
    fixture.json["accessors"][0]["count"] = json!(2.5);
    let message = fixture.load().unwrap_err();
    let expected = "cannot load scene.glb: its JSON is not valid glTF: accessors[0]: invalid type: floating";
    assert!(message.starts_with(expected), "{message}");
}

#[test]
fn extras_may_be_anything() {
    let expected = hash(&rich());
    for extras in [json!(7), json!("text"), json!([1, [2.5]]), json!(null), json!({ "count": "none" })] {
        let mut fixture = rich();
        with_extras(&mut fixture.json, &extras);
        assert_eq!(hash(&fixture), expected, "{extras}");
    }
}

#[test]
fn what_has_no_effect_is_not_looked_at() {
    let mut fixture = Fixture::triangle();
    // A target without a node is for an extension to say (glTF 2.0 §3.11).
    let channel = json!({ "sampler": 0, "target": { "path": "pointer" } });
    fixture.push("animations", json!({ "channels": [channel], "samplers": [{ "input": 0, "output": 0 }] }));
    fixture.push("animations", json!({ "name": "empty" }));
    fixture.push("skins", json!({ "skeleton": 7 }));
    fixture.json["meshes"][0]["weights"] = json!(["heavy"]);
    fixture.json["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": { "index": 0 } }]);
    fixture.json["nodes"][0]["skin"] = json!(0);
    fixture.json["nodes"][0]["weights"] = json!("none");
    let notices = fixture.scene().notices;
    assert_eq!(notices[0], "animations are ignored: nodes stay where the file puts them (2)");
    assert_eq!(notices[1], "primitives have morph targets, which are ignored (1)");
    assert_eq!(notices[2], "skinned primitives without joints stand where their node is (1)");
}

#[test]
fn a_scene_may_be_empty_unless_it_is_the_one() {
    let mut fixture = Fixture::triangle();
    let empty = fixture.push("scenes", json!({ "name": "later" }));
    assert_eq!(fixture.scene().positions, TRIANGLE);
    fixture.json["scene"] = json!(empty);
    let expected = "cannot load scene.glb: its scene 1 has no nodes, so there is nothing to trace";
    assert!(fixture.load().unwrap_err().starts_with(expected));
}

#[test]
fn a_texture_may_have_no_image() {
    let mut fixture = rich();
    let extension = json!({ "KHR_texture_basisu": { "source": 0 } });
    fixture.json["textures"][0]["extensions"] = extension;
    let index = json!({ "index": 0 });
    fixture.json["materials"][0]["pbrMetallicRoughness"]["metallicRoughnessTexture"] = index.clone();
    fixture.json["materials"][0]["emissiveTexture"] = index;
    fixture.json["materials"][0]["emissiveFactor"] = json!([1, 2, 3]);
    let scene = fixture.scene();
    assert!(scene.textures.is_empty());
    let material = &scene.materials[0];
    assert_eq!((material.base_color, material.emission), ([1.0; 3], [1.0, 2.0, 3.0]));
    assert_eq!((material.metallic, material.roughness), (1.0, 1.0));
    assert!(scene.notices.contains(&"textures without an image count as white (3)".to_owned()));
}

#[test]
fn primitives_without_positions_are_skipped() {
    let mut fixture = Fixture::triangle();
    fixture.primitive(json!({ "attributes": {} }));
    fixture.primitive(json!({ "attributes": { "NORMAL": 0 }, "mode": 1 }));
    let scene = fixture.scene();
    assert_eq!(scene.positions, TRIANGLE);
    assert_eq!(scene.notices[0], "primitives without positions are skipped (2)");
}

#[test]
fn what_is_left_of_a_list_of_triangles_is_ignored() {
    let mut fixture = Fixture::triangle();
    let indices = fixture.indices(&[0, 1, 2, 2, 1]);
    fixture.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
    let scene = fixture.scene();
    assert_eq!(scene.triangles, [[0, 1, 2]]);
    assert_eq!(scene.notices[0], "primitives end in an incomplete triangle, which is ignored (1)");
}

#[test]
fn a_camera_that_cannot_be_used_is_left_out_and_named() {
    let mut fixture = Fixture::triangle();
    let perspective = |yfov: Value| json!({ "type": "perspective", "perspective": yfov });
    let cameras = [
        perspective(json!({ "yfov": 0, "znear": 0.1 })),
        perspective(json!({ "yfov": 4, "znear": 0.1 })),
        perspective(json!({ "znear": 0.1 })),
        json!({ "type": "perspective", "name": "own\u{202e}" }),
        perspective(json!({ "yfov": 1, "znear": 2, "zfar": 1, "aspectRatio": 0 })),
    ];
    for camera in cameras {
        let camera = fixture.push("cameras", camera);
        fixture.node(json!({ "camera": camera }));
    }
    fixture.push("cameras", json!({ "type": "unused", "perspective": "none" }));
    fixture.node(json!({ "camera": 4, "scale": [0, 0, 0], "name": "flat" }));
    let scene = fixture.scene();
    let names: Vec<&str> = scene.cameras.iter().map(|camera| &*camera.name).collect();
    assert_eq!(names, ["camera 4"]);
    let expected = [
        "the camera \"camera 0\" (camera 0 of node 1) cannot be used: its vertical field of view is 0°",
        "the camera \"camera 1\" (camera 1 of node 2) cannot be used: its vertical field of view is 229",
        "the camera \"camera 2\" (camera 2 of node 3) cannot be used: missing field `yfov`",
        "the camera \"own\\u{202e}\" (camera 3 of node 4) cannot be used: it has no perspective",
        "the camera \"flat\" (camera 4 of node 6 (\"flat\")) cannot be used: its eye and its target",
    ];
    for (notice, expected) in scene.notices.iter().zip(expected) {
        assert!(notice.starts_with(expected), "{notice}");
    }
    // With no other, one is made.
    fixture.json["nodes"].as_array_mut().unwrap().remove(5);
    fixture.json["scenes"][0]["nodes"] = json!([0, 1, 2]);
    assert_eq!(fixture.scene().cameras[0].name, "auto");
}

#[test]
fn accessors_without_a_view_are_zeros() {
    let mut fixture = Fixture::triangle();
    let zeros = json!({ "componentType": 5126, "type": "VEC3", "count": 3 });
    let zeros = fixture.push("accessors", zeros);
    fixture.primitive(json!({ "attributes": { "POSITION": 0, "NORMAL": zeros } }));
    fixture.primitive(json!({ "attributes": { "POSITION": zeros } }));
    let scene = fixture.scene();
    assert_eq!(scene.positions[..6], [TRIANGLE, TRIANGLE].concat());
    assert_eq!(scene.positions[6..], [[0.0; 3]; 3]);
    assert_eq!(scene.notices[0], "degenerate triangles stay in the scene and are never hit (1)");
}

#[test]
fn a_buffer_that_nothing_reads_may_have_no_bytes() {
    let mut fixture = Fixture::triangle();
    fixture.json["buffers"] = json!([{ "byteLength": fixture.binary.len() }, { "byteLength": 1e3 }]);
    fixture.push("bufferViews", json!({ "buffer": 1, "byteLength": 9 }));
    assert_eq!(fixture.scene().positions, TRIANGLE);
}

#[test]
fn normalised_texture_coordinates() {
    for (component, bytes) in [(U8, vec![0, 255, 51, 0, 255, 255]), (U16, vec![0, 0, 255, 255, 51, 51])] {
        let mut fixture = rich();
        let count = 3 * bytes.len() / 6;
        let bytes = [bytes.clone(), bytes].concat();
        let uvs = fixture.accessor(&bytes, component, "VEC2", count);
        fixture.json["accessors"][uvs]["normalized"] = json!(true);
        fixture.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(uvs);
        let view = fixture.view(&encoded(image::RgbImage::new(1, 1), image::ImageFormat::Png));
        fixture.push("images", json!({ "bufferView": view }));
        fixture.json["textures"][0]["source"] = json!(0);
        let scene = fixture.scene();
        assert_eq!(scene.uvs[0], [0.0, 1.0]);
        assert!((scene.uvs[1][0] - 0.2).abs() < 1e-6, "{:?}", scene.uvs);
    }
}

#[test]
fn uris_may_be_written_in_many_ways() {
    let fixture = Fixture::triangle();
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("a b")).unwrap();
    let longer = [fixture.binary.clone(), vec![7; 100]].concat();
    fs::write(folder.path().join("a b/c.bin"), &longer).unwrap();
    let encoded = STANDARD.encode(&fixture.binary);
    let escaped = encoded.replace('+', "%2B").replace('/', "%2F").replace('=', "%3D").replace('A', "%41");
    let mut uris = vec![
        "a%20b/c.bin".to_owned(),
        "./a b/../a%20b/c%2Ebin".to_owned(),
        format!("DATA:;base64,{encoded}"),
        format!("data:application/gltf-buffer;base64,{escaped}"),
    ];
    if cfg!(unix) {
        fs::write(folder.path().join("a b/c:d.bin"), &longer).unwrap();
        uris.push("a b/c:d.bin".to_owned());
    }
    for uri in uris {
        fs::write(folder.path().join("scene.gltf"), fixture.json_with_buffer(Some(&uri))).unwrap();
        match load_in(folder.path(), "scene.gltf") {
            Ok(scene) => assert_eq!(scene.positions, TRIANGLE, "{uri}"),
            Err(message) => panic!("{uri}: {message}"),
        }
    }
}

#[test]
fn json_may_start_with_a_byte_order_mark() {
    let uri = format!("data:;base64,{}", STANDARD.encode(le_bytes(TRIANGLE.as_flattened())));
    let json = Fixture::triangle().json_with_buffer(Some(&uri));
    let scene = load_bytes("scene.gltf", &[b"\xEF\xBB\xBF".as_slice(), &json].concat()).unwrap();
    assert_eq!(scene.positions, TRIANGLE);
}

#[test]
fn json_may_be_padded_with_zero_bytes() {
    let fixture = Fixture::triangle();
    let mut json = fixture.json_with_buffer(None);
    json.resize(json.len().next_multiple_of(4) + 4, 0);
    let chunks = [chunk(b"JSON", &json), chunk(b"BIN\0", &fixture.binary)];
    let scene = load_bytes("scene.glb", &glb_of_chunks(&chunks.concat())).unwrap();
    assert_eq!(scene.positions, TRIANGLE);
}

#[test]
fn a_container_may_have_more_chunks() {
    let fixture = Fixture::triangle();
    let mut json = fixture.json_with_buffer(None);
    json.resize(json.len().next_multiple_of(4), b' ');
    let chunks = [
        chunk(b"JSON", &json),
        chunk(b"MORE", &[1; 8]),
        chunk(b"BIN\0", &fixture.binary),
        chunk(b"ZZZZ", &[]),
    ];
    let scene = load_bytes("scene.glb", &glb_of_chunks(&chunks.concat())).unwrap();
    assert_eq!(scene.positions, TRIANGLE);
}
