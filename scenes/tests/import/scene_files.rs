//! From a name on the command line: files, sidecars and built-in scenes.

use std::fs;
use std::path::Path;

use scenes::{Environment, Light};
use serde_json::json;

use crate::fixture::{Fixture, load_bytes, load_in, sentence};

const SIDECAR: &str = r#"
[[camera]]
name = "door"
eye = [0.0, 0.0, 5.0]
target = [0.0, 0.0, 0.0]
up = [0.0, 1.0, 0.0]
yfov_degrees = 90.0

[[light]]
position = [1.0, 2.0, 3.0]
radius = 0.5
intensity = [4.0, 5.0, 6.0]

[environment]
zenith = [1.0, 2.0, 3.0]
nadir = [0.0, 0.0, 0.0]
"#;

/// A file with a camera, a point light and an emissive triangle.
fn complete() -> Fixture {
    let mut fixture = Fixture::triangle();
    fixture.push("materials", json!({ "emissiveFactor": [1, 1, 1] }));
    fixture.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    fixture.push("cameras", json!({ "type": "perspective", "perspective": { "yfov": 1, "znear": 0.1 } }));
    fixture.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [{ "type": "point" }] } });
    let extensions = json!({ "KHR_lights_punctual": { "light": 0 } });
    fixture.node(json!({ "camera": 0, "name": "door", "extensions": extensions }));
    fixture
}

fn write(folder: &Path, name: &str, bytes: impl AsRef<[u8]>) {
    fs::write(folder.join(name), bytes).expect("a temporary file");
}

#[test]
fn a_sidecar_adds_its_cameras_and_lights_in_order() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), "my.scene.glb", complete().glb());
    write(folder.path(), "my.scene.rayscope.toml", SIDECAR);
    let scene = load_in(folder.path(), "my.scene.glb").unwrap();
    assert_eq!(scene.name, "my.scene");
    let names: Vec<&str> = scene.cameras.iter().map(|camera| &*camera.name).collect();
    assert_eq!(names, ["door", "door-2"]);
    assert_eq!(scene.cameras[1].eye, [0.0, 0.0, 5.0]);
    assert_eq!(
        scene.lights,
        [
            Light::Point { position: [0.0; 3], intensity: [1.0; 3] },
            Light::Sphere { position: [1.0, 2.0, 3.0], radius: 0.5, intensity: [4.0, 5.0, 6.0] },
            Light::Emissive { first_triangle: 0, triangle_count: 1 },
            Light::Environment(Environment { zenith: [1.0, 2.0, 3.0], nadir: [0.0; 3] }),
        ]
    );
    assert!(scene.notices.is_empty(), "{:?}", scene.notices);
}

#[test]
fn gltf_and_glb_are_the_same_scene() {
    let fixture = complete();
    let encoded = base64::Engine::encode(&base64::engine::general_purpose::STANDARD, &fixture.binary);
    let uri = format!("data:application/octet-stream;base64,{encoded}");
    let gltf = load_bytes("scene.GLTF", &fixture.json_with_buffer(Some(&uri))).unwrap();
    let glb = fixture.scene();
    assert_eq!(scenes::hash::content_hash(&gltf), scenes::hash::content_hash(&glb));
    assert_eq!(gltf.cameras, glb.cameras);
}

#[test]
fn sidecars_that_are_wrong_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), "scene.glb", complete().glb());
    write(folder.path(), "scene.rayscope.toml", "[[light]]\ncolour = 1\n");
    let message = load_in(folder.path(), "scene.glb").unwrap_err();
    let expected = "cannot use the sidecar scene.rayscope.toml: line 2: unknown field `colour`";
    assert!(message.starts_with(expected), "{message}");
    write(folder.path(), "scene.rayscope.toml", [0xFF, 0xFE]);
    let message = load_in(folder.path(), "scene.glb").unwrap_err();
    assert!(
        message.starts_with("cannot use the sidecar scene.rayscope.toml: it cannot be read"),
        "{message}"
    );
}

#[test]
fn names_that_are_no_scene() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("folder.glb")).unwrap();
    write(folder.path(), "empty.glb", "");
    write(folder.path(), "scene.obj", "v 0 0 0");
    let refusal = |name: &str| load_in(folder.path(), name).unwrap_err();
    assert!(refusal("missing.glb").starts_with("cannot read missing.glb: No such file"));
    assert_eq!(refusal("folder.glb"), "folder.glb is a directory, expected a .gltf or .glb file");
    assert_eq!(refusal("empty.glb"), "empty.glb is empty, expected a glTF or GLB file");
    let expected = "scene.obj is not a scene, expected a name that ends in .gltf or .glb, or builtin:NAME";
    assert_eq!(refusal("scene.obj"), expected);
    if cfg!(unix) {
        let message = sentence(&scenes::load("/dev/null").unwrap_err());
        assert!(message.starts_with("/dev/null is not a regular file"), "{message}");
    }
}

#[test]
fn built_in_scenes_by_name_and_size() {
    let small = scenes::load("builtin:cornell?triangles=500").unwrap();
    let large = scenes::load("builtin:cornell?triangles=5000").unwrap();
    assert_eq!(small.name, "cornell");
    assert!(small.triangles.len() < large.triangles.len());
    for parameter in ["size=3", "triangles=", "triangles=-1", "triangles=many", ""] {
        let message = sentence(&scenes::load(&format!("builtin:cornell?{parameter}")).unwrap_err());
        let expected = format!("\"{parameter}\" is not a parameter of a built-in scene");
        assert!(message.starts_with(&expected), "{message}");
    }
    let message = sentence(&scenes::load("builtin:nowhere").unwrap_err());
    assert!(message.contains("nowhere"), "{message}");
}
