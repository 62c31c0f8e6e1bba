//! What can go wrong while a dump is written.

use std::io;
use std::path::{Path, PathBuf};

use crate::manifest::Place;

/// Why a dump cannot be written.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "each message says what it and its fields mean")]
pub enum WriteError {
    /// The disk, or the user's share of it, is full.
    #[error("no space is left on the disk for {}; what was complete before is kept: make space, then run `inspector recover` on the .partial folder", path.display())]
    Full { path: PathBuf },
    /// The same, before there is anything to keep.
    #[error("no space is left on the disk for {}, so nothing was recorded; make space, or use another folder", path.display())]
    NoRoom { path: PathBuf },
    /// Any other failure of the system.
    #[error("cannot {action} {}: {cause}", path.display())]
    Io { action: &'static str, path: PathBuf, cause: io::Error },
    #[error("'{}' is not a name for a recording; expected something like NAME.raydump", path.display())]
    Name { path: PathBuf },
    #[error("{} exists already; use --force to replace it, or another name", path.display())]
    Exists { path: PathBuf },
    #[error("{} was left by a recording that did not end; keep it with `inspector recover`, or use --force to remove it", path.display())]
    LeftOver { path: PathBuf },
    #[error("{} is being written by another process; use another name", path.display())]
    Busy { path: PathBuf },
    #[error("{} is not a recording, so it is not replaced, even by --force; use another name", path.display())]
    NotARecording { path: PathBuf },
    #[error("{} is a link, so it is not replaced, even by --force; use the name that it leads to, or another", path.display())]
    Link { path: PathBuf },
    #[error("{} holds {}, which is no part of the recording, so it is not replaced, even by --force; move that file, or use another name", path.display(), file.display())]
    ForeignFile { path: PathBuf, file: PathBuf },
    #[error("{} would replace or lie in the recording {}; use another name", path.display(), origin.display())]
    Source { path: PathBuf, origin: PathBuf },
    #[error("{place} cannot be {found}; expected {expected}")]
    Shape { place: Place, found: String, expected: String },
    #[error("{place} was given {found} bytes; expected {expected}")]
    Count { place: Place, found: u64, expected: u64 },
    #[error("{place} was written before; an array is written once")]
    Twice { place: Place },
    /// A record that no reader would take.
    #[error("a record of {bytes} bytes is too long for {}", path.display())]
    RecordTooLong { path: PathBuf, bytes: usize },
    #[error("{} could not be written before, so nothing can be added", path.display())]
    Broken { path: PathBuf },
}

impl WriteError {
    /// The same, of a recording of which nothing is kept.
    pub fn with_nothing_kept(self) -> Self {
        match self {
            Self::Full { path } => Self::NoRoom { path },
            error => error,
        }
    }
}

/// Turns the system's error into ours, with what was being done to which path.
pub(super) fn io_error(action: &'static str, path: &Path) -> impl FnOnce(io::Error) -> WriteError {
    move |cause| match cause.kind() {
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => {
            WriteError::Full { path: path.to_owned() }
        }
        _ => WriteError::Io { action, path: path.to_owned(), cause },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_full_disk_has_a_message_of_its_own() {
        let path = Path::new("x.raydump.partial/image.npy");
        let full = io_error("write", path)(io::ErrorKind::StorageFull.into());
        assert!(matches!(&full, WriteError::Full { .. }), "{full}");
        assert!(full.to_string().contains("image.npy") && full.to_string().contains("recover"), "{full}");
        let nothing = full.with_nothing_kept().to_string();
        assert!(nothing.contains("no space is left") && !nothing.contains("recover"), "{nothing}");
        let denied = io_error("create", path)(io::ErrorKind::PermissionDenied.into()).to_string();
        assert!(denied.starts_with("cannot create x.raydump.partial/image.npy"), "{denied}");
    }
}
