//! The files of a scene: the one way in which any of them is opened.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;

use crate::memory;

/// Opens a plain file, or one that a link leads to, and gives its length in bytes. Pipes and devices are
/// refused before they are opened: they would make us wait, or never end.
///
/// # Errors
/// What the system says, or what was found in place of such a file.
pub(crate) fn open(path: &Path) -> io::Result<(File, u64)> {
    let metadata = fs::metadata(path)?;
    if !metadata.is_file() {
        let found = if metadata.is_dir() { "a folder" } else { "a pipe or device" };
        let message = format!("found {found}, expected a plain file");
        return Err(io::Error::new(io::ErrorKind::InvalidInput, message));
    }
    Ok((File::open(path)?, metadata.len()))
}

/// Reads up to `limit` bytes of such a file; what follows them is left.
///
/// # Errors
/// As [`open`], or that there is not enough memory.
pub(crate) fn read_start(path: &Path, limit: u64) -> io::Result<Vec<u8>> {
    let (file, length) = open(path)?;
    let expected = length.min(limit);
    memory::check(expected, memory::free())
        .map_err(|shortage| io::Error::new(io::ErrorKind::OutOfMemory, shortage))?;
    let mut bytes = Vec::with_capacity(usize::try_from(expected).unwrap_or_default());
    file.take(limit).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// Reads the whole of such a file, which must not be longer than `limit` bytes.
///
/// # Errors
/// As [`read_start`], or that the file is too long.
pub(crate) fn read(path: &Path, limit: u64) -> io::Result<Vec<u8>> {
    let bytes = read_start(path, limit.saturating_add(1))?;
    if bytes.len() as u64 > limit {
        let message = format!("found more than {limit} bytes, expected at most that many");
        return Err(io::Error::new(io::ErrorKind::FileTooLarge, message));
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_plain_files_of_the_expected_size_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        fs::write(&file, b"12345").unwrap();
        assert_eq!(read(&file, 5).unwrap(), b"12345");
        assert_eq!(read(&file, 4).unwrap_err().kind(), io::ErrorKind::FileTooLarge);
        assert_eq!(read_start(&file, 4).unwrap(), b"1234");
        assert_eq!(read(folder.path(), 5).unwrap_err().kind(), io::ErrorKind::InvalidInput);
        if cfg!(unix) {
            let message = read(Path::new("/dev/zero"), 5).unwrap_err().to_string();
            assert_eq!(message, "found a pipe or device, expected a plain file");
        }
    }
}
