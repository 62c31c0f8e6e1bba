//! A manifest file as records, up to the first fault.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::{Path, PathBuf};

use super::check::REPEATS_MAX;
use super::codec;
use super::{
    ArrayRecord, CacheRecord, CalibrationRecord, DecisionRecord, DisturbedRecord, End, FORMAT_VERSION,
    FRAME_BYTES, Header, MAGIC, MethodRecord, OLDEST_VERSION, PREAMBLE_BYTES, Place, QueueRecord,
    RECORD_BYTES_MAX, Record, Source, Stage, TimingRecord, WayRecord,
};
use crate::key::method::{BUILTIN, is_method_name};
use crate::npy;
use crate::text::{one_line, shown};

/// Why a manifest cannot be read at all.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "each message says what it and its fields mean")]
pub enum ManifestError {
    /// The file cannot be opened or read.
    #[error("{}: {cause}", path.display())]
    Io { path: PathBuf, cause: io::Error },
    #[error("{}: found a file that does not start with RAYDUMP; expected the manifest of a recording", path.display())]
    Magic { path: PathBuf },
    #[error("{}: found format version {found}, this program reads versions {OLDEST_VERSION} to {FORMAT_VERSION}; use the program that recorded it", path.display())]
    Version { path: PathBuf, found: u32 },
    #[error("{}: the reserved bytes at offset 12 are {found:#010x}, expected 0: the file is damaged", path.display())]
    Reserved { path: PathBuf, found: u32 },
    /// A record of a kind that this version does not know, although its checksum is right.
    #[error("{}: the record at offset {offset} is of kind {kind}, which format version {FORMAT_VERSION} does not have; use a newer program", path.display())]
    UnknownRecord { path: PathBuf, offset: u64, kind: u32 },
}

/// Where the records of a manifest stop making sense, and why.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[expect(missing_docs, reason = "each message says what it and its fields mean")]
pub enum Fault {
    /// The file ends within a record, as when the recorder is killed while it writes one. Bytes include the
    /// record's length and checksum.
    #[error("the record at offset {offset} should have {expected} bytes, but the file ends after {found}")]
    Torn { offset: u64, found: u64, expected: u64 },
    /// A record that is whole, but damaged or out of place.
    #[error("the record at offset {offset} is damaged: {problem}")]
    Damaged { offset: u64, problem: String },
}

/// The readable records of a manifest, by kind.
#[derive(Clone, Debug, PartialEq)]
pub struct Manifest {
    /// Version of the format.
    pub version: u32,
    /// What is recorded and how.
    pub header: Header,
    /// The methods.
    pub methods: Vec<MethodRecord>,
    /// The arrays, in the order in which they were finished.
    pub arrays: Vec<ArrayRecord>,
    /// The queues, in the order in which they were finished.
    pub queues: Vec<QueueRecord>,
    /// The timings.
    pub timings: Vec<TimingRecord>,
    /// What the cache model says of each order.
    pub caches: Vec<CacheRecord>,
    /// Which samples of the timings were disturbed.
    pub disturbed: Vec<DisturbedRecord>,
    /// How each method's rays are traced in its totals; none in recordings that do not say.
    pub ways: Vec<WayRecord>,
    /// What orders were worth before the recording, queue by queue.
    pub calibration: Vec<CalibrationRecord>,
    /// Which order `auto` gave each queue.
    pub decisions: Vec<DecisionRecord>,
    /// How the recording ended; `None` if it did not.
    pub end: Option<End>,
}

impl Manifest {
    /// The orders of another tracer, which came with imported rays: nobody here knows what their keys and their sort
    /// cost, so they have no times of either.
    pub fn foreign_orders(&self) -> impl Iterator<Item = &MethodRecord> {
        let may_have = self.header.source != Source::Traced;
        let timings = self.timings.iter().filter(move |_| may_have);
        let is_key = |timing: &&TimingRecord| timing.stage == Stage::Key;
        let keyed: BTreeSet<&str> =
            timings.clone().filter(is_key).map(|timing| timing.method.as_str()).collect();
        let kept = self.arrays.iter().filter(move |_| may_have).filter_map(|array| match &array.place {
            Place::Method(_, method, _) => Some(method.as_str()),
            _ => None,
        });
        let there: BTreeSet<&str> = timings.map(|timing| timing.method.as_str()).chain(kept).collect();
        self.methods.iter().filter(move |record| {
            let name = record.name.as_str();
            there.contains(name) && !keyed.contains(name) && !BUILTIN.iter().any(|(ours, ..)| *ours == name)
        })
    }
}

