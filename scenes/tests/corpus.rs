//! Hostile files that were worth keeping: first inputs of the fuzz targets, and what these found.
#![allow(clippy::unwrap_used, reason = "this is test code, also outside test functions")]

#[path = "../../formats/tests/hostile/each_file.rs"]
mod each_file;
mod hostile;

use each_file::each_file;

#[test]
fn scene_files() {
    each_file("gltf", 2, hostile::gltf);
}

#[test]
fn sidecars() {
    each_file("sidecar", 2, hostile::sidecar);
}
