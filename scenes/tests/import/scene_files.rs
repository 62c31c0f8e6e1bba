//! From a name on the command line: files, sidecars and built-in scenes.

use std::fs;
use std::path::Path;

use scenes::{Environment, Light};
use serde_json::json;

use crate::fixture::{Fixture, load_bytes, load_in, sentence};
use crate::materials::encoded;

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
    assert_eq!(refusal("folder.glb"), "cannot read folder.glb: found a folder, expected a plain file");
    assert_eq!(refusal("empty.glb"), "empty.glb is empty, expected a glTF or GLB file");
    let expected = "scene.obj is not a scene, expected a name that ends in .gltf or .glb, or builtin:NAME";
    assert_eq!(refusal("scene.obj"), expected);
}

/// Each file of a scene in turn is a device that never ends, or a pipe that nobody writes to.
#[cfg(unix)]
#[test]
fn pipes_and_devices_are_not_waited_for() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let pipe = path("pipe");
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let mut fixture = complete();
    fixture.push("textures", json!({ "source": 0 }));
    fixture.push("images", json!({ "uri": "image.png" }));
    let texture = json!({ "baseColorTexture": { "index": 0 } });
    fixture.json["materials"][0]["pbrMetallicRoughness"] = texture;
    let image = encoded(image::RgbImage::new(1, 1), image::ImageFormat::Png);
    let whole: [(&str, &[u8]); 4] = [
        ("scene.gltf", &fixture.json_with_buffer(Some("a.bin"))),
        ("a.bin", &fixture.binary),
        ("image.png", &image),
        ("scene.rayscope.toml", SIDECAR.as_bytes()),
    ];
    whole.iter().for_each(|(name, bytes)| write(folder.path(), name, bytes));
    load_in(folder.path(), "scene.gltf").unwrap();
    for (name, bytes) in whole {
        for target in [Path::new("/dev/zero"), &pipe] {
            fs::remove_file(path(name)).unwrap();
            std::os::unix::fs::symlink(target, path(name)).unwrap();
            let message = load_in(folder.path(), "scene.gltf").unwrap_err();
            assert!(message.contains(name) || message.contains("image 0"), "{message}");
            assert!(message.ends_with("found a pipe or device, expected a plain file"), "{message}");
        }
        fs::remove_file(path(name)).unwrap();
        write(folder.path(), name, bytes);
    }
}

#[test]
fn sidecars_of_any_length_are_not_read() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), "scene.glb", complete().glb());
    write(folder.path(), "scene.rayscope.toml", "# long\n".repeat(3 << 20));
    let message = load_in(folder.path(), "scene.glb").unwrap_err();
    assert!(message.ends_with("found more than 16777216 bytes, expected at most that many"), "{message}");
}

#[test]
fn names_are_short_and_plain_wherever_they_go() {
    let long = format!("\u{1b}[2J\u{202e}{}", "n".repeat(5_000_000));
    let mut fixture = complete();
    fixture.json["materials"][0]["name"] = json!(long);
    for node in fixture.json["nodes"].as_array_mut().unwrap() {
        node["name"] = json!(long);
    }
    fixture.json["nodes"].as_array_mut().unwrap().push(json!({ "name": long, "camera": 0 }));
    fixture.json["scenes"][0]["nodes"] = json!([0, 1, 2]);
    fixture.json["extensionsUsed"] = json!(vec![long.clone(); 2]);
    let scene = load_bytes("a\u{9b}b.glb", &fixture.glb()).unwrap();
    assert_eq!(scene.name, "a\\u{9b}b");
    let names = scene.cameras.iter().map(|camera| &camera.name);
    for text in names.chain(scene.materials.iter().map(|material| &material.name)).chain(&scene.notices) {
        assert!(text.len() < 400 && text.contains("\\u{1b}[2J\\u{202e}nn"), "{text}");
    }
    // And in a refusal.
    fixture.json["nodes"][0]["mesh"] = json!(9);
    let message = load_bytes("a\u{9b}b.glb", &fixture.glb()).unwrap_err();
    assert!(message.len() < 400 && !message.contains(char::is_control), "{message}");
    let many: Vec<String> = (0..100_000).map(|number| format!("MANY_{number}")).collect();
    let mut fixture = complete();
    fixture.json["extensionsUsed"] = json!(many);
    let notices = fixture.scene().notices;
    assert_eq!(notices.len(), 33);
    assert_eq!(notices[32], "there is more to say of this kind (99968)");
}

#[test]
fn cameras_of_one_name_take_no_time() {
    let mut fixture = Fixture::triangle();
    fixture.push("cameras", json!({ "type": "perspective", "perspective": { "yfov": 1, "znear": 0.1 } }));
    for _ in 0..30_000 {
        fixture.node(json!({ "camera": 0 }));
    }
    let start = std::time::Instant::now();
    let cameras = load_bytes("scene.glb", &fixture.glb()).unwrap().cameras;
    assert_eq!(cameras[29_999].name, "camera 0-30000");
    assert!(start.elapsed().as_secs() < 20, "{:?}", start.elapsed());
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
