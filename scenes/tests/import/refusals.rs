//! Files that must be refused, each with one sentence that says what is wrong.

use std::fs;

use serde_json::json;

use crate::fixture::{Fixture, U16, chunk, glb_of_chunks, le_bytes, load_bytes, load_in};
use crate::materials::encoded;

/// The sentence with which a file is refused, after its `cannot load scene.glb: `.
#[track_caller]
fn refusal(fixture: &Fixture) -> String {
    let message = fixture.load().expect_err("it should be refused");
    assert!(!message.contains('\n'), "{message}");
    message.strip_prefix("cannot load scene.glb: ").expect("it names the file").to_owned()
}

#[track_caller]
fn refusal_of_bytes(bytes: &[u8]) -> String {
    let message = load_bytes("scene.glb", bytes).expect_err("it should be refused");
    message.strip_prefix("cannot load scene.glb: ").expect("it names the file").to_owned()
}

#[track_caller]
fn assert_starts(message: &str, start: &str) {
    assert!(message.starts_with(start), "{message}");
}

const PRIMITIVE: &str = "node 0, primitive 0 of mesh 0: ";

#[test]
fn containers_that_lie() {
    let whole = Fixture::triangle().glb();
    let mut version = whole.clone();
    version[4] = 1;
    assert_starts(&refusal_of_bytes(&version), "its GLB container has version 1, expected 2");

    let mut chunk_length = whole.clone();
    chunk_length[12..16].copy_from_slice(&0xFFFF_FFF0_u32.to_le_bytes());
    let expected = "its GLB chunk 0, at byte 12, promises 4294967280 bytes, but only";
    assert_starts(&refusal_of_bytes(&chunk_length), expected);

    assert_starts(&refusal_of_bytes(b"glTF"), "its GLB header promises 12 bytes, but the file has 4");
    let mut no_room = whole.clone();
    no_room[8..12].copy_from_slice(&4_u32.to_le_bytes());
    assert_starts(&refusal_of_bytes(&no_room), "its first GLB chunk is not JSON");
    let binary_first = glb_of_chunks(&chunk(b"BIN\0", &[0; 8]));
    assert_starts(&refusal_of_bytes(&binary_first), "its first GLB chunk is not JSON");
    assert_starts(&refusal_of_bytes(b"solid cube"), "it is neither GLB");
    assert_starts(&refusal_of_bytes(b"{ \"asset\": "), "its JSON is not valid glTF: EOF");
    assert_starts(&refusal_of_bytes(b"{}"), "its JSON is not valid glTF: missing field `asset`");
}

#[test]
fn every_truncation_is_refused() {
    let whole = Fixture::triangle().glb();
    for length in 1..whole.len() {
        load_bytes("scene.glb", &whole[..length]).expect_err("a truncated file should be refused");
    }
    let expected = format!("its GLB header promises {} bytes, but the file has 100", whole.len());
    assert_starts(&refusal_of_bytes(&whole[..100]), &expected);
}

#[test]
fn other_versions_and_required_extensions() {
    let mut fixture = Fixture::triangle();
    fixture.json["asset"]["version"] = json!("1.0");
    assert_starts(&refusal(&fixture), "it is glTF version \"1.0\", expected 2.0");
    // Some files write it as a number.
    fixture.json["asset"]["version"] = json!(1);
    assert_starts(&refusal(&fixture), "it is glTF version \"1.0\", expected 2.0");
    fixture.json["asset"]["version"] = json!(2.0);
    fixture.scene();
    fixture.json["asset"] = json!({ "version": "2.1", "minVersion": "2.1" });
    assert_starts(&refusal(&fixture), "it is glTF version \"2.1\", expected 2.0");
    fixture.json["asset"] = json!({ "version": "2.1", "minVersion": "2.0" });
    fixture.scene();

    fixture.json["extensionsUsed"] = json!(["KHR_draco_mesh_compression", "A", "A", "KHR_lights_punctual"]);
    let notices = fixture.scene().notices;
    assert_eq!(notices[0], "the extension A is not supported and has no effect");
    assert_eq!(notices[1], "the extension KHR_draco_mesh_compression is not supported and has no effect");
    assert_eq!(notices.iter().filter(|notice| notice.contains("extension")).count(), 2);

    fixture.json["extensionsRequired"] = json!(["KHR_lights_punctual", "KHR_draco_mesh_compression"]);
    let expected = "it requires the extension KHR_draco_mesh_compression, which is not supported";
    assert_starts(&refusal(&fixture), expected);
    // The JSON of such a file need not be what we would understand.
    fixture.json["accessors"] = json!("compressed");
    assert_starts(&refusal(&fixture), expected);
}

