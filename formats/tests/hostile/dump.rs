//! A dump that somebody changed: a few rays of the sample after edits, through everything that reads dumps;
//! closest rays if the number of bytes is even, shadow rays if it is odd.
//!
//! Bytes become edits of [`EDIT_BYTES`] bytes and what they write: kind, which record or array (u16),
//! offset (u16), number of bytes (u8), those bytes.

#[path = "../sample/mod.rs"]
pub(crate) mod sample;

use std::cell::RefCell;
use std::fs;
use std::path::{Path, PathBuf};

use formats::manifest::scan::scan_bytes;
use formats::manifest::{ArrayRecord, Place, QueueArray, Record, encode_frame, preamble};
use formats::npy;
use formats::ray::{Kind, Ray};
use formats::reader::Dump;
use formats::recover::recover;
use formats::stored_table::StoredTable;
use formats::summary::Summary;
use formats::traced::Traced;
use formats::verify::verify;

use super::{assert_sentence, tiny};

/// Kind, which, offset, number of bytes.
const EDIT_BYTES: usize = 6;
/// What comes after so many edits is not looked at.
const EDITS_MAX: usize = 16;
/// Of so many pairs of lengths of input, one is recovered, too.
const RECOVERED_OF: usize = 12;
/// More address bits than that make a length table large.
const SMALL_TABLE_BITS: u32 = 12;

/// What is done to the dump.
#[derive(Debug)]
struct Edit<'a> {
    kind: u8,
    which: usize,
    offset: usize,
    bytes: &'a [u8],
}

fn edits(mut bytes: &[u8]) -> Vec<Edit<'_>> {
    let mut edits = Vec::new();
    while let Some((&[kind, w0, w1, o0, o1, length], rest)) = bytes.split_first_chunk::<EDIT_BYTES>()
        && edits.len() < EDITS_MAX
    {
        let (written, rest) = rest.split_at(rest.len().min(length.into()));
        let [which, offset] = [[w0, w1], [o0, o1]].map(|word| u16::from_le_bytes(word).into());
        edits.push(Edit { kind, which, offset, bytes: written });
        bytes = rest;
    }
    edits
}

/// A sample and its copy that is edited.
struct Files {
    /// Where both lie.
    folder: tempfile::TempDir,
    original: PathBuf,
    copy: PathBuf,
    /// Of the original's records.
    payloads: Vec<Vec<u8>>,
    arrays: Vec<ArrayRecord>,
    /// Arrays whose files in the copy are not those of the original.
    changed: Vec<usize>,
}

thread_local! {
    /// One queue each, since files cost most of the time: with both in one dump it takes twice as long.
    static FILES: RefCell<[Files; 2]> = RefCell::new(Kind::ALL.map(Files::new));
}

impl Files {
    fn new(kind: Kind) -> Self {
        // In memory, where the thousands of recordings that a fuzzer makes of it are synced at once.
        let folder = sample::folder_in_memory();
        let original = tiny::write(folder.path(), kind);
        assert!(use_everything(&original), "what is edited is right before");
        let payloads = sample::records(&original).iter().map(payload).collect();
        let arrays = Dump::open(&original).unwrap().manifest().arrays.clone();
        let (copy, changed) = (folder.path().join("edited.raydump"), (0..arrays.len()).collect());
        Self { folder, original, copy, payloads, arrays, changed }
    }

    /// Links what has changed to the bytes of the sample again.
    fn mend(&mut self) {
        for at in self.changed.drain(..) {
            let relative = self.arrays[at].place.to_string();
            let file = self.copy.join(&relative);
            fs::create_dir_all(file.parent().unwrap()).unwrap();
            // What is there may be a folder by now, or nothing.
            let _ = fs::remove_file(&file);
            let _ = fs::remove_dir(&file);
            fs::hard_link(self.original.join(&relative), file).unwrap();
        }
    }

    /// All of it is made again, since `recover` moves what it likes.
    fn begin_again(&mut self) {
        fs::remove_dir_all(&self.copy).unwrap();
        let leftover = self.copy.with_extension("raydump.leftover");
        if leftover.exists() {
            fs::remove_dir_all(leftover).unwrap();
        }
        self.changed = (0..self.arrays.len()).collect();
    }
}

