//! The file of one array: held against its record, then mapped, read, or run through for its checksum.

use std::fs::{self, File};
use std::io::{self, Read};
use std::marker::PhantomData;
use std::ops::Deref;
use std::path::{Path, PathBuf};

use memmap2::{Mmap, MmapMut};

use crate::manifest::{ArrayRecord, Place};
use crate::npy::{self, Dtype, Element};
use crate::read_error::ReadError;

/// Bytes that are read at a time for a checksum.
const BLOCK_BYTES: usize = 1 << 20;

/// How the data of an array gets into memory.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Access {
    /// Loaded, which takes no time and no memory; whoever cuts the file ends this process.
    Map,
    /// Copied: a file that is cut meanwhile is an error.
    Read,
}

/// The data of an array in memory, as values.
#[derive(Debug)]
pub struct Loaded<T> {
    memory: Memory,
    element: PhantomData<fn() -> T>,
}

/// A file, or memory that a file was copied into.
#[derive(Debug)]
struct Memory {
    map: Mmap,
    data_offset: usize,
}

impl<T: Element> Deref for Loaded<T> {
    type Target = [T];

    #[inline]
    fn deref(&self) -> &[T] {
        // Maps start at a page and data at a multiple of 64 bytes: the cast cannot fail.
        bytemuck::cast_slice(&self.memory.map[self.memory.data_offset..])
    }
}

/// The file of an array after its header, which is the one of its record.
struct Opened {
    file: File,
    path: PathBuf,
    header_bytes: usize,
}

impl Opened {
    fn io_error(self, cause: io::Error) -> ReadError {
        ReadError::Io { path: self.path, cause }
    }

    /// The file's length has changed since it was opened.
    fn length_error(self, found: u64, record: &ArrayRecord) -> ReadError {
        let expected = record.bytes.saturating_add(self.header_bytes as u64);
        ReadError::FileLength { path: self.path, found, expected, data: record.bytes }
    }

    /// The error of a read that failed: most often the file has become shorter.
    fn read_error(self, cause: io::Error, record: &ArrayRecord) -> ReadError {
        match self.file.metadata() {
            Ok(metadata) if cause.kind() == io::ErrorKind::UnexpectedEof => {
                self.length_error(metadata.len(), record)
            }
            _ => self.io_error(cause),
        }
    }
}

/// The data of an array in memory, whose bytes must be those of values of type `T`.
pub(crate) fn load<T>(root: &Path, record: &ArrayRecord, access: Access) -> Result<Loaded<T>, ReadError> {
    let opened = open(root, record)?;
    let memory = match access {
        Access::Map => map(opened, record)?,
        Access::Read => read(opened, record)?,
    };
    Ok(Loaded { memory, element: PhantomData })
}

fn map(opened: Opened, record: &ArrayRecord) -> Result<Memory, ReadError> {
    // SAFETY: the map is read-only, and the file's length was just compared with the record's. Dumps are
    // not changed once they have their name. That nobody else changes one while it is mapped is an assumption, which
    // nothing here can enforce: a file that is cut ends this process by a signal; one that is written to changes plain
    // numbers, valid whatever their bits, and what reads them checks each index that it reads.
    let map = match unsafe { Mmap::map(&opened.file) } {
        Ok(map) => map,
        Err(cause) => return Err(opened.io_error(cause)),
    };
    let data_offset = opened.header_bytes;
    if map.len().checked_sub(data_offset).map(|data| data as u64) != Some(record.bytes) {
        return Err(opened.length_error(map.len() as u64, record));
    }
    Ok(Memory { map, data_offset })
}

