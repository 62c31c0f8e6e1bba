//! The sample with other records, or with fewer.

use std::fs;
use std::path::{Path, PathBuf};

use formats::manifest::scan::{Frame, scan};
use formats::manifest::{
    End, FILE_NAME, Header, Outcome, PREAMBLE_BYTES, Place, QueueId, Record, Source, TimingRecord,
    encode_frame, preamble, preamble_of,
};
use formats::reader::Dump;
use formats::writer::DumpWriter;

use super::header;

/// The records of a dump, and where they lie in its manifest.
pub(crate) fn frames(dump: &Path) -> Vec<Frame> {
    scan(&dump.join(FILE_NAME)).unwrap().frames
}

/// The records alone.
pub(crate) fn records(dump: &Path) -> Vec<Record> {
    frames(dump).into_iter().map(|frame| frame.record).collect()
}

/// Writes the manifest anew from what `edit` makes of its records.
pub(crate) fn edit_manifest(dump: &Path, edit: impl FnOnce(&mut Vec<Record>)) {
    let mut records = records(dump);
    edit(&mut records);
    write_manifest(dump, &records);
}

/// Applies `edit` to every record of the manifest.
pub(crate) fn edit_records(dump: &Path, edit: impl FnMut(&mut Record)) {
    edit_manifest(dump, |records| records.iter_mut().for_each(edit));
}

/// Applies `edit` to each such part of the manifest.
pub(crate) fn edit_parts<T>(
    dump: &Path,
    part_of: fn(&mut Record) -> Option<&mut T>,
    mut edit: impl FnMut(&mut T),
) {
    edit_records(dump, |record| part_of(record).into_iter().for_each(&mut edit));
}

/// What a record holds, if it is of that kind.
pub(crate) mod part {
    use formats::manifest::{
        CacheRecord, CalibrationRecord, DecisionRecord, DisturbedRecord, Header, MethodRecord, QueueRecord,
        Record, TimingRecord, WayRecord,
    };

    macro_rules! parts {
        ($($name:ident: $kind:ident($part:ty),)*) => {$(
            pub(crate) fn $name(record: &mut Record) -> Option<&mut $part> {
                if let Record::$kind(part) = record { Some(part) } else { None }
            }
        )*};
    }

    parts! {
        cache: Cache(CacheRecord),
        calibration: Calibration(CalibrationRecord),
        decision: Decision(DecisionRecord),
        disturbed: Disturbed(DisturbedRecord),
        header: Header(Header),
        method: Method(MethodRecord),
        queue: Queue(QueueRecord),
        timing: Timing(TimingRecord),
        way: Way(WayRecord),
    }
}

/// Makes the folder at `at` a replay without orders of the recording of this name and content.
pub(crate) fn empty_replay(at: &Path, name: &str, manifest_sha256: [u8; 32]) {
    let mut header = Header { source: Source::Replayed { name: name.into(), manifest_sha256 }, ..header() };
    header.options.methods.truncate(1);
    let end = End { outcome: Outcome::Complete, image: None, wall_ns: 1 };
    write_manifest(at, &[Record::Header(Box::new(header)), Record::End(end)]);
}

/// Writes a manifest of these records.
pub(crate) fn write_manifest(dump: &Path, records: &[Record]) {
    let frames = records.iter().flat_map(|record| encode_frame(record).unwrap());
    fs::write(dump.join(FILE_NAME), preamble().into_iter().chain(frames).collect::<Vec<u8>>()).unwrap();
}

/// Makes the manifest one of another version, whose records are the same.
pub(crate) fn set_version(dump: &Path, version: u32) {
    let manifest = dump.join(FILE_NAME);
    let mut bytes = fs::read(&manifest).unwrap();
    bytes[..PREAMBLE_BYTES].copy_from_slice(&preamble_of(version));
    fs::write(&manifest, bytes).unwrap();
}

/// Beside the dump `whole`, a right dump with these of its queues and methods alone, and no picture.
pub(crate) fn thinned(whole: &Path, name: &str, queues: &[QueueId], methods: &[&str]) -> PathBuf {
    let is_kept = |place: &Place| match place {
        Place::Scene(_) => true,
        Place::Image => false,
        Place::Queue(queue, _) => queues.contains(queue),
        Place::Method(queue, method, _) => queues.contains(queue) && methods.contains(&method.as_str()),
    };
    let source = Dump::open(whole).unwrap();
    let mut header = header();
    header.options.methods.retain(|method| method == "unsorted" || methods.contains(&method.as_str()));
    header.options.keep.retain(|word| word != "image" && word != "caches");
    if !queues.iter().any(|queue| queue.pass == 0) {
        header.options.keep_passes = "measured".to_owned();
    }
    let mut writer = DumpWriter::create(&whole.with_file_name(name), header, false).unwrap();
    for record in records(whole) {
        match record {
            Record::Method(method) if methods.contains(&method.name.as_str()) => {
                writer.record(&Record::Method(method)).unwrap();
            }
            Record::Array(array) if is_kept(&array.place) => {
                let mut file = writer.array(&array.place, array.dtype, &array.shape).unwrap();
                file.write(&source.bytes(&array).unwrap()).unwrap();
                file.finish().unwrap();
            }
            Record::Queue(mut queue) if queues.contains(&queue.id) => {
                queue.methods.retain(|method| method == "unsorted" || methods.contains(&method.as_str()));
                queue.mismatches.retain(|mismatches| methods.contains(&mismatches.method.as_str()));
                writer.record(&Record::Queue(queue)).unwrap();
            }
            Record::Timing(timing) if timing.kind.is_some() => {
                let TimingRecord { pass, bounce, ref method, .. } = timing;
                let of = |queue: &QueueId| {
                    (queue.pass, queue.bounce, Some(queue.kind)) == (pass, bounce, timing.kind)
                };
                let is_kept = method == "unsorted" || methods.contains(&method.as_str());
                if is_kept && queues.iter().any(of) {
                    writer.record(&Record::Timing(timing)).unwrap();
                }
            }
            _ => {}
        }
    }
    writer.finish(End { outcome: Outcome::Complete, image: None, wall_ns: 1 }).unwrap()
}