/// What is edited in files at once, and in the manifest when that is written in the end.
struct Edited<'a> {
    files: &'a mut Files,
    payloads: Vec<Vec<u8>>,
    /// Written over the manifest's bytes, and where it is cut.
    manifest_edits: Vec<(usize, Vec<u8>)>,
    manifest_bytes: Option<usize>,
}

impl Edited<'_> {
    fn apply(&mut self, edit: &Edit<'_>) {
        let payloads = self.payloads.len();
        let at = edit.which % self.files.arrays.len();
        let array = &self.files.arrays[at].clone();
        if edit.kind % 12 > 6 {
            self.files.changed.push(at);
        }
        match edit.kind % 12 {
            0 | 1 if payloads > 0 => put(&mut self.payloads[edit.which % payloads], edit.offset, edit.bytes),
            2 => self.payloads.insert(edit.which % (payloads + 1), edit.bytes.to_vec()),
            3 if payloads > 0 => drop(self.payloads.remove(edit.which % payloads)),
            4 if payloads > 0 => self.payloads.swap(edit.which % payloads, edit.offset % payloads),
            5 => self.manifest_edits.push((edit.offset, edit.bytes.to_vec())),
            6 => self.manifest_bytes = Some(edit.offset),
            7 => drop(self.edit_file(array, edit, 0)),
            8 | 9 => {
                let header = npy::header(array.dtype, &array.shape).len();
                let data = self.edit_file(array, edit, header).split_off(header);
                self.mend_checksum(array, &data);
            }
            10 => {
                let mut bytes = self.read(array);
                bytes.truncate(edit.offset);
                self.replace(array, &bytes);
            }
            _ => self.replace_by_another_thing(array, edit.offset),
        }
    }

    fn file(&self, array: &ArrayRecord) -> PathBuf {
        self.files.copy.join(array.place.to_string())
    }

    fn read(&self, array: &ArrayRecord) -> Vec<u8> {
        fs::read(self.file(array)).unwrap_or_default()
    }

    fn replace(&self, array: &ArrayRecord, bytes: &[u8]) {
        let file = self.file(array);
        // The link first: writing through it would change the original.
        if fs::remove_file(&file).is_ok() {
            fs::write(&file, bytes).unwrap();
        }
    }

    /// Writes the edit's bytes into a file, `start` bytes further on; returns all of it.
    fn edit_file(&self, array: &ArrayRecord, edit: &Edit<'_>, start: usize) -> Vec<u8> {
        let mut bytes = self.read(array);
        bytes.resize(bytes.len().max(start), 0);
        let data = (bytes.len() - start).max(1);
        put(&mut bytes, start + edit.offset % data, edit.bytes);
        self.replace(array, &bytes);
        bytes
    }

    /// So that only the meaning of the data is wrong.
    fn mend_checksum(&mut self, array: &ArrayRecord, data: &[u8]) {
        let old = payload(&Record::Array(array.clone()));
        let edited = ArrayRecord { crc32c: crc32c::crc32c(data), ..array.clone() };
        let new = payload(&Record::Array(edited));
        // Everything but the last twelve bytes, checksum and length, says which array it is.
        let kept = old.len() - 12;
        let record = self.payloads.iter_mut().find(|payload| payload.starts_with(&old[..kept]));
        if let Some(record) = record {
            *record = new;
        }
    }

    fn replace_by_another_thing(&self, array: &ArrayRecord, choice: usize) {
        let file = self.file(array);
        if fs::remove_file(&file).is_err() {
            return;
        }
        match choice % 3 {
            0 => fs::create_dir(&file).unwrap(),
            #[cfg(unix)]
            1 => std::os::unix::fs::symlink(self.files.folder.path(), &file).unwrap(),
            _ => {}
        }
    }

    fn has_large_tables(&self) -> bool {
        let bytes = manifest(self.payloads.iter().take(1));
        let first = scan_bytes(&bytes[..], bytes.len() as u64, &self.files.copy).ok();
        match first.and_then(|scan| scan.frames.into_iter().next()).map(|frame| frame.record) {
            Some(Record::Header(header)) => header.options.table_bits > SMALL_TABLE_BITS,
            _ => false,
        }
    }

    fn write_manifest(&self) {
        let mut bytes = manifest(&self.payloads);
        for (offset, edit) in &self.manifest_edits {
            put(&mut bytes, *offset, edit);
        }
        bytes.truncate(self.manifest_bytes.unwrap_or(bytes.len()));
        fs::write(self.files.copy.join("manifest.bin"), bytes).unwrap();
    }
}

