//! Streams one array to its file.

use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::PathBuf;
use std::sync::Arc;

use super::error::io_error;
use super::{DumpWriter, WriteError, create_file};
use crate::manifest::{ArrayRecord, Record};
use crate::npy;

/// Writes of at least this many bytes go straight to the file, smaller ones are collected.
const BUFFER_BYTES: usize = 1 << 20;
/// After this many bytes the disk gets to work on them.
const WRITE_BACK_BYTES: u64 = 64 << 20;

/// Streams the data of one array; ended by [`ArrayWriter::finish`].
///
/// Dropped without it, as after an error, the file is removed: what it holds is not complete, and
/// on a full disk the space is needed to recover what is.
#[derive(Debug)]
pub struct ArrayWriter<'a> {
    dump: &'a mut DumpWriter,
    path: PathBuf,
    record: ArrayRecord,
    /// `None` once the file is finished.
    output: Option<BufWriter<Arc<File>>>,
    written: u64,
    hinted: u64,
}

impl<'a> ArrayWriter<'a> {
    /// Creates the file with its header. `record.bytes` is the size of the data to come.
    pub(super) fn create(
        dump: &'a mut DumpWriter,
        path: PathBuf,
        record: ArrayRecord,
    ) -> Result<Self, WriteError> {
        let file = Arc::new(create_file(&path)?);
        let output = BufWriter::with_capacity(BUFFER_BYTES, file);
        let header = npy::header(record.dtype, &record.shape);
        let mut writer = Self { dump, path, record, output: Some(output), written: 0, hinted: 0 };
        writer.put(&header)?;
        Ok(writer)
    }

    /// Appends data, little-endian, in C order; any number of bytes at a time.
    ///
    /// # Errors
    /// If there are more bytes than the shape takes, or the file cannot be written.
    pub fn write(&mut self, bytes: &[u8]) -> Result<(), WriteError> {
        let written = self.written + bytes.len() as u64;
        if written > self.record.bytes {
            return Err(self.count_error(written));
        }
        self.record.crc32c = crc32c::crc32c_append(self.record.crc32c, bytes);
        self.put(bytes)?;
        self.written = written;
        if written - self.hinted >= WRITE_BACK_BYTES
            && let Some(output) = &self.output
        {
            self.hinted = written;
            self.dump.write_back.hint(output.get_ref(), &self.path);
        }
        Ok(())
    }

    /// Ends the array and appends its record to the manifest.
    ///
    /// # Errors
    /// If there are fewer bytes than the shape takes, or something cannot be written.
    pub fn finish(mut self) -> Result<(), WriteError> {
        if self.written != self.record.bytes {
            return Err(self.count_error(self.written));
        }
        if let Some(output) = &mut self.output {
            output.flush().map_err(io_error("write", &self.path))?;
        }
        self.dump.record(&Record::Array(self.record.clone()))?;
        if let Some(output) = self.output.take() {
            let (file, _) = output.into_parts();
            self.dump.write_back.finish_file(file, self.path.clone());
        }
        self.dump.written.insert(self.record.place.clone());
        Ok(())
    }

    fn put(&mut self, bytes: &[u8]) -> Result<(), WriteError> {
        match &mut self.output {
            Some(output) => output.write_all(bytes).map_err(io_error("write", &self.path)),
            None => Ok(()),
        }
    }

    fn count_error(&self, found: u64) -> WriteError {
        WriteError::Count { place: self.record.place.clone(), found, expected: self.record.bytes }
    }
}

impl Drop for ArrayWriter<'_> {
    fn drop(&mut self) {
        if let Some(output) = self.output.take() {
            // What is still in the buffer is not wanted any more.
            let _ = output.into_parts();
            let _ = fs::remove_file(&self.path);
        }
    }
}
