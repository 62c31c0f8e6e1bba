//! What the tests `corpus` do with each file that was worth keeping.

use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

/// No file here may keep a program longer, however busy the machine; the slowest takes a hundredth of it.
const PATIENCE: Duration = Duration::from_secs(20);

/// Checks the files of a folder of this crate's corpus, which has so many at least.
pub(crate) fn each_file(folder: &str, least: usize, check: fn(&[u8])) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/corpus").join(folder);
    let mut files: Vec<_> = fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    assert!(files.len() >= least, "{} is not all there", folder.display());
    for file in files {
        // The name stands above the message if the check panics.
        eprintln!("{}", file.display());
        let (bytes, start) = (fs::read(&file).unwrap(), Instant::now());
        check(&bytes);
        assert!(start.elapsed() < PATIENCE, "{:?}", start.elapsed());
    }
}
