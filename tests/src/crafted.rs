//! Recordings that somebody changed and whose checksums are right: what readers must not trust.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::fs;
use std::path::{Path, PathBuf};

use formats::manifest::scan::scan;
use formats::manifest::{ArrayRecord, FILE_NAME, Record, encode_frame, preamble};
use formats::npy::{self, Element};

use crate::sources::files_below;

/// A copy of the recording `from` as `NAME.raydump` beside it.
///
/// # Panics
/// If it cannot be made.
pub fn copy(from: &Path, name: &str) -> PathBuf {
    let to = from.with_file_name(format!("{name}.raydump"));
    for file in files_below(from, |_| true) {
        let (from, to) = (from.join(&file), to.join(&file));
        fs::create_dir_all(to.parent().unwrap()).unwrap();
        fs::copy(from, to).unwrap();
    }
    to
}

/// Writes the manifest anew from what `edit` makes of its records.
///
/// # Panics
/// If it cannot be read or written.
pub fn edit_manifest(recording: &Path, edit: impl FnOnce(&mut Vec<Record>)) {
    let path = recording.join(FILE_NAME);
    let frames = scan(&path).unwrap().frames;
    let mut records: Vec<Record> = frames.into_iter().map(|frame| frame.record).collect();
    edit(&mut records);
    let frames = records.iter().flat_map(|record| encode_frame(record).unwrap());
    fs::write(path, preamble().into_iter().chain(frames).collect::<Vec<u8>>()).unwrap();
}

/// Applies `edit` to every record of the manifest.
///
/// # Panics
/// If it cannot be read or written.
pub fn edit_records(recording: &Path, edit: impl FnMut(&mut Record)) {
    edit_manifest(recording, |records| records.iter_mut().for_each(edit));
}

/// Writes an array anew from what `edit` makes of its values, with as many rows as they fill, and its record.
///
/// # Panics
/// If there is no such array.
pub fn edit_array<T: Element>(recording: &Path, path: &str, edit: impl FnOnce(&mut Vec<T>)) {
    edit_records(recording, {
        let mut edit = Some(edit);
        move |record| {
            let Record::Array(array) = record else { return };
            if array.place.to_string() == path {
                rewrite(recording, array, edit.take().unwrap());
            }
        }
    });
}

fn rewrite<T: Element>(recording: &Path, array: &mut ArrayRecord, edit: impl FnOnce(&mut Vec<T>)) {
    let file = recording.join(array.place.to_string());
    let old = fs::read(&file).unwrap();
    let header = npy::header(array.dtype, &array.shape).len();
    let mut values: Vec<T> = bytemuck::pod_collect_to_vec(&old[header..]);
    edit(&mut values);
    let data: &[u8] = bytemuck::cast_slice(&values);
    let in_a_row = array.shape[1..].iter().product::<u64>() / T::COLUMNS;
    array.shape[0] = values.len() as u64 / in_a_row.max(1);
    (array.bytes, array.crc32c) = (data.len() as u64, crc32c::crc32c(data));
    fs::write(file, [&npy::header(array.dtype, &array.shape), data].concat()).unwrap();
}
