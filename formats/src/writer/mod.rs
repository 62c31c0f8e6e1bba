//! Writes a dump: streamed arrays, a manifest that only grows, and a rename at the very end.
//!
//! Everything goes to `NAME.raydump.partial`. An array's record is appended when its last byte has
//! been written, so that whatever ends the recording, the manifest names complete arrays alone.
//! A helper thread hands finished files to the disk while the next ones are being written.

mod array;
mod error;
mod write_back;

use std::collections::BTreeSet;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

pub use array::ArrayWriter;
pub use error::WriteError;

use crate::folder::{self, Contents, Foreign};
use crate::manifest::{self, ArrayRecord, End, Header, Place, Record, encode_frame};
use crate::npy::{self, Dtype, Element};
use error::io_error;
use write_back::WriteBack;

/// Writes one dump: one array after the other, and records between them.
///
/// Dropped without [`DumpWriter::finish`] it leaves the `.partial` folder, for `recover`.
#[derive(Debug)]
pub struct DumpWriter {
    target: PathBuf,
    partial: PathBuf,
    overwrite: bool,
    manifest: File,
    manifest_bytes: u64,
    is_broken: bool,
    written: BTreeSet<Place>,
    folders: BTreeSet<PathBuf>,
    write_back: WriteBack,
}

impl DumpWriter {
    /// Begins the dump `out`; `.raydump` is added to a name that does not end in it.
    ///
    /// With `overwrite`, an existing dump is replaced, but only when this one is complete, and what
    /// a killed recording left is removed at once. Nothing is replaced but what the manifest lists.
    ///
    /// # Errors
    /// If the dump exists (without `overwrite`), is no recording, is being written by another
    /// process, or cannot be created.
    pub fn create(out: &Path, header: Header, overwrite: bool) -> Result<Self, WriteError> {
        let (target, partial) = Self::check(out, overwrite, &[])?;
        if folder::exists(&partial) {
            let left = own_contents(&partial)?;
            left.remove(&partial).map_err(io_error("remove", &partial))?;
        }
        fs::create_dir(&partial).map_err(|cause| match cause.kind() {
            // It was not there a moment ago.
            io::ErrorKind::AlreadyExists => WriteError::Busy { path: partial.clone() },
            _ => io_error("create", &partial)(cause).with_nothing_kept(),
        })?;
        Self::begin(target, partial.clone(), overwrite, header).map_err(|error| {
            // There is nothing to recover in it, and the next recording of this name would be refused.
            let _ = fs::remove_dir_all(&partial);
            error.with_nothing_kept()
        })
    }

    /// Writes what is there before the first array into the new folder `partial`.
    fn begin(target: PathBuf, partial: PathBuf, overwrite: bool, header: Header) -> Result<Self, WriteError> {
        let path = partial.join(manifest::FILE_NAME);
        let mut file = create_file(&path)?;
        // Held until the end, so that no other process takes this folder for a left-over one. Where
        // the file system has no locks, that protection is missing, and nothing else.
        let _ = file.try_lock();
        file.write_all(&manifest::preamble()).map_err(io_error("write", &path))?;
        let reserve = partial.join(folder::RESERVE_NAME);
        create_file(&reserve)?.write_all(&[0; folder::RESERVE_BYTES]).map_err(io_error("write", &reserve))?;
        let write_back = WriteBack::start().map_err(io_error("start the write-back thread for", &partial))?;
        let mut writer = Self {
            target,
            partial,
            overwrite,
            manifest: file,
            manifest_bytes: manifest::PREAMBLE_BYTES as u64,
            is_broken: false,
            written: BTreeSet::new(),
            folders: BTreeSet::new(),
            write_back,
        };
        writer.record(&Record::Header(Box::new(header)))?;
        Ok(writer)
    }

