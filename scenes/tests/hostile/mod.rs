//! What hostile bytes are put through: any bytes at all by the fuzz targets, those worth keeping by
//! the test `corpus`. Each function panics if something is wrong with our code.
#![allow(clippy::unwrap_used, reason = "this is test code, although not in test functions")]
#![allow(dead_code, reason = "every test and fuzz target compiles it anew and uses its own share")]

#[path = "../import/fixture.rs"]
mod fixture;

use std::path::Path;

use scenes::sidecar;

/// Longest message that is still one sentence.
const SENTENCE_BYTES_MAX: usize = 4096;

/// Asserts that a message can stand in one line of a terminal.
#[track_caller]
fn assert_sentence(message: &str) {
    assert!(!message.is_empty() && !message.chars().any(char::is_control), "{message:?}");
    assert!(message.len() <= SENTENCE_BYTES_MAX, "{} bytes: {message}", message.len());
}

/// A scene file, without anything beside it.
pub(crate) fn gltf(bytes: &[u8]) {
    match fixture::load_bytes("scene.glb", bytes) {
        Ok(scene) => {
            fixture::check_invariants(&scene);
            scene.notices.iter().for_each(|notice| assert_sentence(notice));
            let bounds = scene.bounds();
            assert!(bounds.min.iter().zip(&bounds.max).all(|(min, max)| min <= max));
            for light in &scene.lights {
                let centre = light.centre(&scene);
                assert!(centre.iter().flatten().all(|along| along.is_finite()), "{light:?}: {centre:?}");
            }
        }
        Err(message) => assert_sentence(&message),
    }
}

/// The text of a sidecar.
pub(crate) fn sidecar(bytes: &[u8]) {
    let folder = tempfile::tempdir().unwrap();
    let path = sidecar::path_beside(&folder.path().join("scene.glb"));
    assert!(sidecar::read(&path).unwrap().is_none());
    let text = String::from_utf8_lossy(bytes);
    match sidecar::parse(&text) {
        Ok(sidecar) => {
            for camera in &sidecar.cameras {
                for axis in [camera.forward, camera.right, camera.up] {
                    let length = axis.iter().map(|along| along * along).sum::<f32>().sqrt();
                    assert!((length - 1.0).abs() < 1e-5, "{camera:?}");
                }
                assert!(camera.yfov_radians > 0.0 && camera.eye.iter().all(|along| along.is_finite()));
            }
        }
        Err(error) => assert_sentence(&fixture::sentence(&error)),
    }
    std::fs::write(&path, bytes).unwrap();
    assert_eq!(
        sidecar::read(Path::new(&path)).is_ok(),
        std::str::from_utf8(bytes).is_ok_and(|text| sidecar::parse(text).is_ok())
    );
}
