//! What is written is read again; what is damaged is refused.
#![allow(clippy::unwrap_used, reason = "this is test code, also outside test functions")]

mod sample;

use std::fs;
use std::path::Path;
use std::time::Duration;

use formats::manifest::scan::{scan, scan_bytes};
use formats::manifest::{
    FORMAT_VERSION, Header, Manifest, OLDEST_VERSION, Place, QueueArray, QueueId, RECORD_BYTES_MAX, Record,
    SceneArray,
};
use formats::ray::{Hit, Kind, Ray};
use formats::reader::{Dump, DumpState, ReadError};
use formats::writer::{DumpWriter, WriteError};

fn rays_place() -> Place {
    Place::Queue(QueueId { pass: 1, bounce: 1, kind: Kind::Closest }, QueueArray::Rays)
}

#[test]
fn a_dump_comes_back() {
    let (folder, path) = sample::in_memory();
    assert_eq!(path, folder.path().join("sample.raydump"));
    assert!(!folder.path().join("sample.raydump.partial").exists());
    let dump = Dump::open_mapped(&path).unwrap();
    assert_eq!(dump.state(), DumpState::Complete);
    assert_eq!(dump.manifest().header, sample::header());
    assert_eq!(dump.manifest().queues.len(), 8);
    let positions = dump.array::<[f32; 3]>(&Place::Scene(SceneArray::Positions)).unwrap();
    assert_eq!(&positions[..], sample::positions());
    assert_eq!(positions.as_ptr() as usize % 64, 0);
    let triangles = dump.array::<u32>(&Place::Scene(SceneArray::Triangles)).unwrap();
    assert_eq!(&triangles[..], sample::TRIANGLES.as_flattened());
    assert_eq!(dump.array::<[f32; 3]>(&Place::Image).unwrap().len(), 16 * 12);
    assert!(dump.array::<Ray>(&rays_place()).unwrap().len() > 50);
    assert!(matches!(dump.array::<Hit>(&rays_place()), Err(ReadError::WrongType { .. })));
    assert!(matches!(dump.array::<[u32; 3]>(&Place::Image), Err(ReadError::WrongType { .. })));
    let absent = Place::Scene(SceneArray::Mask(9));
    let said = |place: &Place| dump.array::<u8>(place).unwrap_err().to_string();
    assert!(matches!(dump.array::<u8>(&absent), Err(ReadError::NoSuchArray { .. })));
    assert!(!said(&absent).contains("--keep"), "scenes are kept, and this one has no such mask");
    let thin = Dump::open(&sample::thinned(&path, "thin", &[], &[])).unwrap();
    let unkept = thin.array::<f32>(&Place::Image).unwrap_err().to_string();
    assert!(unkept.contains("without image: `--keep rays,") && unkept.ends_with(",image`"), "{unkept}");
}

#[test]
fn the_same_recording_gives_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let (a, b) = (folder.path().join("a"), folder.path().join("b"));
    for folder in [&a, &b] {
        fs::create_dir(folder).unwrap();
        sample::write(folder);
    }
    let manifest = |folder: &Path| fs::read(folder.join("sample.raydump/manifest.bin")).unwrap();
    assert!(manifest(&a) == manifest(&b));
}

#[test]
fn a_recording_that_runs_can_be_read_up_to_now() {
    let folder = tempfile::tempdir().unwrap();
    let mut writer =
        DumpWriter::create(&folder.path().join("sample.raydump"), sample::header(), false).unwrap();
    let end = sample::write_all(&mut writer).unwrap();
    let partial = folder.path().join("sample.raydump.partial");
    let dump = Dump::open(&partial).unwrap();
    assert_eq!(dump.state(), DumpState::Partial);
    dump.array::<Ray>(&rays_place()).unwrap();
    let error = Dump::open(&folder.path().join("sample.raydump")).unwrap_err();
    assert!(error.to_string().contains("sample.raydump.partial"), "{error}");
    let other = DumpWriter::create(&folder.path().join("sample"), sample::header(), true);
    assert!(matches!(other, Err(WriteError::Busy { .. })), "{other:?}");
    writer.finish(end).unwrap();
}

/// While one recording waits for another of its name, that one may be finished.
#[test]
fn a_recording_that_ends_meanwhile_was_not_left_over() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sample.raydump");
    let mut writer = DumpWriter::create(&path, sample::header(), false).unwrap();
    let end = sample::write_all(&mut writer).unwrap();
    std::thread::scope(|scope| {
        let path = &path;
        let [kept, replaced] =
            [false, true].map(|overwrite| scope.spawn(move || DumpWriter::check(path, overwrite, &[])));
        std::thread::sleep(Duration::from_millis(200));
        writer.finish(end).unwrap();
        let kept = kept.join().unwrap();
        assert!(matches!(kept, Err(WriteError::Exists { .. })), "{kept:?}");
        replaced.join().unwrap().unwrap();
    });
}

