//! Whole files: read only where they are plain, replaced only by what is complete.

use std::fs::{self, File};
use std::io::{self, BufWriter, Read, Write};
use std::path::Path;

use crate::folder;

/// Reads a plain file of at most `limit` bytes, or one that a link leads to. Pipes and devices are
/// refused before they are opened: they would make us wait, or never end.
///
/// # Errors
/// What the system says, or what was found in place of such a file.
pub fn read_plain(path: &Path, limit: u64) -> io::Result<Vec<u8>> {
    let metadata = fs::metadata(path)?;
    if !metadata.is_file() {
        let found = if metadata.is_dir() { "a folder" } else { "a pipe or device" };
        return Err(io::Error::new(
            io::ErrorKind::InvalidInput,
            format!("found {found}, expected a plain file"),
        ));
    }
    let mut bytes = Vec::new();
    File::open(path)?.take(limit.saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > limit {
        let found = metadata.len().max(bytes.len() as u64);
        return Err(io::Error::new(
            io::ErrorKind::FileTooLarge,
            format!("found {found} bytes, expected at most {limit}"),
        ));
    }
    Ok(bytes)
}

/// Refuses a place in a recording, whose files only its recorder writes.
///
/// # Errors
/// If it lies in one, by any links.
pub fn outside_recordings(path: &Path) -> io::Result<()> {
    let Some(recording) = folder::recording_around(path) else { return Ok(()) };
    let found = format!("it lies in the recording {}; choose a place outside", recording.display());
    Err(io::Error::new(io::ErrorKind::InvalidInput, found))
}

/// Writes a file beside its place and renames it when it is complete, so that a full disk or an early end
/// leaves what was there before. A link is followed; a pipe or device is written to as it is. Nothing is
/// written into a recording, whose files only its recorder writes.
///
/// # Errors
/// What the system or `write` says, and if the file would lie in a recording.
pub fn replace(path: &Path, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let target = match fs::metadata(path) {
        Ok(metadata) if !metadata.is_file() => {
            let mut file = fs::OpenOptions::new().write(true).open(path)?;
            return write(&mut file).and_then(|()| file.flush());
        }
        Ok(_) => fs::canonicalize(path)?,
        Err(_) => path.to_owned(),
    };
    outside_recordings(&target)?;
    let mut builder = tempfile::Builder::new();
    builder.prefix(".").suffix(".partial");
    // Like any new file, and not for the owner alone; the system takes away what the user's mask says.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let beside = builder.tempfile_in(folder::parent(&target))?;
    let mut buffer = BufWriter::new(beside);
    write(&mut buffer)?;
    let beside = buffer.into_inner().map_err(io::IntoInnerError::into_error)?;
    beside.persist(&target).map(drop).map_err(|error| error.error)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_plain_files_of_the_expected_size_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        fs::write(&file, b"12345").unwrap();
        assert_eq!(read_plain(&file, 5).unwrap(), b"12345");
        assert_eq!(read_plain(&file, 4).unwrap_err().kind(), io::ErrorKind::FileTooLarge);
        assert_eq!(read_plain(folder.path(), 5).unwrap_err().kind(), io::ErrorKind::InvalidInput);
        if cfg!(unix) {
            assert_eq!(
                read_plain(Path::new("/dev/zero"), 5).unwrap_err().kind(),
                io::ErrorKind::InvalidInput
            );
        }
    }

    #[test]
    fn a_file_that_cannot_be_completed_leaves_the_old_one() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        replace(&file, |to| to.write_all(b"old")).unwrap();
        let failed = replace(&file, |to| {
            to.write_all(b"half of the new")?;
            Err(io::ErrorKind::StorageFull.into())
        });
        assert_eq!(failed.unwrap_err().kind(), io::ErrorKind::StorageFull);
        assert_eq!(fs::read(&file).unwrap(), b"old");
        replace(&file, |to| to.write_all(b"new")).unwrap();
        assert_eq!(fs::read(&file).unwrap(), b"new");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "nothing is left beside it");
    }

    #[cfg(unix)]
    #[test]
    fn nothing_is_written_into_a_recording() {
        let folder = tempfile::tempdir().unwrap();
        let (inside, link) = (folder.path().join("a/scene"), folder.path().join("link"));
        fs::create_dir_all(&inside).unwrap();
        let manifest = folder.path().join("a/manifest.bin");
        fs::write(&manifest, crate::manifest::preamble()).unwrap();
        std::os::unix::fs::symlink(&manifest, &link).unwrap();
        for path in [&manifest, &link, &inside.join("new"), &folder.path().join("a/scene/../new")] {
            let refused = replace(path, |to| to.write_all(b"picture")).unwrap_err();
            assert!(refused.to_string().contains("recording"), "{}: {refused}", path.display());
        }
        assert_eq!(fs::read(&manifest).unwrap(), crate::manifest::preamble());
    }

    #[cfg(unix)]
    #[test]
    fn links_stay_links_and_files_are_for_everyone_whom_the_mask_lets() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let (file, link) = (folder.path().join("file"), folder.path().join("link"));
        fs::write(&file, b"old").unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        replace(&link, |to| to.write_all(b"new")).unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(&file).unwrap(), b"new");
        let plain = folder.path().join("plain");
        fs::write(&plain, b"").unwrap();
        let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode();
        assert_eq!(mode(&file), mode(&plain));
        replace(Path::new("/dev/null"), |to| to.write_all(b"gone")).unwrap();
        assert!(!fs::metadata("/dev/null").unwrap().is_file());
    }
}
