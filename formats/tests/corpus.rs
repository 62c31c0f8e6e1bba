//! Hostile files that were worth keeping: first inputs of the fuzz targets, and what these found.
#![allow(clippy::unwrap_used, reason = "this is test code, also outside test functions")]

#[path = "hostile/each_file.rs"]
mod each_file;
mod hostile;

use each_file::each_file;

#[test]
fn manifests() {
    each_file("manifest", 3, hostile::manifest);
}

#[test]
fn npy_headers() {
    each_file("npy_header", 3, hostile::npy_header);
}

#[test]
fn layouts() {
    each_file("layout", 3, hostile::layout);
}

#[test]
fn dumps() {
    each_file("dump", 3, hostile::dump);
}

#[test]
fn queues() {
    each_file("queue", 3, hostile::queue);
}
