//! What was computed of the recordings of a study, in its folder, by their content.

use std::io;
use std::path::{Path, PathBuf};

use formats::files::{read_plain, replace};
use formats::manifest;
use formats::study::{SUMMARIES_NAME, Study};
use formats::summary::hexadecimal;
use serde::Serialize;
use serde::de::DeserializeOwned;
use sha2::{Digest, Sha256};

/// Changes with the numbers that are kept, or with what they are made of.
const VERSION: u32 = 2;
/// Bytes of the largest file that is read, and of the largest manifest that is hashed.
const BYTES_MAX: u64 = 256 << 20;

/// What the file at `path` holds, else what is made and then kept there. Second, why it could not be kept.
pub(super) fn kept<T: Serialize + DeserializeOwned, E>(
    path: &Path,
    make: impl FnOnce() -> Result<T, E>,
) -> Result<(T, Option<String>), E> {
    let found = read_plain(path, BYTES_MAX).ok().and_then(|bytes| serde_json::from_slice(&bytes).ok());
    if let Some(found) = found {
        return Ok((found, None));
    }
    let made = make()?;
    let notice = keep(path, &made).err().map(|error| error.to_string());
    Ok((made, notice))
}

fn keep(path: &Path, what: &impl Serialize) -> io::Result<()> {
    path.parent().map(std::fs::create_dir_all).transpose()?;
    replace(path, |file| Ok(serde_json::to_writer(file, what)?))
}

/// Where something of a recording is kept. The name is a hash of the program, of the manifest, which holds a checksum
/// of every array and of a replay's source, and of whether that is there; then `what`.
pub(super) fn place(study: &Study, recording: &Path, what: &str) -> io::Result<PathBuf> {
    let bytes = read_plain(&recording.join(manifest::FILE_NAME), BYTES_MAX)?;
    let neighbours = recording.parent().and_then(|job| std::fs::read_dir(job).ok());
    let dumps = neighbours.into_iter().flatten().flatten();
    let mut names: Vec<_> = dumps.map(|entry| entry.file_name()).collect();
    names.sort();
    let mut hash = Sha256::new();
    hash.update(format!("{VERSION} {} {names:?}", env!("CARGO_PKG_VERSION")));
    hash.update(bytes);
    Ok(study.root.join(SUMMARIES_NAME).join(format!("{}{what}.json", hexadecimal(&hash.finalize()))))
}