/// It would be in the way of the next one.
#[test]
fn a_recording_that_cannot_begin_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let header = Header { notices: vec!["x".repeat(RECORD_BYTES_MAX)], ..sample::header() };
    let error = DumpWriter::create(&folder.path().join("sample"), header, false).unwrap_err();
    assert!(matches!(error, WriteError::RecordTooLong { .. }), "{error}");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn existing_dumps_are_replaced_only_when_told_and_only_at_the_end() {
    let (folder, path) = sample::in_memory();
    let again = DumpWriter::create(&path, sample::header(), false);
    assert!(matches!(again, Err(WriteError::Exists { .. })), "{again:?}");
    let mut writer = DumpWriter::create(&path, sample::header(), true).unwrap();
    let end = sample::write_all(&mut writer).unwrap();
    Dump::open(&path).unwrap();
    drop(writer);
    let left = DumpWriter::create(&folder.path().join("sample"), sample::header(), false);
    assert!(matches!(left, Err(WriteError::Exists { .. })), "{left:?}");
    fs::rename(&path, folder.path().join("other.raydump")).unwrap();
    let left = DumpWriter::create(&path, sample::header(), false);
    assert!(matches!(left, Err(WriteError::LeftOver { .. })), "{left:?}");
    fs::rename(folder.path().join("other.raydump"), &path).unwrap();
    let mut writer = DumpWriter::create(&path, sample::header(), true).unwrap();
    sample::write_all(&mut writer).unwrap();
    writer.finish(end).unwrap();
    Dump::open(&path).unwrap();
    let names: Vec<_> =
        fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert_eq!(names, ["sample.raydump"]);
}

#[test]
fn nothing_but_recordings_is_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("photos.raydump");
    fs::create_dir(&path).unwrap();
    fs::write(path.join("me.jpg"), b"").unwrap();
    let error = DumpWriter::create(&path, sample::header(), true).unwrap_err();
    assert!(matches!(error, WriteError::NotARecording { .. }), "{error}");
    assert!(path.join("me.jpg").exists());
    let in_nowhere = DumpWriter::create(&folder.path().join("no/where"), sample::header(), true).unwrap_err();
    assert!(in_nowhere.to_string().contains("no/where.raydump.partial"), "{in_nowhere}");
    assert!(matches!(
        DumpWriter::create(Path::new("/"), sample::header(), true),
        Err(WriteError::Name { .. })
    ));
}

#[test]
fn arrays_hold_what_they_promise() {
    let folder = tempfile::tempdir().unwrap();
    let mut writer = DumpWriter::create(&folder.path().join("x"), sample::header(), false).unwrap();
    let place = Place::Scene(SceneArray::Materials);
    let count = |error| assert!(matches!(error, Err(WriteError::Count { .. })), "{error:?}");
    count(writer.whole_array(&place, &[4], &[1u32, 2, 3]));
    count(writer.whole_array(&place, &[2], &[1u32, 2, 3]));
    assert!(matches!(writer.whole_array(&place, &[1], &[1.0f32]), Err(WriteError::Shape { .. })));
    // What failed is gone and may be written again, what succeeded may not.
    assert!(!folder.path().join("x.raydump.partial/scene/materials.npy").exists());
    writer.whole_array(&place, &[3], &[1u32, 2, 3]).unwrap();
    assert!(matches!(writer.whole_array(&place, &[3], &[1u32, 2, 3]), Err(WriteError::Twice { .. })));
}

/// The manifest cannot be read, or is cut before its end record.
fn is_refused(bytes: &[u8]) -> bool {
    match scan_bytes(bytes, bytes.len() as u64, Path::new("manifest.bin")) {
        Err(_) => true,
        Ok(scan) => {
            let ends = matches!(scan.frames.last(), Some(frame) if matches!(frame.record, Record::End(_)));
            scan.fault.is_some() || !ends
        }
    }
}

#[test]
fn every_changed_byte_of_the_manifest_is_found() {
    let (_folder, path) = sample::in_memory();
    let original = fs::read(path.join("manifest.bin")).unwrap();
    assert!(!is_refused(&original));
    for at in 0..original.len() {
        for bit in [at % 8, 7 - at % 8] {
            let mut changed = original.clone();
            changed[at] ^= 1 << bit;
            // The number of the version has no checksum, and older versions are read.
            let is_older = at == 8 && (OLDEST_VERSION..FORMAT_VERSION).contains(&changed[at].into());
            assert!(is_older || is_refused(&changed), "byte {at} of {}", original.len());
        }
    }
}

