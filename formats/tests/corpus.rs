//! Hostile files that were worth keeping: first inputs of the fuzz targets, and what these found.
#![allow(clippy::unwrap_used, reason = "this is test code, also outside test functions")]

mod hostile;

use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

/// No file here may keep a program longer, however busy the machine; the slowest takes a hundredth of it.
const PATIENCE: Duration = Duration::from_secs(20);

fn each_file(folder: &str, check: fn(&[u8])) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/corpus").join(folder);
    let mut files: Vec<_> = fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    assert!(files.len() >= 3, "{} is not all there", folder.display());
    for file in files {
        // The name stands above the message if the check panics.
        eprintln!("{}", file.display());
        let (bytes, start) = (fs::read(&file).unwrap(), Instant::now());
        check(&bytes);
        assert!(start.elapsed() < PATIENCE, "{:?}", start.elapsed());
    }
}

#[test]
fn manifests() {
    each_file("manifest", hostile::manifest);
}

#[test]
fn npy_headers() {
    each_file("npy_header", hostile::npy_header);
}

#[test]
fn layouts() {
    each_file("layout", hostile::layout);
}

#[test]
fn dumps() {
    each_file("dump", hostile::dump);
}

#[test]
fn queues() {
    each_file("queue", hostile::queue);
}
