//! Makes a dump of what a recording left that did not end, or that was damaged.
//!
//! Every record of the manifest that can be read is kept, but those of arrays that are not whole
//! (length, header and checksum) and of methods whose own record is lost; an end record says that it
//! was recovered. Array files are never copied, changed or deleted: what is kept stays where it is,
//! everything else (an array that was being written, damaged ones, a manifest of which whole records
//! are left out) moves to `NAME.raydump.leftover` beside the dump, which the user may delete. Ended
//! at any moment, it can be run again.

use std::collections::BTreeSet;
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use rayon::prelude::*;

use crate::array_file;
use crate::folder::{self, Contents, NEW_MANIFEST};
use crate::key::method::WITHOUT_LAYOUT;
use crate::manifest::scan::salvage;
use crate::manifest::{self, ArrayRecord, End, Fault, ManifestError, Outcome, Place, Record, encode_frame};

/// Why nothing could be recovered.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "each message says what it and its fields mean")]
pub enum RecoverError {
    #[error("there is no recording {}, and no .partial folder of that name", path.display())]
    Missing { path: PathBuf },
    /// The manifest has no header, or nothing after it was complete.
    #[error("nothing was complete yet in {}, so there is nothing to recover", path.display())]
    Nothing { path: PathBuf },
    #[error("nothing is whole in {}, so there is nothing to recover: {first}", path.display())]
    Damaged { path: PathBuf, first: String },
    /// Something else in the place of the manifest, such as a link that may lead out of the folder.
    #[error("{} is not a plain file, so that it is not written to", path.display())]
    NotPlain { path: PathBuf },
    #[error("{} is being written by another process; wait until it ends", path.display())]
    Busy { path: PathBuf },
    #[error("{} exists already; rename {} to another NAME.raydump.partial first", dump.display(), partial.display())]
    Exists { dump: PathBuf, partial: PathBuf },
    /// The manifest is not one of this version.
    #[error(transparent)]
    Manifest(#[from] ManifestError),
    #[error("cannot {action} {}: {cause}; nothing is lost, so run recover again when that is mended", path.display())]
    Io { action: &'static str, path: PathBuf, cause: io::Error },
}

/// What was recovered.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Recovery {
    /// The dump.
    pub dump: PathBuf,
    /// Arrays that it holds.
    pub arrays: usize,
    /// Bytes of their data.
    pub bytes: u64,
    /// Whether the recording had ended, so that nothing is missing.
    pub is_complete: bool,
    /// Why the manifest was cut, if it was.
    pub cut: Option<String>,
    /// What is wrong with each record that was left out before that.
    pub left_out: Vec<String>,
    /// Files that do not belong to the dump, and where they are now.
    pub leftover: Option<(PathBuf, usize)>,
}

/// What of a manifest is kept.
struct Kept {
    /// Of the format, which says by which rules the records are read.
    version: u32,
    /// Without the end record.
    records: Vec<Record>,
    end: Option<End>,
    cut: Option<String>,
    left_out: Vec<String>,
    /// Bytes of the manifest up to half a record, if that is all that is left out, as when the
    /// recorder was killed.
    whole_bytes: Option<u64>,
}

impl Kept {
    fn arrays(&self) -> impl Iterator<Item = &ArrayRecord> {
        self.records.iter().filter_map(|record| match record {
            Record::Array(array) => Some(array),
            _ => None,
        })
    }

    /// Whether there is more than what stands in a manifest before the first array.
    fn is_empty(&self) -> bool {
        self.records.iter().all(|record| matches!(record, Record::Header(_) | Record::Method(_)))
    }

    /// Whether the manifest is already what it is going to be.
    fn is_all(&self) -> bool {
        self.end.is_some() && self.cut.is_none() && self.left_out.is_empty()
    }

