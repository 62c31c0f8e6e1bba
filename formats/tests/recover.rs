//! Whatever ends a recording, `recover` gives a dump that `verify` accepts, or says that there is none.
#![allow(clippy::unwrap_used, reason = "this is test code, also outside test functions")]

mod sample;

use std::fs;
use std::path::{Path, PathBuf};

use formats::manifest::Record;
use formats::manifest::scan::{Frame, scan_bytes};
use formats::reader::{Dump, DumpState};
use formats::recover::{RecoverError, recover};
use formats::verify::verify;
use formats::writer::DumpWriter;

/// A recording killed when its manifest had `manifest_bytes` bytes: the array that comes next is half written.
fn killed(sample: &Path, frames: &[Frame], manifest_bytes: usize, folder: &Path) -> PathBuf {
    let partial = folder.join("killed.raydump.partial");
    fs::create_dir(&partial).unwrap();
    let manifest = fs::read(sample.join("manifest.bin")).unwrap();
    fs::write(partial.join("manifest.bin"), &manifest[..manifest_bytes]).unwrap();
    fs::write(partial.join(formats::folder::RESERVE_NAME), [0; 100]).unwrap();
    for frame in frames {
        let Record::Array(array) = &frame.record else { continue };
        let relative = array.place.to_string();
        let (from, to) = (sample.join(&relative), partial.join(&relative));
        fs::create_dir_all(to.parent().unwrap()).unwrap();
        if frame.end > manifest_bytes as u64 {
            let bytes = fs::read(&from).unwrap();
            fs::write(&to, &bytes[..bytes.len() / 2]).unwrap();
            break;
        }
        fs::hard_link(&from, &to).unwrap();
    }
    partial
}

fn assert_right(dump: &Path) {
    let report = verify(&Dump::open(dump).unwrap());
    assert!(report.is_ok(), "{}: {report:#?}", dump.display());
}

#[test]
fn a_manifest_cut_at_any_byte_gives_the_records_before_it() {
    let (_folder, path) = sample::in_memory();
    let bytes = fs::read(path.join("manifest.bin")).unwrap();
    let frames = sample::frames(&path);
    for cut in 0..bytes.len() {
        let scan = scan_bytes(&bytes[..cut], cut as u64, &path).unwrap();
        let expected = frames.iter().take_while(|frame| frame.end <= cut as u64).count();
        assert_eq!(scan.frames.len(), expected, "cut at {cut}");
        assert_eq!(
            scan.fault.is_none(),
            cut == 16 || frames.iter().any(|frame| frame.end == cut as u64),
            "{cut}"
        );
    }
}

#[test]
fn killed_at_any_record_the_rest_is_recovered() {
    let source = sample::folder_in_memory();
    let sample = sample::write(source.path());
    let frames = sample::frames(&sample);
    let first_array = frames.iter().position(|frame| matches!(frame.record, Record::Array(_))).unwrap();
    // All of the first two queues; from then on the records repeat, and some are enough.
    for (at, frame) in frames.iter().enumerate().filter(|(at, _)| *at < 40 || at % 5 == 0) {
        // Between two records, or in the middle of one.
        let cut = if at % 2 == 0 { frame.offset } else { (frame.offset + frame.end) / 2 };
        let folder = sample::folder_in_memory();
        let partial = killed(&sample, &frames, cut as usize, folder.path());
        let dump = folder.path().join("killed.raydump");
        match recover(&partial) {
            Ok(recovery) => {
                assert!(at > first_array, "nothing was complete at {cut}");
                assert_eq!(recovery.dump, dump);
                let before = frames[..at].iter().filter(|frame| matches!(frame.record, Record::Array(_)));
                assert_eq!(recovery.arrays, before.count(), "cut at {cut}");
                assert!(!recovery.is_complete && !partial.exists());
                // At most the array that was being written.
                assert!(recovery.leftover.is_none_or(|(_, files)| files == 1));
                assert_eq!(Dump::open(&dump).unwrap().state(), DumpState::Recovered);
                assert_right(&dump);
            }
            Err(error) => {
                assert!(at <= first_array, "cut at {cut}: {error}");
                assert!(matches!(error, RecoverError::Nothing { .. }), "{error}");
                assert!(partial.join("manifest.bin").exists());
            }
        }
    }
}

#[test]
fn killed_before_the_rename_nothing_is_lost() {
    let (folder, path) = sample::in_memory();
    let partial = folder.path().join("sample.raydump.partial");
    fs::rename(&path, &partial).unwrap();
    // By the name that it was going to have.
    let recovery = recover(&folder.path().join("sample")).unwrap();
    assert!(recovery.is_complete && recovery.cut.is_none() && recovery.leftover.is_none(), "{recovery:?}");
    assert_eq!(Dump::open(&path).unwrap().state(), DumpState::Complete);
    let again = recover(&path).unwrap();
    assert_eq!(again, recovery);
    assert_right(&path);
}

#[test]
fn a_dropped_writer_can_be_recovered_and_a_running_one_is_left_alone() {
    let folder = sample::folder_in_memory();
    let mut writer = DumpWriter::create(&folder.path().join("x"), sample::header(), false).unwrap();
    sample::write_all(&mut writer).unwrap();
    assert!(matches!(recover(&folder.path().join("x")), Err(RecoverError::Busy { .. })));
    drop(writer);
    let recovery = recover(&folder.path().join("x")).unwrap();
    assert_right(&recovery.dump);
}

#[test]
fn bytes_after_the_end_are_cut_off() {
    let (_folder, path) = sample::in_memory();
    let manifest = path.join("manifest.bin");
    let original = fs::read(&manifest).unwrap();
    fs::write(&manifest, [&original[..], b"more"].concat()).unwrap();
    assert!(Dump::open(&path).is_err());
    let recovery = recover(&path).unwrap();
    assert!(recovery.is_complete && recovery.cut.is_some());
    assert_eq!(fs::read(&manifest).unwrap(), original);
}

#[test]
fn nothing_is_written_over() {
    let (folder, path) = sample::in_memory();
    let partial = folder.path().join("sample.raydump.partial");
    fs::create_dir(&partial).unwrap();
    fs::write(partial.join("manifest.bin"), fs::read(path.join("manifest.bin")).unwrap()).unwrap();
    assert!(matches!(recover(&partial), Err(RecoverError::Exists { .. })));
    assert!(matches!(recover(&folder.path().join("other")), Err(RecoverError::Missing { .. })));
    let newer = folder.path().join("newer.raydump.partial");
    fs::create_dir(&newer).unwrap();
    fs::write(newer.join("manifest.bin"), b"RAYDUMP\0\x63\0\0\0\0\0\0\0").unwrap();
    let error = recover(&newer).unwrap_err().to_string();
    assert!(error.contains("format version 99") && newer.join("manifest.bin").exists(), "{error}");
}