/// A record and where it lies in the manifest.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Where it starts, bytes from the start of the file.
    pub offset: u64,
    /// Where the next one starts.
    pub end: u64,
    /// The record.
    pub record: Record,
}

/// What a manifest file holds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scan {
    /// Version of the format; 0 of a file that ends before it says so.
    pub version: u32,
    /// The records that can be read, in order.
    pub frames: Vec<Frame>,
    /// What is wrong with each record that was passed over, since whole ones follow it: [`salvage`] does so.
    pub passed_over: Vec<Fault>,
    /// Why nothing more can be read, unless the file simply ends.
    pub fault: Option<Fault>,
}

/// Reads the records of the manifest at `path`.
///
/// # Errors
/// If the file cannot be read, or is not a manifest of this version.
pub fn scan(path: &Path) -> Result<Scan, ManifestError> {
    let (reader, bytes) = open(path)?;
    scan_bytes(reader, bytes, path)
}

/// Reads the records of a manifest of `bytes` bytes; `path` is what errors call it. Memory: the
/// records, none of which takes more than [`RECORD_BYTES_MAX`] bytes of the file.
///
/// # Errors
/// If it cannot be read, or is not a manifest of this version.
pub fn scan_bytes(reader: impl Read, bytes: u64, path: &Path) -> Result<Scan, ManifestError> {
    let mut records = Records::new(reader, bytes, path);
    let mut scan = Scan::default();
    loop {
        let next = records.next()?;
        scan.version = records.version;
        match next {
            Next::Record(frame) => scan.frames.push(frame),
            Next::Damaged(fault) | Next::Broken(fault) => return Ok(Scan { fault: Some(fault), ..scan }),
            Next::End => return Ok(scan),
        }
    }
}

/// Reads what can be read of the manifest at `path`: a damaged record is passed over if its length leads
/// to a whole one, which no false length does.
///
/// # Errors
/// As [`scan`].
pub fn salvage(path: &Path) -> Result<Scan, ManifestError> {
    let (reader, bytes) = open(path)?;
    let mut records = Records::new(reader, bytes, path);
    let mut salvage = Scan::default();
    loop {
        let next = records.next()?;
        salvage.version = records.version;
        // Without its header no record has a meaning, and the end record has none after it.
        let may_go_on = !salvage.frames.is_empty() && !records.sequence.has_ended;
        match next {
            Next::Record(frame) => {
                salvage.passed_over.extend(salvage.fault.take());
                salvage.frames.push(frame);
            }
            Next::Damaged(fault) if salvage.fault.is_none() && may_go_on => salvage.fault = Some(fault),
            Next::Damaged(fault) | Next::Broken(fault) => {
                salvage.fault.get_or_insert(fault);
                return Ok(salvage);
            }
            Next::End => return Ok(salvage),
        }
    }
}

fn open(path: &Path) -> Result<(BufReader<File>, u64), ManifestError> {
    let io_error = |cause| ManifestError::Io { path: path.to_owned(), cause };
    let file = File::open(path).map_err(io_error)?;
    let bytes = file.metadata().map_err(io_error)?.len();
    Ok((BufReader::with_capacity(1 << 18, file), bytes))
}

/// Reads one record after the other.
struct Records<'a, R> {
    reader: R,
    /// Bytes of the manifest.
    bytes: u64,
    /// Where the next record starts; 0 before the preamble.
    offset: u64,
    sequence: Sequence,
    version: u32,
    path: &'a Path,
}

/// What comes next in a manifest.
enum Next {
    Record(Frame),
    /// A record that is damaged or out of place; if its length is right, the next one follows it.
    Damaged(Fault),
    /// What has no length that can be believed.
    Broken(Fault),
    End,
}

impl<'a, R: Read> Records<'a, R> {
    fn new(reader: R, bytes: u64, path: &'a Path) -> Self {
        Self { reader, bytes, offset: 0, sequence: Sequence::default(), version: 0, path }
    }

