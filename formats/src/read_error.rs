//! What can go wrong while a dump is read.

use std::io;
use std::path::PathBuf;

use crate::manifest::{self, Fault, ManifestError, Place};
use crate::npy::NpyError;

/// Why a dump or one of its arrays cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// There is nothing of that name.
    #[error("there is no recording {}{hint}", path.display())]
    Missing {
        /// What was asked for.
        path: PathBuf,
        /// What there is instead; may be empty.
        hint: String,
    },
    /// Something else than a dump's folder.
    #[error("{} is not a recording: expected a folder with a {}", path.display(), manifest::FILE_NAME)]
    NotARecording {
        /// What was asked for.
        path: PathBuf,
    },
    /// The manifest cannot be read at all.
    #[error(transparent)]
    Manifest(#[from] ManifestError),
    /// Not even the header of the manifest is there.
    #[error("{} holds no header yet, so there is nothing to read", path.display())]
    Empty {
        /// The manifest.
        path: PathBuf,
    },
    /// The manifest of a dump is damaged.
    #[error("{}: {fault}; `inspector recover` keeps what comes before", path.display())]
    Damaged {
        /// The manifest.
        path: PathBuf,
        /// Where and how.
        fault: Fault,
    },
    /// The manifest of a dump has no end record.
    #[error("{} ends without an end record: the recording was not finished, or the file was cut; `inspector recover` makes it a dump", path.display())]
    NoEnd {
        /// The manifest.
        path: PathBuf,
    },
    /// The dump has no such array.
    #[error("{} has no {place}{hint}", dump.display())]
    NoSuchArray {
        /// The dump.
        dump: PathBuf,
        /// The array.
        place: Place,
        /// Where it may be, or why it is not there; may be empty.
        hint: String,
    },
    /// An array was asked for as something that it is not.
    #[error("{place} is {found}; it was asked for as {expected}")]
    WrongType {
        /// The array.
        place: Place,
        /// Type and shape on disk.
        found: String,
        /// Type asked for.
        expected: String,
    },
    /// A file or folder of the dump cannot be read.
    #[error("cannot read {}: {cause}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What the system said.
        cause: io::Error,
    },
    /// Something else than a plain file or folder, such as a link that may lead out of the dump.
    #[error("{} is {found}; expected a plain {expected}", path.display())]
    NotPlain {
        /// The path.
        path: PathBuf,
        /// What is there.
        found: &'static str,
        /// What should be there.
        expected: &'static str,
    },
    /// A file that is shorter or longer than its record says.
    #[error("{} is {found} bytes long; expected {expected}, of which {data} are data", path.display())]
    FileLength {
        /// The file.
        path: PathBuf,
        /// Its length.
        found: u64,
        /// Length of the header and the data.
        expected: u64,
        /// Length of the data.
        data: u64,
    },
    /// Data that are not those that were written.
    #[error("{}: the checksum of the data is {found:08x}, expected {expected:08x}; `inspector recover` keeps the rest", path.display())]
    Checksum {
        /// The file.
        path: PathBuf,
        /// CRC-32C of its data.
        found: u32,
        /// That of its record.
        expected: u32,
    },
    /// A file that does not start with an NPY header.
    #[error("{}: {cause}", path.display())]
    Npy {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        cause: NpyError,
    },
    /// A file whose header says something else than its record.
    #[error("{}: the NPY header at offset 0 says {found}; expected {expected}", path.display())]
    Header {
        /// The file.
        path: PathBuf,
        /// Type and shape in the header.
        found: String,
        /// Type and shape in the manifest.
        expected: String,
    },
}
