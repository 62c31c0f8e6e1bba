//! Names of a dump's folder in its stages, and what may be done to them.

use std::ffi::OsStr;
use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use crate::manifest;

/// A dump's folder ends in this.
pub const EXTENSION: &str = "raydump";

/// A file without content that a `.partial` folder holds until the dump is finished: on a full disk
/// its place is what `recover` needs to end the manifest.
pub const RESERVE_NAME: &str = "reserve.bin";
/// Its length; file systems give out space in blocks of 4 KiB or more.
pub(crate) const RESERVE_BYTES: usize = 16 << 10;

/// The folder that `out` names: the extension is added if the last part does not have it already.
/// `None` if `out` has no last part, such as `/` or `..`.
pub fn dump_folder(out: &Path) -> Option<PathBuf> {
    let name = out.file_name()?;
    if Path::new(name).extension() == Some(OsStr::new(EXTENSION)) {
        return Some(out.to_owned());
    }
    Some(out.with_file_name(appended(name, &format!(".{EXTENSION}"))))
}

/// Where `dump` is written until it is complete: `NAME.raydump.partial`.
pub fn partial_of(dump: &Path) -> PathBuf {
    beside(dump, ".partial")
}

/// The dump that a `NAME.raydump.partial` was going to be; `None` for other names.
pub fn dump_of_partial(partial: &Path) -> Option<PathBuf> {
    let dump = partial.with_extension("");
    let is_partial = partial.extension() == Some(OsStr::new("partial"));
    (is_partial && dump.extension() == Some(OsStr::new(EXTENSION))).then_some(dump)
}

/// `folder` with `suffix` at the end of its name.
pub(crate) fn beside(folder: &Path, suffix: &str) -> PathBuf {
    folder.with_file_name(appended(folder.file_name().unwrap_or_default(), suffix))
}

fn appended(name: &OsStr, suffix: &str) -> std::ffi::OsString {
    let mut name = name.to_owned();
    name.push(suffix);
    name
}

/// Whether a path leads anywhere, be it by a dangling link.
pub(crate) fn exists(path: &Path) -> bool {
    fs::symlink_metadata(path).is_ok()
}

/// Whether a folder holds nothing but what a recording puts there, so that it may be replaced.
pub(crate) fn is_recording(folder: &Path) -> io::Result<bool> {
    if !folder.is_dir() {
        return Ok(false);
    }
    let mut has_manifest = false;
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let Some(name) = entry.file_name().to_str().map(str::to_owned) else { return Ok(false) };
        let is_folder = entry.file_type()?.is_dir();
        let known = match name.as_str() {
            manifest::FILE_NAME | crate::recover::NEW_MANIFEST | RESERVE_NAME | "image.npy" => !is_folder,
            "scene" => is_folder,
            _ => is_folder && name.starts_with("pass-"),
        };
        if !known {
            return Ok(false);
        }
        has_manifest |= name == manifest::FILE_NAME;
    }
    // A recorder that is killed at once leaves a folder without anything.
    Ok(has_manifest || fs::read_dir(folder)?.next().is_none())
}

/// How long a recorder may take to go after it was killed: its last sync has to end first.
const PATIENCE: Duration = Duration::from_secs(10);

/// Whether another process is writing the dump in `folder`, and goes on for [`PATIENCE`].
pub(crate) fn is_being_written(folder: &Path) -> bool {
    let Ok(file) = File::open(folder.join(manifest::FILE_NAME)) else { return false };
    let start = Instant::now();
    while matches!(file.try_lock_shared(), Err(TryLockError::WouldBlock)) {
        if start.elapsed() > PATIENCE {
            return true;
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    false
}

/// Makes the names in a folder as durable as the bytes of its files.
pub(crate) fn sync_folder(folder: &Path) -> io::Result<()> {
    // Other systems have no such call, and need none.
    if cfg!(unix) { File::open(folder)?.sync_all() } else { Ok(()) }
}

/// The folder that `path` lies in, `.` for a bare name.
pub(crate) fn parent(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_extension_is_added_once() {
        for (out, expected) in [
            ("a", Some("a.raydump")),
            ("x/a.raydump", Some("x/a.raydump")),
            ("a.raydump/", Some("a.raydump/")),
            ("sponza.v2", Some("sponza.v2.raydump")),
            ("/", None),
            ("..", None),
            ("", None),
        ] {
            assert_eq!(dump_folder(Path::new(out)), expected.map(PathBuf::from), "{out}");
        }
    }

    #[test]
    fn partial_folders_know_their_dumps() {
        let dump = Path::new("x/a.b.raydump");
        let partial = partial_of(dump);
        assert_eq!(partial, Path::new("x/a.b.raydump.partial"));
        assert_eq!(dump_of_partial(&partial).as_deref(), Some(dump));
        assert_eq!(dump_of_partial(dump), None);
        assert_eq!(dump_of_partial(Path::new("x/a.partial")), None);
        assert_eq!(partial_of(Path::new("a.raydump/")), Path::new("a.raydump.partial"));
    }

    #[test]
    fn only_recordings_may_be_replaced() {
        let folder = tempfile::tempdir().unwrap();
        assert!(is_recording(folder.path()).unwrap(), "an empty folder");
        fs::create_dir(folder.path().join("scene")).unwrap();
        assert!(!is_recording(folder.path()).unwrap(), "no manifest");
        fs::write(folder.path().join("manifest.bin"), b"").unwrap();
        assert!(is_recording(folder.path()).unwrap());
        fs::write(folder.path().join("thesis.tex"), b"").unwrap();
        assert!(!is_recording(folder.path()).unwrap(), "something else in it");
        assert!(!is_recording(&folder.path().join("thesis.tex")).unwrap(), "a file");
    }
}