    fn next(&mut self) -> Result<Next, ManifestError> {
        if self.offset == 0 {
            if self.bytes < PREAMBLE_BYTES as u64 {
                let expected = PREAMBLE_BYTES as u64;
                return Ok(Next::Broken(Fault::Torn { offset: 0, found: self.bytes, expected }));
            }
            let mut preamble = [0; PREAMBLE_BYTES];
            self.reader.read_exact(&mut preamble).map_err(|cause| self.io_error(cause))?;
            self.version = check_preamble(self.path, &preamble)?;
            self.offset = PREAMBLE_BYTES as u64;
        }
        if self.offset >= self.bytes {
            return Ok(Next::End);
        }
        let offset = self.offset;
        let read = read_payload(&mut self.reader, offset, self.bytes - offset);
        let (payload, has_right_checksum) = match read.map_err(|cause| self.io_error(cause))? {
            Ok(read) => read,
            Err(fault) => return Ok(Next::Broken(fault)),
        };
        self.offset += (FRAME_BYTES + payload.len()) as u64;
        if let Err(problem) = has_right_checksum {
            return Ok(Next::Damaged(Fault::Damaged { offset, problem }));
        }
        if let Some(kind) = payload.first_chunk().map(|kind| u32::from_le_bytes(*kind))
            && kind >= codec::record_kinds(self.version)
        {
            return Err(ManifestError::UnknownRecord { path: self.path.to_owned(), offset, kind });
        }
        let record = codec::decode(&payload).and_then(|record| self.sequence.check(&record).map(|()| record));
        Ok(match record {
            Ok(record) => Next::Record(Frame { offset, end: self.offset, record }),
            Err(problem) => Next::Damaged(Fault::Damaged { offset, problem }),
        })
    }

    fn io_error(&self, cause: io::Error) -> ManifestError {
        ManifestError::Io { path: self.path.to_owned(), cause }
    }
}

/// The version.
fn check_preamble(path: &Path, preamble: &[u8; PREAMBLE_BYTES]) -> Result<u32, ManifestError> {
    let path = path.to_owned();
    let [.., v0, v1, v2, v3, r0, r1, r2, r3] = *preamble;
    if !preamble.starts_with(&MAGIC) {
        return Err(ManifestError::Magic { path });
    }
    match (u32::from_le_bytes([v0, v1, v2, v3]), u32::from_le_bytes([r0, r1, r2, r3])) {
        (version @ OLDEST_VERSION..=FORMAT_VERSION, 0) => Ok(version),
        (OLDEST_VERSION..=FORMAT_VERSION, found) => Err(ManifestError::Reserved { path, found }),
        (found, _) => Err(ManifestError::Version { path, found }),
    }
}

/// A record's bytes, and what is wrong with its checksum, if anything.
type Payload = (Vec<u8>, Result<(), String>);

/// The bytes of the record at `offset`, of which the file has `left`; the outer error is the system's.
fn read_payload(reader: &mut impl Read, offset: u64, left: u64) -> io::Result<Result<Payload, Fault>> {
    let torn = |expected| Ok(Err(Fault::Torn { offset, found: left, expected }));
    if left < FRAME_BYTES as u64 {
        return torn(FRAME_BYTES as u64);
    }
    let mut frame = [0; FRAME_BYTES];
    reader.read_exact(&mut frame)?;
    let [l0, l1, l2, l3, c0, c1, c2, c3] = frame;
    let length = u32::from_le_bytes([l0, l1, l2, l3]);
    let checksum = u32::from_le_bytes([c0, c1, c2, c3]);
    if length as usize > RECORD_BYTES_MAX {
        let problem = format!("it says it is {length} bytes long, expected at most {RECORD_BYTES_MAX}");
        return Ok(Err(Fault::Damaged { offset, problem }));
    }
    let expected = FRAME_BYTES as u64 + u64::from(length);
    if left < expected {
        return torn(expected);
    }
    let mut payload = vec![0; length as usize];
    reader.read_exact(&mut payload)?;
    let found = crc32c::crc32c(&payload);
    let is_right = if found == checksum {
        Ok(())
    } else {
        Err(format!("its checksum is {found:08x}, expected {checksum:08x}"))
    };
    Ok(Ok((payload, is_right)))
}

/// The rules about records that follow one another.
#[derive(Default)]
struct Sequence {
    has_header: bool,
    has_ended: bool,
    names: BTreeSet<String>,
}

