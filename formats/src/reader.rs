//! Reads dumps and trusts nothing: everything that the manifest says is checked before it is used.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use crate::array_file::{self, Access, described};
use crate::manifest::{self, ArrayRecord, Fault, Manifest, Outcome, Place, QueueArray, Source};
use crate::npy::Element;
use crate::text::shown;
use crate::{folder, manifest::scan::scan};

pub use crate::array_file::Loaded;
pub use crate::read_error::ReadError;

#[cfg(target_endian = "big")]
compile_error!("arrays are mapped as they lie in the file, which is little-endian");

/// How far a recording got.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DumpState {
    /// It ran to its end.
    Complete,
    /// It was ended early and made a dump by `recover`.
    Recovered,
    /// It is still being written, or was ended early: a `.partial` folder.
    Partial,
}

/// A dump, opened for reading. Arrays are loaded when they are asked for.
#[derive(Debug)]
pub struct Dump {
    root: PathBuf,
    manifest: Manifest,
    places: BTreeMap<Place, usize>,
    state: DumpState,
    /// The recording whose rays a replay measured, if it was found.
    source: Option<Box<Dump>>,
    /// How its arrays and those of its source get into memory.
    access: Access,
}

impl Dump {
    /// Opens the dump in a folder, or what there is so far in a `.partial` folder. Each array that is asked
    /// for is copied into memory, so that a file which somebody cuts meanwhile is an error like any other.
    ///
    /// # Errors
    /// If there is no dump or its manifest is damaged. Arrays are checked when they are loaded.
    pub fn open(path: &Path) -> Result<Self, ReadError> {
        Self::open_by(path, Access::Read)
    }

    /// [`Dump::open`] for what must be seen at once and in parts, as in a window: arrays are mapped, which
    /// takes no time and no memory, but whoever cuts the file of one ends this process by a signal.
    ///
    /// # Errors
    /// As [`Dump::open`].
    pub fn open_mapped(path: &Path) -> Result<Self, ReadError> {
        Self::open_by(path, Access::Map)
    }

    fn open_by(path: &Path, access: Access) -> Result<Self, ReadError> {
        let path = &find(path)?;
        let dump = Self::open_alone(path, access)?;
        let source = find_source(path, &dump.manifest.header.source, access).map(Box::new);
        Ok(Self { source, ..dump })
    }

    /// Opens a dump without its source, so that recordings which name themselves or each other end here.
    fn open_alone(path: &Path, access: Access) -> Result<Self, ReadError> {
        let manifest_path = path.join(manifest::FILE_NAME);
        match fs::symlink_metadata(&manifest_path) {
            Ok(metadata) if metadata.is_file() => {}
            _ => return Err(ReadError::NotARecording { path: path.to_owned() }),
        }
        let is_partial = folder::dump_of_partial(path).is_some();
        let scan = scan(&manifest_path)?;
        match &scan.fault {
            // The recorder may be writing this record right now.
            Some(Fault::Torn { .. }) if is_partial => {}
            Some(fault) => return Err(ReadError::Damaged { path: manifest_path, fault: fault.clone() }),
            None => {}
        }
        let manifest = Manifest::of(scan).ok_or_else(|| ReadError::Empty { path: manifest_path.clone() })?;
        let state = match &manifest.end {
            Some(end) if end.outcome == Outcome::Complete => DumpState::Complete,
            Some(_) => DumpState::Recovered,
            None if is_partial => DumpState::Partial,
            None => return Err(ReadError::NoEnd { path: manifest_path }),
        };
        let places =
            manifest.arrays.iter().enumerate().map(|(at, array)| (array.place.clone(), at)).collect();
        Ok(Self { root: path.to_owned(), manifest, places, state, source: None, access })
    }

    /// The recording whose rays this one measured again, if it is a replay and its source lies in the
    /// same folder unchanged.
    pub fn source(&self) -> Option<&Dump> {
        self.source.as_deref()
    }

    /// SHA-256 of the manifest, which holds a checksum of every array: what a replay knows its source by.
    ///
    /// # Errors
    /// If the manifest cannot be read.
    pub fn manifest_sha256(&self) -> Result<[u8; 32], ReadError> {
        let path = self.root.join(manifest::FILE_NAME);
        let bytes = fs::read(&path).map_err(|cause| ReadError::Io { path, cause })?;
        Ok(Sha256::digest(&bytes).into())
    }

    /// Whether an array is kept, here or in the source.
    pub fn has(&self, place: &Place) -> bool {
        self.shape(place).is_some()
    }

    /// The lengths of an array's dimensions, slowest first; `None` if it is kept neither here nor in the source.
    pub fn shape(&self, place: &Place) -> Option<&[u64]> {
        let own = self.record(place).map(|record| record.shape.as_slice());
        own.or_else(|| self.source_of(place)?.shape(place))
    }

    /// The source, if its array at this place is this recording's too. What methods made is not, nor are
    /// length tables that are addressed in another way, also where a replay that was ended early lost its own.
    fn source_of(&self, place: &Place) -> Option<&Dump> {
        let addresses = |dump: &Dump| {
            let options = &dump.manifest.header.options;
            (options.table_bits, options.table_layout.clone())
        };
        self.source().filter(|source| match place {
            Place::Method(..) => false,
            Place::Queue(_, QueueArray::Lengths | QueueArray::FinalLengths) => {
                addresses(source) == addresses(self)
            }
            Place::Scene(_) | Place::Image | Place::Queue(..) => true,
        })
    }