    /// The end record of what is kept.
    fn new_end(&self) -> End {
        match self.end {
            Some(end) if self.left_out.is_empty() => end,
            Some(end) => End { outcome: Outcome::Recovered, ..end },
            None => End { outcome: Outcome::Recovered, image: None, wall_ns: 0 },
        }
    }
}

/// Recovers the recording in `path`: a `.partial` folder, the dump that it was going to be, or a
/// damaged dump.
///
/// # Errors
/// If no array was complete, the recorder is still running, or a file cannot be read or moved.
pub fn recover(path: &Path) -> Result<Recovery, RecoverError> {
    let root = find(path)?;
    let manifest_path = root.join(manifest::FILE_NAME);
    // Before it is opened: a pipe would make us wait for ever.
    match fs::symlink_metadata(&manifest_path) {
        Ok(metadata) if metadata.is_file() => {}
        Ok(_) => return Err(RecoverError::NotPlain { path: manifest_path }),
        Err(_) => return Err(RecoverError::Nothing { path: root }),
    }
    if folder::is_being_written(&root) {
        return Err(RecoverError::Busy { path: root });
    }
    let dump = folder::dump_of_partial(&root).unwrap_or_else(|| root.clone());
    if dump != root && folder::exists(&dump) {
        return Err(RecoverError::Exists { dump, partial: root });
    }
    let kept = whole_records(&root, &manifest_path)?;
    if kept.is_empty() {
        return Err(match kept.left_out.into_iter().next() {
            Some(first) => RecoverError::Damaged { path: root, first },
            None => RecoverError::Nothing { path: root },
        });
    }
    let reserve = root.join(folder::RESERVE_NAME);
    if folder::exists(&reserve) {
        fs::remove_file(&reserve).map_err(io_error("remove", &reserve))?;
    }
    for array in kept.arrays() {
        let path = root.join(array.place.to_string());
        File::open(&path).and_then(|file| sync(&file)).map_err(io_error("write", &path))?;
    }
    let mut leftover = Leftover { beside: dump.clone(), folder: None, files: 0 };
    if !kept.is_all() {
        end_manifest(&root, &manifest_path, &kept, &mut leftover)?;
    }
    let places: BTreeSet<String> = kept.arrays().map(|array| array.place.to_string()).collect();
    for stray in strays(&root, &places).map_err(io_error("read", &root))? {
        leftover.take(&root, &stray)?;
    }
    remove_empty_folders(&root).map_err(io_error("read", &root))?;
    folder::sync_folder(&root).map_err(io_error("write", &root))?;
    if dump != root {
        fs::rename(&root, &dump).map_err(io_error("rename", &root))?;
    }
    let parent = folder::parent(&dump);
    folder::sync_folder(parent).map_err(io_error("write", parent))?;
    Ok(Recovery {
        arrays: kept.arrays().count(),
        bytes: kept.arrays().map(|array| array.bytes).sum(),
        is_complete: kept.new_end().outcome == Outcome::Complete,
        cut: kept.cut,
        left_out: kept.left_out,
        leftover: leftover.folder.map(|folder| (folder, leftover.files)),
        dump,
    })
}

fn find(path: &Path) -> Result<PathBuf, RecoverError> {
    if path.is_dir() {
        return Ok(path.to_owned());
    }
    let dump = folder::dump_folder(path);
    let candidates = dump.iter().flat_map(|dump| [dump.clone(), folder::partial_of(dump)]);
    let missing = || RecoverError::Missing { path: path.to_owned() };
    candidates.into_iter().find(|candidate| candidate.is_dir()).ok_or_else(missing)
}

/// The records that can be read and whose arrays are whole.
fn whole_records(root: &Path, manifest_path: &Path) -> Result<Kept, RecoverError> {
    let salvage = salvage(manifest_path)?;
    let manifest_bytes = salvage.frames.last().map_or(0, |frame| frame.end);
    let is_plain_tail = matches!(salvage.fault, None | Some(Fault::Torn { .. }));
    let mut left_out: Vec<String> = salvage.passed_over.iter().map(Fault::to_string).collect();
    let damages: Vec<_> = salvage
        .frames
        .par_iter()
        .map(|frame| match &frame.record {
            Record::Array(array) => damage(root, array),
            _ => None,
        })
        .collect();
    let mut records = Vec::new();
    let mut end = None;
    for (frame, damage) in salvage.frames.into_iter().zip(damages) {
        match (frame.record, damage) {
            (_, Some(damage)) => left_out.push(damage),
            (Record::End(found), None) => end = Some(found),
            (record, None) => records.push(record),
        }
    }
    leave_out_lost_methods(&mut records, &mut left_out);
    Ok(Kept {
        version: salvage.version,
        records,
        end,
        cut: salvage.fault.map(|fault| fault.to_string()),
        whole_bytes: (is_plain_tail && left_out.is_empty()).then_some(manifest_bytes),
        left_out,
    })
}

/// What a method made has no meaning without the method's record.
fn leave_out_lost_methods(records: &mut Vec<Record>, left_out: &mut Vec<String>) {
    let names = records.iter().filter_map(|record| match record {
        Record::Method(method) => Some(method.name.clone()),
        _ => None,
    });
    let names: BTreeSet<String> = names.chain(WITHOUT_LAYOUT.map(str::to_owned)).collect();
    records.retain_mut(|record| match record {
        Record::Array(array) => match &array.place {
            Place::Method(_, method, _) if !names.contains(method) => {
                left_out.push(format!("{}: the record of its method is lost", array.place));
                false
            }
            _ => true,
        },
        Record::Timing(timing) => names.contains(&timing.method),
        Record::Cache(cache) => names.contains(&cache.method),
        Record::Disturbed(disturbed) => names.contains(&disturbed.method),
        Record::Way(way) => names.contains(&way.method),
        Record::Queue(queue) => {
            queue.methods.retain(|method| names.contains(method));
            queue.mismatches.retain(|mismatches| names.contains(&mismatches.method));
            true
        }
        _ => true,
    });
}

/// What is wrong with an array's file, if anything.
pub(crate) fn damage(root: &Path, array: &ArrayRecord) -> Option<String> {
    match array_file::checksum(root, array) {
        Ok(found) => (found != array.crc32c).then(|| {
            format!("{}: the checksum of the data is {found:08x}, expected {:08x}", array.place, array.crc32c)
        }),
        Err(error) => Some(error.to_string()),
    }
}

/// Makes the manifest one of the kept records and an end.
fn end_manifest(
    root: &Path,
    manifest: &Path,
    kept: &Kept,
    leftover: &mut Leftover,
) -> Result<(), RecoverError> {
    let encode = |record: &Record| {
        let too_long = |bytes| io::Error::other(format!("a record of {bytes} bytes is too long"));
        encode_frame(record).map_err(too_long).map_err(io_error("write", manifest))
    };
    let end = encode(&Record::End(kept.new_end()))?;
    let may_write = folder::dump_of_partial(root).is_some() && !is_shared(manifest);
    if let Some(whole_bytes) = kept.whole_bytes.filter(|_| may_write) {
        // In place, since a full disk may have no room for a second manifest.
        let end = if kept.end.is_some() { &[][..] } else { &end };
        return end_in_place(manifest, whole_bytes, end).map_err(io_error("write", manifest));
    }
    let new = root.join(NEW_MANIFEST);
    // One that is there already was left by a run that was ended; a link would be followed.
    if folder::exists(&new) {
        fs::remove_file(&new).map_err(io_error("remove", &new))?;
    }
    let file = File::create_new(&new).map_err(io_error("create", &new))?;
    let mut file = BufWriter::new(file);
    file.write_all(&manifest::preamble_of(kept.version)).map_err(io_error("write", &new))?;
    for record in &kept.records {
        file.write_all(&encode(record)?).map_err(io_error("write", &new))?;
    }
    file.write_all(&end).map_err(io_error("write", &new))?;
    let file = file.into_inner().map_err(io::IntoInnerError::into_error).map_err(io_error("write", &new))?;
    file.sync_all().map_err(io_error("write", &new))?;
    drop(file);
    if kept.cut.is_some() || !kept.left_out.is_empty() {
        leftover.keep_a_copy(manifest)?;
    }
    fs::rename(&new, manifest).map_err(io_error("rename", &new))
}

/// Whether a file has another name, as in a copy made of links, which must stay as it is.
fn is_shared(file: &Path) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        fs::metadata(file).is_ok_and(|metadata| metadata.nlink() > 1)
    }
    #[cfg(not(unix))]
    {
        let _ = file;
        false
    }
}