#[test]
fn vertices_and_indices_that_cannot_be() {
    for (value, name) in [(f32::NAN, "NaN"), (f32::INFINITY, "inf"), (f32::NEG_INFINITY, "-inf")] {
        let mut fixture = Fixture::triangle();
        fixture.binary[16..20].copy_from_slice(&value.to_le_bytes());
        let expected = format!("{PRIMITIVE}vertex 1 is (1, {name}, 0), expected finite numbers");
        assert_eq!(refusal(&fixture), expected);
    }
    let mut fixture = Fixture::triangle();
    fixture.json["nodes"][0]["scale"] = json!([1e38, 1, 1]);
    fixture.binary[12..16].copy_from_slice(&1e38_f32.to_le_bytes());
    assert!(refusal(&fixture).contains("vertex 1 is ("));
    assert!(refusal(&fixture).contains(" in world space, expected finite numbers"));

    let mut fixture = Fixture::triangle();
    let indices = fixture.indices(&[0, 1, 3]);
    fixture.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
    fixture.json["nodes"][0]["name"] = json!("chair");
    let expected = "node 0 (\"chair\"), primitive 0 of mesh 0: index 2 is 3, but there are only 3 vertices";
    assert_eq!(refusal(&fixture), expected);
}

#[test]
fn accessors_that_reach_too_far() {
    let with = |key: &str, value: serde_json::Value| {
        let mut fixture = Fixture::triangle();
        fixture.json["accessors"][0][key] = value;
        refusal(&fixture)
    };
    let reaches = |end: u64| {
        format!("{PRIMITIVE}accessor 0 reaches to byte {end} of its buffer view, which has 36 bytes")
    };
    assert_eq!(with("count", json!(4)), reaches(48));
    assert_eq!(with("count", json!(4_000_000_000_u64)), reaches(48_000_000_000));
    assert_eq!(with("count", json!(u64::MAX)), reaches(u64::MAX));
    assert_eq!(with("byteOffset", json!(4)), reaches(40));
    assert_eq!(with("byteOffset", json!(u64::MAX)), reaches(u64::MAX));
    let expected = format!("{PRIMITIVE}accessor 0 refers to buffer view 3, which does not exist");
    assert_eq!(with("bufferView", json!(3)), expected);
    assert!(with("type", json!("VEC2")).contains("accessor 0 has elements of type Vec2, expected Vec3"));
    assert!(with("type", json!("VEC5")).contains("accessor 0 has a type"));
    assert!(with("componentType", json!(1)).contains("accessor 0 has a type"));
    assert!(with("count", json!(-1)).starts_with("its JSON is not valid glTF"));

    let mut fixture = Fixture::triangle();
    fixture.json["bufferViews"][0]["byteStride"] = json!(0);
    assert!(refusal(&fixture).contains("elements of 12 bytes in a buffer view of stride 0"));
    fixture.json["bufferViews"][0] = json!({ "buffer": 0, "byteOffset": 8, "byteLength": 36 });
    let expected = format!("{PRIMITIVE}buffer view 0 covers bytes 8 to 44 of buffer 0, which has 36");
    assert_eq!(refusal(&fixture), expected);
    fixture.json["bufferViews"][0] = json!({ "buffer": 5, "byteLength": 36 });
    assert!(refusal(&fixture).contains("buffer view 0 refers to buffer 5, which does not exist"));
}