/// A record's bytes after their length and checksum.
fn payload(record: &Record) -> Vec<u8> {
    encode_frame(record).unwrap().split_off(8)
}

/// The manifest of these records' bytes.
fn manifest<'a>(payloads: impl IntoIterator<Item = &'a Vec<u8>>) -> Vec<u8> {
    let mut bytes = preamble().to_vec();
    for payload in payloads {
        bytes.extend((payload.len() as u32).to_le_bytes());
        bytes.extend(crc32c::crc32c(payload).to_le_bytes());
        bytes.extend(payload);
    }
    bytes
}

/// Overwrites what is there, as far as it reaches.
fn put(bytes: &mut [u8], offset: usize, new: &[u8]) {
    let places = bytes.iter_mut().skip(offset).zip(new);
    places.for_each(|(byte, &new)| *byte = new);
}

/// The sample after these edits.
pub(crate) fn dump(bytes: &[u8]) {
    FILES.with_borrow_mut(|files| {
        let files = &mut files[bytes.len() % 2];
        files.mend();
        let (payloads, manifest_edits) = (files.payloads.clone(), Vec::new());
        let mut edited = Edited { files, payloads, manifest_edits, manifest_bytes: None };
        let edits = edits(bytes);
        edits.iter().for_each(|edit| edited.apply(edit));
        // A large table takes as long as a hundred dumps: tried by itself alone.
        if edits.len() > 1 && edited.has_large_tables() {
            return;
        }
        edited.write_manifest();
        use_everything(&files.copy);
        // Making all files again takes longer than everything else.
        if (bytes.len() / 2).is_multiple_of(RECOVERED_OF) {
            recover_and_verify(&files.copy);
            files.begin_again();
        }
    });
}

fn recover_and_verify(path: &Path) {
    match recover(path) {
        Ok(recovery) => {
            recovery.left_out.iter().for_each(|damage| assert_sentence(damage));
            // Whatever was recovered is a dump whose files are whole.
            let report = verify(&Dump::open(path).unwrap());
            let files = report.checks.iter().find(|check| check.name == "files").unwrap();
            assert_eq!(files.problems.count, 0, "{files:?}");
        }
        Err(error) => assert_sentence(&error.to_string()),
    }
}

/// Opens a dump, maps its arrays, reads its tables and lengths and verifies it; whether nothing is wrong.
pub(crate) fn use_everything(path: &Path) -> bool {
    let dump = match Dump::open(path) {
        Ok(dump) => dump,
        Err(error) => {
            assert_sentence(&error.to_string());
            return false;
        }
    };
    serde_json::to_string(&Summary::new(path, dump.manifest())).unwrap();
    for array in &dump.manifest().arrays {
        match dump.bytes(array) {
            Ok(bytes) => assert_eq!(bytes.len() as u64, array.bytes),
            Err(error) => assert_sentence(&error.to_string()),
        }
        if let Place::Queue(queue, QueueArray::Rays) = array.place {
            match Traced::open(&dump, queue) {
                Ok(traced) => (0..traced.rays().len()).for_each(|ray| _ = traced.length(ray)),
                Err(error) => assert_sentence(&error.to_string()),
            }
            match (StoredTable::open(&dump, queue), dump.array::<Ray>(&array.place)) {
                (Ok(table), Ok(rays)) => rays.iter().for_each(|ray| _ = table.mean(ray)),
                (Err(error), _) => assert_sentence(&error.to_string()),
                (_, Err(_)) => {}
            }
        }
    }
    let report = verify(&dump);
    for check in &report.checks {
        let findings = check.problems.first.iter().chain(&check.differences.first);
        findings.chain(&check.not_checked).for_each(|finding| assert_sentence(finding));
    }
    report.is_ok()
}