fn read(mut opened: Opened, record: &ArrayRecord) -> Result<Memory, ReadError> {
    // A file of holes can be as long as it likes.
    let map = usize::try_from(record.bytes).ok().and_then(|bytes| MmapMut::map_anon(bytes).ok());
    let Some(mut map) = map else {
        let problem = format!("there is no memory for its {} bytes", record.bytes);
        return Err(opened.io_error(io::Error::new(io::ErrorKind::OutOfMemory, problem)));
    };
    // Orders read it at random, and pages of 2 MiB spare them most misses of addresses. Where that is refused pages
    // are small ones.
    #[cfg(target_os = "linux")]
    let _is_given = map.advise(memmap2::Advice::HugePage).is_ok();
    if let Err(cause) = opened.file.read_exact(&mut map) {
        return Err(opened.read_error(cause, record));
    }
    match map.make_read_only() {
        Ok(map) => Ok(Memory { map, data_offset: 0 }),
        Err(cause) => Err(opened.io_error(cause)),
    }
}

/// CRC-32C of an array's data. Memory: a block.
pub(crate) fn checksum(root: &Path, record: &ArrayRecord) -> Result<u32, ReadError> {
    let mut opened = open(root, record)?;
    let mut left = record.bytes;
    let mut block = vec![0; left.min(BLOCK_BYTES as u64) as usize];
    let mut checksum = 0;
    while left > 0 {
        let part = &mut block[..left.min(BLOCK_BYTES as u64) as usize];
        if let Err(cause) = opened.file.read_exact(part) {
            return Err(opened.read_error(cause, record));
        }
        checksum = crc32c::crc32c_append(checksum, part);
        left -= part.len() as u64;
    }
    Ok(checksum)
}

/// Holds the file of an array against its record.
fn open(root: &Path, record: &ArrayRecord) -> Result<Opened, ReadError> {
    let path = plain_file(root, &record.place)?;
    let io_error = |cause| ReadError::Io { path: path.clone(), cause };
    let header = npy::header(record.dtype, &record.shape);
    let mut file = File::open(&path).map_err(io_error)?;
    let found = file.metadata().map_err(io_error)?.len();
    let expected = record.bytes.checked_add(header.len() as u64);
    if expected != Some(found) {
        let expected = expected.unwrap_or(u64::MAX);
        return Err(ReadError::FileLength { path, found, expected, data: record.bytes });
    }
    let mut start = vec![0; header.len()];
    file.read_exact(&mut start).map_err(io_error)?;
    if start != header {
        return Err(match npy::parse_header(&start) {
            Ok(found) => ReadError::Header {
                path,
                found: format!("{} in {} bytes", described(found.dtype, &found.shape), found.data_offset),
                expected: format!("{} in {} bytes", described(record.dtype, &record.shape), header.len()),
            },
            Err(cause) => ReadError::Npy { path, cause },
        });
    }
    Ok(Opened { file, path, header_bytes: header.len() })
}

/// An element type and a shape, for messages.
pub(crate) fn described(dtype: Dtype, shape: &[u64]) -> String {
    format!("{dtype} {shape:?}")
}

/// The path of an array, if all that leads to it from the root is plain folders and a plain file.
fn plain_file(root: &Path, place: &Place) -> Result<PathBuf, ReadError> {
    let mut path = root.to_owned();
    let relative = place.to_string();
    let mut parts = relative.split('/').peekable();
    while let Some(part) = parts.next() {
        path.push(part);
        let kind = match fs::symlink_metadata(&path) {
            Ok(metadata) => metadata.file_type(),
            Err(cause) => return Err(ReadError::Io { path, cause }),
        };
        let is_last = parts.peek().is_none();
        if !(if is_last { kind.is_file() } else { kind.is_dir() }) {
            let expected = if is_last { "file" } else { "folder" };
            let found = match (kind.is_symlink(), kind.is_dir(), kind.is_file()) {
                (true, ..) => "a link",
                (_, true, _) => "a folder",
                (_, _, true) => "a file",
                _ => "neither a file nor a folder",
            };
            return Err(ReadError::NotPlain { path, found, expected });
        }
    }
    Ok(path)
}