impl Sequence {
    fn check(&mut self, record: &Record) -> Result<(), String> {
        if self.has_ended {
            return Err("it follows the end record".into());
        }
        if matches!(record, Record::Header(_)) == self.has_header {
            let expected =
                if self.has_header { "a second header" } else { "not the header, which comes first" };
            return Err(format!("it is {expected}"));
        }
        self.has_header = true;
        let name = match record {
            Record::Array(array) => {
                check_array(array)?;
                format!("array {}", array.place)
            }
            Record::Method(method) => {
                check_names([&method.name, &method.base])?;
                format!("method {}", method.name)
            }
            Record::Queue(queue) => {
                check_names(&queue.methods)?;
                check_distinct(&queue.methods)?;
                check_distinct(queue.mismatches.iter().map(|mismatches| &mismatches.method))?;
                format!("queue {}", queue.id)
            }
            Record::End(_) => {
                self.has_ended = true;
                return Ok(());
            }
            Record::Cache(CacheRecord { queue, method, .. }) => format!("caches of {method} in {queue}"),
            Record::Disturbed(DisturbedRecord { queue, method, stage, samples }) => {
                if !samples.is_sorted_by(|a, b| a < b) {
                    return Err("its samples do not ascend".into());
                }
                format!("disturbed times of {} by {method} in {queue}", stage.name())
            }
            Record::Way(WayRecord { method, .. }) => format!("the way of {method}"),
            Record::Calibration(CalibrationRecord { bounce, kind, candidates, .. }) => {
                check_names(candidates.iter().map(|candidate| &candidate.choice.method))?;
                format!("the calibration of bounce {bounce}, {kind} rays,")
            }
            Record::Decision(DecisionRecord { queue, choice, .. }) => {
                check_names(choice.iter().map(|choice| &choice.method))?;
                format!("the order of {queue}")
            }
            Record::Timing(timing) if timing.samples_ns.len() > REPEATS_MAX as usize => {
                let found = timing.samples_ns.len();
                return Err(format!("it has {found} samples of a time, expected at most {REPEATS_MAX}"));
            }
            Record::Timing(TimingRecord { pass, bounce, kind, method, stage, .. }) => {
                let kind = kind.map_or_else(String::new, |kind| format!(", {kind} rays"));
                format!("times of {} by {method} in pass {pass}, bounce {bounce}{kind},", stage.name())
            }
            Record::Header(_) => return Ok(()),
        };
        if self.names.contains(&name) {
            return Err(format!("it describes {} a second time", one_line(&name, 200)));
        }
        self.names.insert(name);
        Ok(())
    }
}

/// That each name can be a method's.
fn check_names<'a>(names: impl IntoIterator<Item = &'a String>) -> Result<(), String> {
    match names.into_iter().find(|name| !is_method_name(name)) {
        Some(name) => {
            Err(format!("'{}' is not the name of a method: small letters, digits and dashes", shown(name)))
        }
        None => Ok(()),
    }
}

fn check_distinct<'a>(names: impl IntoIterator<Item = &'a String>) -> Result<(), String> {
    let mut known = BTreeSet::new();
    match names.into_iter().find(|name| !known.insert(*name)) {
        Some(name) => Err(format!("it names {} twice", shown(name))),
        None => Ok(()),
    }
}

fn check_array(array: &ArrayRecord) -> Result<(), String> {
    let ArrayRecord { place, dtype, shape, bytes, .. } = array;
    if !place.allows(*dtype, shape) {
        return Err(format!("{place} is {dtype} {shape:?}, expected {}", place.expectation()));
    }
    match npy::data_bytes(*dtype, shape) {
        Some(expected) if expected == *bytes => Ok(()),
        expected => Err(format!(
            "{place} is said to have {bytes} bytes of data, but {dtype} {shape:?} takes {}",
            expected.map_or("more than there can be".to_owned(), |bytes| bytes.to_string())
        )),
    }
}

impl Manifest {
    /// The records sorted by kind; `None` if not even the header is among them.
    pub fn of(scan: Scan) -> Option<Self> {
        let mut frames = scan.frames.into_iter();
        let Some(Record::Header(header)) = frames.next().map(|frame| frame.record) else { return None };
        let mut manifest = Self {
            version: scan.version,
            header: *header,
            methods: Vec::new(),
            arrays: Vec::new(),
            queues: Vec::new(),
            timings: Vec::new(),
            caches: Vec::new(),
            disturbed: Vec::new(),
            ways: Vec::new(),
            calibration: Vec::new(),
            decisions: Vec::new(),
            end: None,
        };
        for frame in frames {
            match frame.record {
                Record::Header(_) => return None,
                Record::Method(method) => manifest.methods.push(method),
                Record::Array(array) => manifest.arrays.push(array),
                Record::Queue(queue) => manifest.queues.push(queue),
                Record::Timing(timing) => manifest.timings.push(timing),
                Record::Cache(cache) => manifest.caches.push(cache),
                Record::Disturbed(disturbed) => manifest.disturbed.push(disturbed),
                Record::Way(way) => manifest.ways.push(way),
                Record::Calibration(calibration) => manifest.calibration.push(calibration),
                Record::Decision(decision) => manifest.decisions.push(decision),
                Record::End(end) => manifest.end = Some(end),
            }
        }
        Some(manifest)
    }
}