    /// Whether [`DumpWriter::create`] would begin, without touching anything: for a word before long
    /// preparations. `sources` are files and folders that the dump is made from: neither they nor a folder
    /// above them are replaced, and nothing is written into them. Returns the folder of the dump and the
    /// one that it is written in.
    ///
    /// # Errors
    /// As [`DumpWriter::create`], as far as can be told without writing, and if the dump would take the
    /// place of a source.
    pub fn check(out: &Path, overwrite: bool, sources: &[&Path]) -> Result<(PathBuf, PathBuf), WriteError> {
        let target = folder::dump_folder(out).ok_or_else(|| WriteError::Name { path: out.to_owned() })?;
        let partial = folder::partial_of(&target);
        for source in sources {
            if touches(&target, source) || touches(&partial, source) {
                return Err(WriteError::Source { path: target, origin: (*source).to_owned() });
            }
        }
        if let Some(recording) = folder::recording_around(&target) {
            return Err(WriteError::Source { path: target, origin: recording });
        }
        check_target(&target, overwrite)?;
        if folder::exists(&partial) {
            if folder::is_being_written(&partial) {
                return Err(WriteError::Busy { path: partial });
            }
            // Whoever was writing it may have finished meanwhile.
            check_target(&target, overwrite)?;
        }
        if folder::exists(&partial) {
            if !overwrite {
                return Err(WriteError::LeftOver { path: partial });
            }
            own_contents(&partial)?;
        }
        Ok((target, partial))
    }

    /// Where the dump will be once it is finished.
    pub fn target(&self) -> &Path {
        &self.target
    }

    /// Begins an array; its data is streamed to the result, which must be finished.
    ///
    /// # Errors
    /// If the array was written before, cannot look like this, or its file cannot be created.
    pub fn array(
        &mut self,
        place: &Place,
        dtype: Dtype,
        shape: &[u64],
    ) -> Result<ArrayWriter<'_>, WriteError> {
        let bytes = npy::data_bytes(dtype, shape).filter(|_| place.allows(dtype, shape));
        let Some(bytes) = bytes else {
            return Err(WriteError::Shape {
                place: place.clone(),
                found: format!("{dtype} {shape:?}"),
                expected: place.expectation(),
            });
        };
        if self.written.contains(place) {
            return Err(WriteError::Twice { place: place.clone() });
        }
        let path = self.partial.join(place.to_string());
        self.make_folder(folder::parent(&path))?;
        let record = ArrayRecord { place: place.clone(), dtype, shape: shape.to_vec(), crc32c: 0, bytes };
        ArrayWriter::create(self, path, record)
    }

    /// Writes a whole array whose last dimension is that of `T`, the others as in `shape`.
    ///
    /// # Errors
    /// As [`DumpWriter::array`], and if the values do not fill the shape.
    pub fn whole_array<T: Element>(
        &mut self,
        place: &Place,
        shape: &[u64],
        values: &[T],
    ) -> Result<(), WriteError> {
        let mut array = self.array(place, T::DTYPE, shape)?;
        array.write(bytemuck::cast_slice(values))?;
        array.finish()
    }

    /// Appends a record in one piece. Those of the header, of arrays and of the end are the writer's own.
    ///
    /// # Errors
    /// If the manifest cannot be written.
    pub fn record(&mut self, record: &Record) -> Result<(), WriteError> {
        let path = self.partial.join(manifest::FILE_NAME);
        let frame =
            encode_frame(record).map_err(|bytes| WriteError::RecordTooLong { path: path.clone(), bytes })?;
        if self.is_broken {
            return Err(WriteError::Broken { path });
        }
        if let Err(cause) = self.manifest.write_all(&frame) {
            // Half a record must stay the last one; better still if it can be taken back.
            self.is_broken = true;
            let _ = self.manifest.set_len(self.manifest_bytes);
            return Err(io_error("write", &path)(cause));
        }
        self.manifest_bytes += frame.len() as u64;
        Ok(())
    }

    /// Waits until everything that was written so far is on the disk.
    ///
    /// # Errors
    /// If something cannot be written.
    pub fn sync(&mut self) -> Result<(), WriteError> {
        self.write_back.wait().map_err(|(path, cause)| io_error("write", &path)(cause))?;
        let path = self.partial.join(manifest::FILE_NAME);
        self.manifest.sync_data().map_err(io_error("write", &path))
    }

    /// Waits until everything is on the disk, ends the manifest and gives the dump its name.
    ///
    /// # Errors
    /// If anything cannot be written; the `.partial` folder stays.
    pub fn finish(mut self, end: End) -> Result<PathBuf, WriteError> {
        self.write_back.wait().map_err(|(path, cause)| io_error("write", &path)(cause))?;
        let reserve = self.partial.join(folder::RESERVE_NAME);
        fs::remove_file(&reserve).map_err(io_error("remove", &reserve))?;
        for folder in self.folders.iter().chain([&self.partial]) {
            folder::sync_folder(folder).map_err(io_error("write", folder))?;
        }
        self.record(&Record::End(end))?;
        let Self { target, partial, overwrite, manifest, .. } = self;
        let path = partial.join(manifest::FILE_NAME);
        manifest.sync_all().map_err(io_error("write", &path))?;
        // Locked until the dump has its name; other systems do not rename a folder in which a file is open.
        let _locked = cfg!(unix).then_some(manifest);
        replace(&partial, &target, overwrite)?;
        Ok(target)
    }

    fn make_folder(&mut self, folder: &Path) -> Result<(), WriteError> {
        if !self.folders.contains(folder) {
            fs::create_dir_all(folder).map_err(io_error("create", folder))?;
            let above = folder.ancestors().take_while(|above| *above != self.partial);
            self.folders.extend(above.map(Path::to_owned));
        }
        Ok(())
    }
}