    /// The folder.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// What the manifest says.
    pub fn manifest(&self) -> &Manifest {
        &self.manifest
    }

    /// How far the recording got.
    pub fn state(&self) -> DumpState {
        self.state
    }

    /// The record of an array, if the dump has it.
    pub fn record(&self, place: &Place) -> Option<&ArrayRecord> {
        self.places.get(place).map(|&at| &self.manifest.arrays[at])
    }

    /// [`Dump::array`], after all of it was read and its checksum found right.
    ///
    /// # Errors
    /// As [`Dump::array`], and if the checksum is another.
    pub fn checked_array<T: Element>(&self, place: &Place) -> Result<Loaded<T>, ReadError> {
        let array = self.array(place)?;
        let owner = if self.record(place).is_some() { Some(self) } else { self.source_of(place) };
        if let Some((owner, record)) = owner.and_then(|owner| Some((owner, owner.record(place)?))) {
            let found = crc32c::crc32c(bytemuck::cast_slice(&array));
            if found != record.crc32c {
                let path = owner.root.join(place.to_string());
                return Err(ReadError::Checksum { path, found, expected: record.crc32c });
            }
        }
        Ok(array)
    }

    /// Loads an array, that of the source if this is a replay without its own. `T` must be its element
    /// type; if `T` has columns, so must the array.
    ///
    /// # Errors
    /// If the dump does not have it, or its file is not what the manifest says.
    pub fn array<T: Element>(&self, place: &Place) -> Result<Loaded<T>, ReadError> {
        let Some(record) = self.record(place) else {
            return match self.source_of(place) {
                Some(source) => source.array(place),
                None => Err(self.missing(place)),
            };
        };
        let columns_fit = T::COLUMNS == 1 || record.shape.last() == Some(&T::COLUMNS);
        if record.dtype != T::DTYPE || !columns_fit {
            return Err(ReadError::WrongType {
                place: place.clone(),
                found: described(record.dtype, &record.shape),
                expected: format!("{} in columns of {}", T::DTYPE, T::COLUMNS),
            });
        }
        array_file::load(&self.root, record, self.access)
    }

    fn missing(&self, place: &Place) -> ReadError {
        let hint = match &self.manifest.header.source {
            Source::Replayed { name, .. } => {
                let why = match self.source {
                    Some(_) => "whose array is made in another way",
                    None => "which is not in the same folder, or is another recording by now",
                };
                format!("; it is a replay of {}, {why}", shown(name))
            }
            Source::Traced | Source::Imported { .. } => {
                let (word, kept) = (place.kept_with(), &self.manifest.header.options.keep);
                if kept.iter().any(|kept| kept == word) {
                    String::new()
                } else {
                    let all: Vec<&str> = kept.iter().map(String::as_str).chain([word]).collect();
                    format!("; it was recorded without {word}: `--keep {}`", all.join(","))
                }
            }
        };
        ReadError::NoSuchArray { dump: self.root.clone(), place: place.clone(), hint }
    }

    /// Loads the data of an array of this dump as bytes, without its header. The checksum is not
    /// computed here, since that would read all of it.
    ///
    /// # Errors
    /// If its file is not what the record says.
    pub fn bytes(&self, record: &ArrayRecord) -> Result<Loaded<u8>, ReadError> {
        array_file::load(&self.root, record, self.access)
    }
}

/// Opens the source of the replay in `path`. A replay of a replay refers to the first recording itself, so
/// this goes one level deep, and a link is not followed.
fn find_source(path: &Path, source: &Source, access: Access) -> Option<Dump> {
    let Source::Replayed { name, manifest_sha256 } = source else { return None };
    let is_plain = Path::new(name).file_name().is_some_and(|plain| plain == name.as_str());
    let folder = std::path::absolute(path).ok()?.parent()?.join(name);
    if !is_plain || !fs::symlink_metadata(&folder).ok()?.is_dir() {
        return None;
    }
    let dump = Dump::open_alone(&folder, access).ok()?;
    let is_first = !matches!(dump.manifest.header.source, Source::Replayed { .. });
    (is_first && dump.manifest_sha256().ok()? == *manifest_sha256).then_some(dump)
}

/// The path that was meant: a folder, or a helpful error.
fn find(path: &Path) -> Result<PathBuf, ReadError> {
    if path.is_dir() {
        return Ok(path.to_owned());
    }
    if folder::exists(path) {
        return Err(ReadError::NotARecording { path: path.to_owned() });
    }
    let dump = folder::dump_folder(path);
    let partial = dump.as_deref().map(folder::partial_of).filter(|partial| partial.is_dir());
    let hint = match (dump.filter(|dump| dump.is_dir()), partial) {
        (Some(dump), _) => format!("; there is {}", dump.display()),
        (None, Some(partial)) => format!(
            "; there is {}, which `inspector recover` makes a recording if its recorder has ended",
            partial.display()
        ),
        (None, None) => String::new(),
    };
    Err(ReadError::Missing { path: path.to_owned(), hint })
}