#[test]
fn every_changed_byte_of_an_array_header_and_a_longer_or_missing_file_is_found() {
    let (_folder, path) = sample::in_memory();
    let dump = Dump::open(&path).unwrap();
    let file = path.join(rays_place().to_string());
    let original = fs::read(&file).unwrap();
    let data = dump.record(&rays_place()).unwrap().bytes as usize;
    for at in 0..original.len() - data {
        let mut changed = original.clone();
        changed[at] ^= 1 << (at % 8);
        fs::write(&file, &changed).unwrap();
        let error = dump.array::<Ray>(&rays_place()).unwrap_err();
        assert!(error.to_string().contains("rays.npy"), "byte {at}: {error}");
    }
    fs::write(&file, [&original[..], &[0]].concat()).unwrap();
    assert!(matches!(dump.array::<Ray>(&rays_place()), Err(ReadError::FileLength { .. })));
    fs::remove_file(&file).unwrap();
    assert!(matches!(dump.array::<Ray>(&rays_place()), Err(ReadError::Io { .. })));
}

/// Well-formed records that lie: each with a right checksum, so that only the rules can refuse it.
#[test]
fn lying_records_are_refused() {
    let (_folder, path) = sample::in_memory();
    let manifest = path.join("manifest.bin");
    let original = fs::read(&manifest).unwrap();
    let scanned = scan(&manifest).unwrap();
    let frames = scanned.frames.clone();
    assert!(Manifest::of(scanned).is_some());
    let array = frames.iter().find(|frame| matches!(frame.record, Record::Array(_))).unwrap();
    let payload = &original[array.offset as usize + 8..array.end as usize];
    let text = "scene/positions.npy";
    let name = payload.windows(text.len()).position(|window| window == text.as_bytes()).unwrap();
    let shape = payload.len() - 4 - 8 - 16;
    let rewrite = |change: &dyn Fn(&mut Vec<u8>), part: &str| {
        let mut lying = payload.to_vec();
        change(&mut lying);
        let mut bytes = original[..array.offset as usize].to_vec();
        bytes.extend((lying.len() as u32).to_le_bytes());
        bytes.extend(crc32c::crc32c(&lying).to_le_bytes());
        bytes.extend(&lying);
        bytes.extend(&original[array.end as usize..]);
        fs::write(&manifest, bytes).unwrap();
        let error = Dump::open(&path).unwrap_err().to_string();
        assert!(error.contains(part), "{error}: expected {part}");
        assert!(error.contains(&format!("offset {}", array.offset)), "{error}");
    };
    let put = |at: usize, new: &'static [u8]| {
        move |bytes: &mut Vec<u8>| bytes[at..at + new.len()].copy_from_slice(new)
    };
    rewrite(&put(name, b"scene/../../positio"), "is not the path of an array");
    rewrite(&put(name, b"/etc/passwd/passwd."), "is not the path of an array");
    rewrite(&put(name, b"scene/triangles.npy"), "expected <u4 (N, 3)");
    rewrite(&put(name - 8, b"\xff\xff\xff\xff\xff\xff\xff\x00"), "larger than the record can hold");
    rewrite(&put(name - 8, b"\xff\xff\xff\x07\x00\x00\x00\x00"), "larger than the record can hold");
    rewrite(&put(name - 8, b"\xff\xff\x00\x00\x00\x00\x00\x00"), "go on after its end");
    rewrite(&put(shape, b"\xff\xff\xff\xff\xff\xff\xff\xff"), "more than there can be");
    rewrite(&put(shape, b"\x0c"), "said to have");
    rewrite(&put(0, b"\x63"), "kind 99, which format version 13 does not have");
    rewrite(&|bytes| bytes.push(0), "its fields take");
    rewrite(&|bytes| bytes.clear(), "damaged");
    rewrite(&|bytes| *bytes = original[24..array.offset as usize].to_vec(), "damaged");
}

#[test]
fn the_header_comes_first_and_the_end_last_and_nothing_twice() {
    let (_folder, path) = sample::in_memory();
    let manifest = path.join("manifest.bin");
    let original = fs::read(&manifest).unwrap();
    let frames = scan(&manifest).unwrap().frames;
    let bytes_of = |at: usize| &original[frames[at].offset as usize..frames[at].end as usize];
    let expect = |order: &[usize], part: &str| {
        let mut bytes = original[..16].to_vec();
        order.iter().for_each(|&at| bytes.extend(bytes_of(at)));
        fs::write(&manifest, bytes).unwrap();
        let error = Dump::open(&path).unwrap_err().to_string();
        assert!(error.contains(part), "{error}: expected {part}");
    };
    let last = frames.len() - 1;
    expect(&[], "no header");
    expect(&[1, 0, last], "the header, which comes first");
    expect(&[0, 0, last], "second header");
    expect(&[0, 1, 1, last], "a second time");
    expect(&[0, last, 1], "follows the end");
    expect(&[0, 1], "without an end record");
}