/// Ended half-way, this leaves half a record at the end, as it found it.
fn end_in_place(manifest: &Path, kept_bytes: u64, frame: &[u8]) -> io::Result<()> {
    let mut file = OpenOptions::new().write(true).open(manifest)?;
    file.set_len(kept_bytes)?;
    file.seek(SeekFrom::End(0))?;
    file.write_all(frame)?;
    file.sync_all()
}

/// The folder for what is not part of the dump, made when it is needed.
struct Leftover {
    beside: PathBuf,
    folder: Option<PathBuf>,
    files: usize,
}

impl Leftover {
    fn folder(&mut self) -> Result<PathBuf, RecoverError> {
        if let Some(folder) = &self.folder {
            return Ok(folder.clone());
        }
        let mut number = 1;
        let mut folder = folder::beside(&self.beside, ".leftover");
        while folder::exists(&folder) {
            number += 1;
            folder = folder::beside(&self.beside, &format!(".leftover-{number}"));
        }
        fs::create_dir(&folder).map_err(io_error("create", &folder))?;
        self.folder = Some(folder.clone());
        Ok(folder)
    }

    fn keep_a_copy(&mut self, file: &Path) -> Result<(), RecoverError> {
        let copy = self.folder()?.join(file.file_name().unwrap_or_default());
        // A link takes no space, of which a full disk has none.
        if fs::hard_link(file, &copy).is_err() {
            fs::copy(file, &copy).map_err(io_error("copy", file))?;
        }
        self.files += 1;
        Ok(())
    }

