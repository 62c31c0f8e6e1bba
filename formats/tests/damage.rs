//! Whatever is cut off or flipped in a dump is found, and nothing that is left makes a reader panic.
#![allow(clippy::unwrap_used, reason = "this is test code, also outside test functions")]

mod hostile;

use std::fs;
use std::path::{Path, PathBuf};

use fastrand::Rng;
use formats::manifest::{ArrayRecord, Place, Record, Source};
use formats::reader::{Dump, ReadError};
use hostile::{assert_sentence, sample, use_everything};
use sample::{frames, part};

const SEED: u64 = 0x5eed_f00d;

fn arrays(dump: &Path) -> Vec<ArrayRecord> {
    Dump::open(dump).unwrap().manifest().arrays.clone()
}

/// A right dump of the sample's scene, one queue and two methods: small enough to be cut at every byte.
fn small(folder: &Path) -> PathBuf {
    sample::thinned(&sample::write(folder), "small", &[sample::QUEUE], &["aila", "two-point-adaptive"])
}

#[test]
fn a_manifest_cut_at_every_byte_gives_one_sentence_or_what_comes_before() {
    let folder = sample::folder_in_memory();
    let dump = small(folder.path());
    assert!(use_everything(&dump));
    let bytes = fs::read(dump.join("manifest.bin")).unwrap();
    let frames = frames(&dump);
    for cut in 0..bytes.len() {
        fs::write(dump.join("manifest.bin"), &bytes[..cut]).unwrap();
        assert_sentence(&Dump::open(&dump).unwrap_err().to_string());
    }
    // A recording that runs is right as far as it got, unless its header is not there yet.
    let partial = folder.path().join("cut.raydump.partial");
    fs::rename(&dump, &partial).unwrap();
    for cut in 0..bytes.len() {
        fs::write(partial.join("manifest.bin"), &bytes[..cut]).unwrap();
        let has_header = frames[0].end <= cut as u64;
        assert_eq!(use_everything(&partial), has_header, "cut at {cut}");
    }
}

#[test]
fn arrays_cut_anywhere_are_refused_and_found() {
    let folder = sample::folder_in_memory();
    for (dump, cuts) in [(small(folder.path()), 900), (folder.path().join("sample.raydump"), 100)] {
        let arrays = arrays(&dump);
        let mut random = Rng::with_seed(SEED);
        for _ in 0..cuts {
            let array = &arrays[random.usize(..arrays.len())];
            let file = dump.join(array.place.to_string());
            let bytes = fs::read(&file).unwrap();
            let cut = random.usize(..bytes.len());
            fs::write(&file, &bytes[..cut]).unwrap();
            let error = Dump::open(&dump).unwrap().bytes(array).unwrap_err();
            assert!(matches!(error, ReadError::FileLength { .. }), "{}: {error}", array.place);
            assert!(!use_everything(&dump), "{} cut to {cut} bytes, seed {SEED:#x}", array.place);
            fs::write(&file, bytes).unwrap();
        }
        assert!(use_everything(&dump));
    }
}

#[test]
fn every_flipped_bit_is_refused_or_found() {
    let folder = sample::folder_in_memory();
    for (dump, flips) in [(small(folder.path()), 1700), (folder.path().join("sample.raydump"), 300)] {
        let mut files = vec!["manifest.bin".to_owned()];
        files.extend(arrays(&dump).iter().map(|array| array.place.to_string()));
        let mut random = Rng::with_seed(SEED);
        for _ in 0..flips {
            let file = dump.join(&files[random.usize(..files.len())]);
            let bytes = fs::read(&file).unwrap();
            let (at, bit) = (random.usize(..bytes.len()), random.usize(..8));
            let mut flipped = bytes.clone();
            flipped[at] ^= 1 << bit;
            fs::write(&file, &flipped).unwrap();
            assert!(!use_everything(&dump), "{} byte {at} bit {bit}, seed {SEED:#x}", file.display());
            fs::write(&file, bytes).unwrap();
        }
        assert!(use_everything(&dump));
    }
}

/// A terminal obeys control characters, and a file may hold any.
#[test]
fn names_from_a_file_stay_in_one_line() {
    const NAME: &str = "a\nb\u{1b}[2J\u{9b}c";
    let folder = sample::folder_in_memory();
    let dump = small(folder.path());
    let records = sample::records(&dump);
    let edits: [fn(&mut Record); 7] = [
        |record| {
            part::header(record).into_iter().for_each(|header| header.options.table_layout = NAME.into())
        },
        |record| part::method(record).into_iter().for_each(|method| method.name.insert_str(0, NAME)),
        |record| part::method(record).into_iter().for_each(|method| method.text = NAME.into()),
        |record| part::method(record).into_iter().for_each(|method| method.text += "\n\u{a0}"),
        |record| part::method(record).into_iter().for_each(|method| method.layout[0] = NAME.into()),
        |record| part::queue(record).into_iter().for_each(|queue| queue.methods.push(NAME.into())),
        |record| {
            let source = Source::Replayed { name: NAME.into(), manifest_sha256: [0; 32] };
            part::header(record).into_iter().for_each(|header| header.source = source.clone());
        },
    ];
    for (at, edit) in edits.into_iter().enumerate() {
        let edited = records.iter().cloned().flat_map(|mut record| {
            edit(&mut record);
            // A name that comes a second time is refused by name.
            let times = if matches!(record, Record::Method(_)) && at == 1 { 2 } else { 1 };
            vec![record; times]
        });
        sample::write_manifest(&dump, &edited.collect::<Vec<_>>());
        use_everything(&dump);
        if let Ok(dump) = Dump::open(&dump) {
            assert_sentence(&dump.array::<f32>(&Place::Image).unwrap_err().to_string());
        }
    }
}