#[test]
fn sparse_accessors_that_promise_too_much() {
    let mut fixture = Fixture::triangle();
    let indices = fixture.view(&[0, 0, 3, 0]);
    let values = fixture.view(&le_bytes(&[0.0; 6]));
    fixture.json["accessors"][0]["sparse"] = json!({
        "count": 2,
        "indices": { "bufferView": indices, "componentType": U16 },
        "values": { "bufferView": values },
    });
    assert!(refusal(&fixture).contains("accessor 0 has sparse index 3, but only 3 elements"));
    let mut many = fixture.clone();
    many.json["accessors"][0]["sparse"]["count"] = json!(3);
    assert!(refusal(&many).contains("accessor 0 reaches to byte 6 of its buffer view, which has 4"));
    // Four billion vertices that are nowhere must not be made.
    fixture.json["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    fixture.json["accessors"][0]["count"] = json!(4_000_000_000_u64);
    assert!(refusal(&fixture).contains("accessor 0 has 4000000000 elements but no buffer view"));
    fixture.json["accessors"][0].as_object_mut().unwrap().remove("sparse");
    assert!(refusal(&fixture).contains("accessor 0 has 4000000000 elements but no buffer view"));
}

#[test]
fn primitives_that_do_not_fit_together() {
    let mut fixture = Fixture::triangle();
    let normals = fixture.vectors(&[[0.0, 0.0, 1.0]; 2]);
    fixture.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(normals);
    assert_eq!(refusal(&fixture), format!("{PRIMITIVE}its NORMAL has 2 values for 3 positions"));

    let with = |key: &str, value: serde_json::Value| {
        let mut fixture = Fixture::triangle();
        fixture.json["meshes"][0]["primitives"][0][key] = value;
        refusal(&fixture)
    };
    assert_eq!(with("mode", json!(7)), format!("{PRIMITIVE}its mode is none of glTF's seven"));
    assert!(with("material", json!(0)).contains("the primitive refers to material 0, which does not exist"));
    assert!(with("indices", json!(0)).contains("accessor 0 has elements of type Vec3, expected Scalar"));
    assert!(with("indices", json!(9)).contains("the primitive refers to accessor 9, which does not exist"));
    let mut fixture = Fixture::triangle();
    let indices = fixture.vectors(&[[0.0]; 3]);
    fixture.json["accessors"][indices]["type"] = json!("SCALAR");
    fixture.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
    assert!(refusal(&fixture).contains("accessor 1 has F32 indices, expected U8, U16 or U32"));
}

#[test]
fn nodes_that_are_no_trees() {
    let mut fixture = Fixture::triangle();
    fixture.json["nodes"] = json!([{ "mesh": 0, "children": [1] }, { "name": "loop", "children": [0] }]);
    assert_starts(&refusal(&fixture), "node 0 is reached a second time, from node 1 (\"loop\")");
    fixture.json["nodes"] = json!([{ "children": [1, 2] }, { "children": [3] }, { "children": [3] }, {}]);
    assert_starts(&refusal(&fixture), "node 3 is reached a second time, from node 2");
    fixture.json["nodes"] = json!([{ "children": [5] }]);
    assert_starts(&refusal(&fixture), "node 0 refers to node 5, which does not exist");
    fixture.json["nodes"] = json!([{ "mesh": 5 }]);
    assert_starts(&refusal(&fixture), "node 0 refers to mesh 5, which does not exist");
    fixture.json["nodes"] = json!([{ "mesh": 0, "translation": [1e39, 0, 0] }]);
    assert_starts(&refusal(&fixture), "node 0 has a transform that is not usable");
    fixture.json["nodes"] = json!([{ "mesh": 0, "rotation": [0, 0, 0, 0] }]);
    let expected = "node 0 has a transform that is not usable: its rotation has no length";
    assert_eq!(refusal(&fixture), expected);
    fixture.json["scene"] = json!(3);
    assert_starts(&refusal(&fixture), "the file refers to scene 3, which does not exist");
    fixture.json["scene"] = json!(0);
    fixture.json["nodes"] = json!([{}]);
    assert_eq!(refusal(&fixture), "it has no triangles in its scene");
    fixture.json["nodes"] = json!([{ "mesh": 0 }]);
    fixture.json["meshes"][0]["primitives"][0]["mode"] = json!(1);
    let expected = "it has no triangles in its scene, only points or lines, which rays cannot hit";
    assert_eq!(refusal(&fixture), expected);
}

#[test]
fn buffers_that_cannot_be_had() {
    let folder = tempfile::tempdir().unwrap();
    let fixture = Fixture::triangle();
    let load = |uri: Option<&str>| {
        fs::write(folder.path().join("scene.gltf"), fixture.json_with_buffer(uri)).unwrap();
        load_in(folder.path(), "scene.gltf")
    };
    let refusal = |uri: Option<&str>| load(uri).unwrap_err().replace("cannot load scene.gltf: ", "");
    assert_starts(&refusal(Some("a.bin")), "buffer 0 cannot be read: cannot read a.bin: No such file");
    let expected = format!("{PRIMITIVE}buffer 0 has no URI, and the file has no binary chunk for it");
    assert_starts(&refusal(None), &expected);
    assert_starts(
        &refusal(Some("/a.bin")),
        "buffer 0 cannot be read: its URI \"/a.bin\" is an absolute path",
    );
    assert_starts(&refusal(Some("file:a.bin")), "buffer 0 cannot be read: its URI has the scheme \"file\"");
    assert_starts(&refusal(Some("data:,abc")), "buffer 0 cannot be read: its data URI is not base64");
    assert_starts(&refusal(Some("%FF.bin")), "buffer 0 cannot be read: its URI \"%FF.bin\" is not UTF-8");
    fs::create_dir(folder.path().join("b")).unwrap();
    assert_starts(
        &refusal(Some("b")),
        "buffer 0 cannot be read: cannot read b: found a folder, expected a plain",
    );

    fs::write(folder.path().join("a.bin"), &fixture.binary[..35]).unwrap();
    assert_starts(&refusal(Some("a.bin")), "buffer 0 promises 36 bytes, but has 35");
    fs::write(folder.path().join("a.bin"), &fixture.binary).unwrap();
    assert_eq!(load(Some("a.bin")).unwrap().positions, crate::fixture::TRIANGLE);
}

#[test]
fn instances_beyond_all_memory_are_refused_before_they_are_made() {
    let mut fixture = Fixture::triangle();
    // 22 million triangles of no bytes, in as many places as it takes.
    let count = 66_000_000;
    let indices =
        fixture.push("accessors", json!({ "componentType": 5121, "type": "SCALAR", "count": count }));
    fixture.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
    let start = std::time::Instant::now();
    for _ in 1..100 {
        fixture.node(json!({ "mesh": 0 }));
    }
    let expected = "flattened, it has 2200000000 triangles, more than the 268435455 that can be numbered";
    assert_starts(&refusal(&fixture), expected);
    assert!(start.elapsed().as_secs() < 2, "{:?}", start.elapsed());
}

#[test]
fn images_beyond_all_memory_are_refused_before_they_are_decoded() {
    let mut fixture = Fixture::triangle();
    // Headers of 5 GB images, a thousand times: their pixels need not be there to be counted.
    let mut png = encoded(image::GrayImage::new(1, 1), image::ImageFormat::Png);
    png[16..20].copy_from_slice(&36_000_u32.to_be_bytes());
    png[20..24].copy_from_slice(&36_000_u32.to_be_bytes());
    let checksum = crc32_of(&png[12..29]);
    png[29..33].copy_from_slice(&checksum.to_be_bytes());
    let view = fixture.view(&png);
    let uvs = fixture.vectors(&[[0.0, 0.0]; 3]);
    for image in 0..1000 {
        fixture.push("images", json!({ "bufferView": view }));
        fixture.push("textures", json!({ "source": image }));
        let texture = json!({ "baseColorTexture": { "index": image } });
        fixture.push("materials", json!({ "pbrMetallicRoughness": texture }));
        let attributes = json!({ "POSITION": 0, "TEXCOORD_0": uvs });
        fixture.primitive(json!({ "attributes": attributes, "material": image }));
    }
    let message = refusal(&fixture);
    let expected = "its 1000 images do not fit; use smaller images, a simpler scene or fewer instances: about 4943847 MiB of memory are needed, but only";
    assert_starts(&message, expected);
}

#[test]
fn scenes_whose_triangles_rays_would_miss() {
    for (scale, extent) in [(0.0, "0.0"), (1e-30, "1e-30"), (1e-23, "1e-23")] {
        let mut fixture = Fixture::triangle();
        fixture.json["nodes"][0]["scale"] = json!([scale, scale, scale]);
        let expected = format!(
            "cannot trace scene.glb, which is {extent} units large, expected at least 1.3e-23; scale the scene up, or export it without compression"
        );
        assert_eq!(fixture.load().unwrap_err(), expected);
    }
    let mut fixture = Fixture::triangle();
    fixture.json["nodes"][0]["scale"] = json!([2e-23, 0, 0]);
    fixture.scene();
}

/// The checksum of PNG chunks (ISO 3309), bit by bit.
fn crc32_of(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| (crc >> 1) ^ if crc & 1 == 1 { 0xEDB8_8320 } else { 0 })
    })
}
