//! What can go wrong while a dump is read.

use std::io;
use std::path::PathBuf;

use crate::manifest::{self, Fault, ManifestError, Place};
use crate::npy::NpyError;

/// Why a dump or one of its arrays cannot be read.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "each message says what it and its fields mean")]
pub enum ReadError {
    #[error("there is no recording {}{hint}", path.display())]
    Missing { path: PathBuf, hint: String },
    #[error("{} is not a recording: expected a folder with a {}", path.display(), manifest::FILE_NAME)]
    NotARecording { path: PathBuf },
    /// The manifest cannot be read at all.
    #[error(transparent)]
    Manifest(#[from] ManifestError),
    #[error("{} holds no header yet, so there is nothing to read", path.display())]
    Empty { path: PathBuf },
    /// The manifest of a dump is damaged.
    #[error("{}: {fault}; `inspector recover` keeps what comes before", path.display())]
    Damaged { path: PathBuf, fault: Fault },
    #[error("{} ends without an end record: the recording was not finished, or the file was cut; `inspector recover` makes it a dump", path.display())]
    NoEnd { path: PathBuf },
    #[error("{} has no {place}{hint}", dump.display())]
    NoSuchArray { dump: PathBuf, place: Place, hint: String },
    #[error("{place} is {found}; it was asked for as {expected}")]
    WrongType { place: Place, found: String, expected: String },
    #[error("cannot read {}: {cause}", path.display())]
    Io { path: PathBuf, cause: io::Error },
    /// Something else than a plain file or folder, such as a link that may lead out of the dump.
    #[error("{} is {found}; expected a plain {expected}", path.display())]
    NotPlain { path: PathBuf, found: &'static str, expected: &'static str },
    #[error("{} is {found} bytes long; expected {expected}, of which {data} are data", path.display())]
    FileLength { path: PathBuf, found: u64, expected: u64, data: u64 },
    /// Data that are not those that were written.
    #[error("{}: the checksum of the data is {found:08x}, expected {expected:08x}; `inspector recover` keeps the rest", path.display())]
    Checksum { path: PathBuf, found: u32, expected: u32 },
    /// A file that does not start with an NPY header.
    #[error("{}: {cause}", path.display())]
    Npy { path: PathBuf, cause: NpyError },
    #[error("{}: the NPY header at offset 0 says {found}; expected {expected}", path.display())]
    Header { path: PathBuf, found: String, expected: String },
}