/// The name of a replay's source comes from a file too.
#[test]
fn sources_are_looked_for_in_the_same_folder_alone() {
    let (folder, source) = sample::in_memory();
    let inner = folder.path().join("inner");
    fs::create_dir(&inner).unwrap();
    let replay = inner.join("replay.raydump");
    fs::create_dir(&replay).unwrap();
    let manifest_sha256 = Dump::open(&source).unwrap().manifest_sha256().unwrap();
    let has_source = |name: &str| {
        sample::empty_replay(&replay, name, manifest_sha256);
        use_everything(&replay);
        let dump = Dump::open(&replay).unwrap();
        let error = dump.array::<f32>(&Place::Image).err();
        error.iter().for_each(|error| assert_sentence(&error.to_string()));
        assert_eq!(error.is_none(), dump.source().is_some(), "{name:?}");
        dump.source().is_some()
    };
    let absolute = source.to_str().unwrap();
    let beside = inner.join("sample.raydump");
    for name in
        ["../sample.raydump", absolute, "..", ".", "", "/", "\0", "a\nb", "inner/../../sample.raydump"]
    {
        assert!(!has_source(name), "{name:?}");
    }
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(&source, &beside).unwrap();
        assert!(!has_source("sample.raydump"), "a link");
        fs::remove_file(&beside).unwrap();
    }
    fs::rename(&source, &beside).unwrap();
    for name in ["./sample.raydump", "sample.raydump/", "sample.raydump/."] {
        assert!(!has_source(name), "{name:?}");
    }
    assert!(has_source("sample.raydump"));
}

#[cfg(unix)]
mod links {
    use std::os::unix::fs::symlink;

    use formats::recover::recover;

    use super::*;

    /// A dump in which the array's file, or a folder above it, is a link to the same thing elsewhere.
    #[test]
    fn linked_arrays_and_folders_are_refused_by_every_reader() {
        for depth in 1..=4 {
            let folder = sample::folder_in_memory();
            let dump = small(folder.path());
            let array =
                arrays(&dump).into_iter().find(|array| array.place.to_string().contains("rays")).unwrap();
            let relative = array.place.to_string();
            let part: PathBuf = relative.split('/').take(depth).collect();
            let outside = folder.path().join("outside");
            fs::rename(dump.join(&part), &outside).unwrap();
            symlink(&outside, dump.join(&part)).unwrap();
            let before = listing(&outside);
            let error = Dump::open(&dump).unwrap().bytes(&array).unwrap_err();
            assert!(matches!(error, ReadError::NotPlain { found: "a link", .. }), "{error}");
            assert!(!use_everything(&dump));
            assert!(
                recover(&dump).is_ok_and(|recovery| !recovery.left_out.is_empty()),
                "the scene is still there"
            );
            assert!(use_everything(&dump));
            assert_eq!(listing(&outside), before, "nothing outside has changed");
        }
    }

    /// Recovering writes to the manifest: never through a link to somebody's file.
    #[test]
    fn a_linked_manifest_is_not_written_through() {
        let folder = sample::folder_in_memory();
        let dump = small(folder.path());
        let outside = folder.path().join("outside.bin");
        let bytes = fs::read(dump.join("manifest.bin")).unwrap();
        fs::write(&outside, &bytes[..bytes.len() - 1]).unwrap();
        for name in ["small.raydump", "other.raydump.partial"] {
            let path = folder.path().join(name);
            if path != dump {
                fs::rename(&dump, &path).unwrap();
            }
            fs::remove_file(path.join("manifest.bin")).unwrap();
            symlink(&outside, path.join("manifest.bin")).unwrap();
            let opened = Dump::open(&path);
            assert!(matches!(opened, Err(ReadError::NotARecording { .. })), "{name}: {opened:?}");
            let error = recover(&path).unwrap_err();
            assert_sentence(&error.to_string());
            assert!(fs::read(&outside).unwrap() == bytes[..bytes.len() - 1], "{name}: {error}");
        }
    }

    /// So does the new manifest until it has its name.
    #[test]
    fn a_link_in_the_place_of_the_new_manifest_is_not_written_through() {
        let folder = sample::folder_in_memory();
        let dump = small(folder.path());
        let outside = folder.path().join("outside.bin");
        fs::write(&outside, b"precious").unwrap();
        symlink(&outside, dump.join("manifest.bin.new")).unwrap();
        let manifest = dump.join("manifest.bin");
        let bytes = fs::read(&manifest).unwrap();
        fs::write(&manifest, &bytes[..bytes.len() - 1]).unwrap();
        recover(&dump).unwrap();
        assert_eq!(fs::read(&outside).unwrap(), b"precious");
        assert!(use_everything(&dump));
    }

    fn listing(path: &Path) -> Vec<(PathBuf, u64)> {
        if path.is_file() {
            return vec![(path.to_owned(), path.metadata().unwrap().len())];
        }
        let mut found: Vec<_> =
            fs::read_dir(path).unwrap().flat_map(|entry| listing(&entry.unwrap().path())).collect();
        found.sort();
        found
    }
}