    fn take(&mut self, root: &Path, relative: &Path) -> Result<(), RecoverError> {
        let (from, to) = (root.join(relative), self.folder()?.join(relative));
        let folder = folder::parent(&to);
        fs::create_dir_all(folder).map_err(io_error("create", folder))?;
        fs::rename(&from, &to).map_err(io_error("move", &from))?;
        self.files += 1;
        Ok(())
    }
}

/// Paths from the root of everything but folders that is no manifest and not in `known`, whose paths have `/`.
pub(crate) fn strays(root: &Path, known: &BTreeSet<String>) -> io::Result<Vec<PathBuf>> {
    let mut files = Contents::of(root)?.files;
    files.retain(|file| {
        let name = file.to_str().map(|name| name.replace(std::path::MAIN_SEPARATOR, "/"));
        !name.is_some_and(|name| name == manifest::FILE_NAME || known.contains(&name))
    });
    files.sort();
    Ok(files)
}

fn remove_empty_folders(root: &Path) -> io::Result<()> {
    for folder in Contents::of(root)?.folders.iter().rev().map(|folder| root.join(folder)) {
        if fs::read_dir(&folder)?.next().is_none() {
            fs::remove_dir(&folder)?;
        }
    }
    Ok(())
}

fn sync(file: &File) -> io::Result<()> {
    // Other systems sync only files that are open for writing; there the writer did what can be done.
    if cfg!(unix) { file.sync_all() } else { Ok(()) }
}

fn io_error(action: &'static str, path: &Path) -> impl FnOnce(io::Error) -> RecoverError {
    move |cause| RecoverError::Io { action, path: path.to_owned(), cause }
}
