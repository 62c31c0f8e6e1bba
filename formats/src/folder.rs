//! Names of a dump's folder in its stages, and what may be done to them.

use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::fs::{self, File, TryLockError};
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use crate::manifest::scan::scan;
use crate::manifest::{self, Place, Record};

/// A dump's folder ends in this.
pub const EXTENSION: &str = "raydump";

/// A file without content that a `.partial` folder holds until the dump is finished: on a full disk
/// its place is what `recover` needs to end the manifest.
pub const RESERVE_NAME: &str = "reserve.bin";
/// Its length; file systems give out space in blocks of 4 KiB or more.
pub(crate) const RESERVE_BYTES: usize = 16 << 10;

/// A manifest that `recover` writes, until it takes the old one's name.
pub(crate) const NEW_MANIFEST: &str = "manifest.bin.new";

/// The folder that `out` names: the extension is added if the last part does not have it already.
/// `None` if `out` has no last part, such as `/` or `..`.
pub fn dump_folder(out: &Path) -> Option<PathBuf> {
    // Without dots at the end, which would be no name to rename to.
    let out: &Path = &out.components().collect::<PathBuf>();
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

/// The recording, finished or not, in whose folder `path` lies, by any links.
pub(crate) fn recording_around(path: &Path) -> Option<PathBuf> {
    let folder = fs::canonicalize(parent(path)).ok()?;
    folder.ancestors().find(|folder| has_manifest(folder)).map(Path::to_owned)
}

fn has_manifest(folder: &Path) -> bool {
    let manifest = folder.join(manifest::FILE_NAME);
    let mut magic = [0; manifest::MAGIC.len()];
    let is_file = fs::symlink_metadata(&manifest).is_ok_and(|metadata| metadata.is_file());
    is_file
        && File::open(manifest).and_then(|mut file| file.read_exact(&mut magic)).is_ok()
        && magic == manifest::MAGIC
}

/// Why a folder is not replaced by a recording.
#[derive(Debug)]
pub(crate) enum Foreign {
    /// It is none.
    NotARecording,
    /// A link, whose end may be anything.
    Link,
    /// It holds a file that no recording put there.
    File(PathBuf),
}

/// The files and folders of a recording, so that they can be removed and nothing else.
#[derive(Debug, Default)]
pub(crate) struct Contents {
    /// Paths from the folder.
    pub(crate) files: Vec<PathBuf>,
    /// Likewise, each after the one that it lies in.
    pub(crate) folders: Vec<PathBuf>,
}

impl Contents {
    pub(crate) fn of(root: &Path) -> io::Result<Self> {
        let mut contents = Self::default();
        let mut open = vec![PathBuf::new()];
        while let Some(folder) = open.pop() {
            for entry in fs::read_dir(root.join(&folder))? {
                let entry = entry?;
                let path = folder.join(entry.file_name());
                if entry.file_type()?.is_dir() {
                    contents.folders.push(path.clone());
                    open.push(path);
                } else {
                    contents.files.push(path);
                }
            }
        }
        Ok(contents)
    }

    /// Removes the recording in `root`; what was put there since it was looked through stays, with its folders.
    pub(crate) fn remove(&self, root: &Path) -> io::Result<()> {
        self.files.iter().try_for_each(|file| fs::remove_file(root.join(file)))?;
        self.folders.iter().rev().try_for_each(|folder| fs::remove_dir(root.join(folder)))?;
        fs::remove_dir(root)
    }
}

/// What is in `folder` if it holds what its manifest lists and nothing else. Where the manifest has no end,
/// whatever lies where arrays do counts as the recording's: it may have been ended within one.
pub(crate) fn replaceable(folder: &Path) -> io::Result<Result<Contents, Foreign>> {
    let kind = fs::symlink_metadata(folder)?.file_type();
    if !kind.is_dir() {
        return Ok(Err(if kind.is_symlink() { Foreign::Link } else { Foreign::NotARecording }));
    }
    let contents = Contents::of(folder)?;
    if contents.files.is_empty() {
        // A recorder that is killed at once leaves a folder without anything.
        return Ok(Ok(contents));
    }
    if !contents.files.iter().any(|file| file == Path::new(manifest::FILE_NAME)) {
        return Ok(Err(Foreign::NotARecording));
    }
    let listed = listed_arrays(&folder.join(manifest::FILE_NAME));
    let is_known = |file: &PathBuf| {
        let Some(name) = file.to_str() else { return false };
        let own = [manifest::FILE_NAME, NEW_MANIFEST, RESERVE_NAME];
        let is_array = || Place::parse(&name.replace(std::path::MAIN_SEPARATOR, "/"));
        own.contains(&name)
            || is_array().is_some_and(|place| listed.as_ref().is_none_or(|listed| listed.contains(&place)))
    };
    Ok(match contents.files.iter().find(|file| !is_known(file)) {
        Some(file) => Err(Foreign::File(file.clone())),
        None => Ok(contents),
    })
}

/// The arrays of a manifest; `None` if it has no end, or cannot be read.
fn listed_arrays(manifest: &Path) -> Option<BTreeSet<Place>> {
    let frames = fs::symlink_metadata(manifest).ok()?.is_file().then(|| scan(manifest).ok())??.frames;
    matches!(frames.last()?.record, Record::End(_)).then(|| {
        let places = frames.into_iter().filter_map(|frame| match frame.record {
            Record::Array(array) => Some(array.place),
            _ => None,
        });
        places.collect()
    })
}

/// How long a recorder may take to go after it was killed: its last sync has to end first.
const PATIENCE: Duration = Duration::from_secs(10);

/// Whether another process is writing the dump in `folder`, and goes on for [`PATIENCE`].
pub(crate) fn is_being_written(folder: &Path) -> bool {
    let manifest = folder.join(manifest::FILE_NAME);
    // A pipe would make us wait for ever.
    let is_file = fs::symlink_metadata(&manifest).is_ok_and(|metadata| metadata.is_file());
    let Some(file) = is_file.then(|| File::open(&manifest).ok()).flatten() else { return false };
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
            ("a.raydump/", Some("a.raydump")),
            ("x/a.raydump/.", Some("x/a.raydump")),
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
        let root = folder.path().join("a");
        let found = || match replaceable(&root).unwrap() {
            Ok(_) => "may".to_owned(),
            Err(foreign) => format!("{foreign:?}"),
        };
        fs::create_dir_all(root.join("pass-000/bounce-00/closest")).unwrap();
        assert_eq!(found(), "may", "folders without a file");
        fs::write(root.join("pass-000/bounce-00/closest/rays.npy"), b"").unwrap();
        assert_eq!(found(), "NotARecording", "no manifest");
        fs::write(root.join("manifest.bin"), b"").unwrap();
        assert_eq!(found(), "may", "a manifest without an end");
        for notes in ["thesis.tex", "scene/notes.txt", "pass-000/bounce-00/closest/notes.npy"] {
            fs::create_dir_all(root.join("scene")).unwrap();
            fs::write(root.join(notes), b"").unwrap();
            assert_eq!(found(), format!("File({notes:?})"));
            fs::remove_file(root.join(notes)).unwrap();
        }
        let contents = replaceable(&root).unwrap().unwrap();
        fs::write(root.join("scene/notes.txt"), b"just written").unwrap();
        assert!(contents.remove(&root).is_err());
        assert_eq!(fs::read(root.join("scene/notes.txt")).unwrap(), b"just written");
    }
}