/// Whether a dump may take the place of what is at `target`.
fn check_target(target: &Path, overwrite: bool) -> Result<(), WriteError> {
    if folder::exists(target) {
        if !overwrite {
            return Err(WriteError::Exists { path: target.to_owned() });
        }
        own_contents(target)?;
    }
    Ok(())
}

fn create_file(path: &Path) -> Result<File, WriteError> {
    OpenOptions::new().write(true).create_new(true).open(path).map_err(io_error("create", path))
}

/// What is in a folder that may be replaced, being a recording and nothing else.
fn own_contents(path: &Path) -> Result<Contents, WriteError> {
    let path = path.to_owned();
    folder::replaceable(&path).map_err(io_error("read", &path))?.map_err(|foreign| match foreign {
        Foreign::NotARecording => WriteError::NotARecording { path },
        Foreign::Link => WriteError::Link { path },
        Foreign::File(file) => WriteError::ForeignFile { path, file },
    })
}

/// Whether what is written to `target` would replace `source` or lie in it, by any of their names and links.
fn touches(target: &Path, source: &Path) -> bool {
    // A source that is not there is missed by whoever reads it.
    let Ok(source) = fs::canonicalize(source) else { return false };
    let by_parent = fs::canonicalize(folder::parent(target))
        .ok()
        .and_then(|parent| Some(parent.join(target.file_name()?)));
    let is_recording = source.join(manifest::FILE_NAME).exists();
    let names = [by_parent, fs::canonicalize(target).ok()];
    names.iter().flatten().any(|name| source.starts_with(name) || is_recording && name.starts_with(&source))
}

/// Gives a complete dump its name; an old one of that name goes only then.
fn replace(partial: &Path, target: &Path, overwrite: bool) -> Result<(), WriteError> {
    let mut old = None;
    if folder::exists(target) {
        if !overwrite {
            return Err(WriteError::Exists { path: target.to_owned() });
        }
        let contents = own_contents(target)?;
        let replaced = folder::beside(target, ".replaced");
        if folder::exists(&replaced) {
            // Left by a run that was ended in the middle of this.
            own_contents(&replaced)?.remove(&replaced).map_err(io_error("remove", &replaced))?;
        }
        fs::rename(target, &replaced).map_err(io_error("rename", target))?;
        old = Some((contents, replaced));
    }
    fs::rename(partial, target).map_err(io_error("rename", partial))?;
    let parent = folder::parent(target);
    folder::sync_folder(parent).map_err(io_error("write", parent))?;
    match old {
        Some((contents, replaced)) => contents.remove(&replaced).map_err(io_error("remove", &replaced)),
        None => Ok(()),
    }
}
