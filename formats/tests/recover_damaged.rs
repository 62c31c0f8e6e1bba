//! Whatever is damaged, `recover` keeps all that is whole, and `verify` accepts it.
#![allow(clippy::unwrap_used, reason = "this is test code, also outside test functions")]

mod hostile;

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use formats::manifest::scan::scan;
use formats::manifest::{QueueId, Record};
use formats::ray::Kind;
use formats::reader::{Dump, DumpState};
use formats::recover::{RecoverError, Recovery, recover};
use formats::verify::verify;
use hostile::{assert_sentence, sample, use_everything};
use sample::frames;

/// The paths of the arrays that the manifest names.
fn arrays(dump: &Path) -> BTreeSet<String> {
    Dump::open(dump).unwrap().manifest().arrays.iter().map(|array| array.place.to_string()).collect()
}

/// A right dump with one queue of each of these kinds and these methods.
fn thinned(folder: &Path, kinds: &[Kind], methods: &[&str]) -> PathBuf {
    let queues: Vec<_> = kinds.iter().map(|&kind| QueueId { pass: 1, bounce: 1, kind }).collect();
    sample::thinned(&sample::write(folder), "small", &queues, methods)
}

/// Files and their bytes, from which a dump is made again and again.
struct Original(Vec<(String, Vec<u8>)>);

impl Original {
    fn of(dump: &Path) -> Self {
        let names = arrays(dump).into_iter().chain(["manifest.bin".to_owned()]);
        Self(names.map(|name| (name.clone(), fs::read(dump.join(name)).unwrap())).collect())
    }

    fn write(&self, to: &Path) {
        for (name, bytes) in &self.0 {
            let file = to.join(name);
            fs::create_dir_all(file.parent().unwrap()).unwrap();
            fs::write(file, bytes).unwrap();
        }
    }
}

fn flip(file: &Path, at: u64) {
    let mut bytes = fs::read(file).unwrap();
    bytes[at as usize] ^= 16;
    fs::write(file, bytes).unwrap();
}

fn assert_right(dump: &Path, what: &str) {
    let problems = || {
        let checks = verify(&Dump::open(dump).unwrap()).checks;
        checks.into_iter().flat_map(|check| check.problems.first).collect::<Vec<_>>()
    };
    assert!(use_everything(dump), "{what}: {:#?}", problems());
}

/// Recovers what lies in `dump`, whose arrays but `lost` are whole.
fn assert_recovers(dump: &Path, whole: &BTreeSet<String>, lost: &BTreeSet<String>) -> Recovery {
    let recovery = recover(dump).unwrap();
    recovery.left_out.iter().chain(&recovery.cut).for_each(|damage| assert_sentence(damage));
    let kept: BTreeSet<String> = whole.difference(lost).cloned().collect();
    assert_eq!(arrays(dump), kept, "without {lost:?}");
    assert_eq!(recovery.arrays, kept.len());
    assert!(!recovery.is_complete);
    assert_eq!(Dump::open(dump).unwrap().state(), DumpState::Recovered);
    assert_right(dump, &format!("without {lost:?}"));
    // Again there is nothing to do.
    let again = recover(dump).unwrap();
    assert!(again.cut.is_none() && again.leftover.is_none() && again.arrays == kept.len(), "{again:?}");
    recovery
}

#[test]
fn each_damaged_array_is_left_out_alone() {
    let folder = sample::folder_in_memory();
    let methods = ["aila", "two-point-adaptive", "two-point-real", "light-octahedron"];
    let dump = thinned(folder.path(), &Kind::ALL, &methods);
    let original = Original::of(&dump);
    let (whole, copy) = (arrays(&dump), folder.path().join("copy.raydump"));
    let manifest = fs::read(dump.join("manifest.bin")).unwrap();
    for lost in &whole {
        original.write(&copy);
        let file = copy.join(lost);
        flip(&file, fs::metadata(&file).unwrap().len() - 1);
        let damaged = fs::read(&file).unwrap();
        let recovery = assert_recovers(&copy, &whole, &[lost.clone()].into());
        assert!(matches!(&recovery.left_out[..], [damage] if damage.contains(lost)), "{recovery:?}");
        let (leftover, files) = recovery.leftover.unwrap();
        assert_eq!(files, 2, "the array and the old manifest");
        assert_eq!(fs::read(leftover.join(lost)).unwrap(), damaged);
        assert!(fs::read(leftover.join("manifest.bin")).unwrap() == manifest, "the old manifest is kept");
        for part in [&copy, &leftover] {
            fs::remove_dir_all(part).unwrap();
        }
    }
}

#[test]
fn any_damaged_arrays_are_left_out() {
    let (folder, whole_dump) = sample::in_memory();
    let original = Original::of(&whole_dump);
    let (whole, copy) = (arrays(&whole_dump), folder.path().join("copy.raydump"));
    let mut random = fastrand::Rng::with_seed(0x5eed_f00d);
    for round in 0..24 {
        original.write(&copy);
        let mut lost = BTreeSet::new();
        for array in &whole {
            // From a few to nearly all.
            if random.u32(..25) <= round {
                fs::remove_file(copy.join(array)).unwrap();
                lost.insert(array.clone());
            }
        }
        let recovery = assert_recovers(&copy, &whole, &lost);
        assert_eq!(recovery.left_out.len(), lost.len());
        fs::remove_dir_all(recovery.leftover.unwrap().0).unwrap();
        fs::remove_dir_all(&copy).unwrap();
    }
}

/// A record's length leads to the next one, whatever its bytes are.
#[test]
fn each_damaged_record_is_left_out_alone() {
    let folder = sample::folder_in_memory();
    let dump = thinned(folder.path(), &Kind::ALL, &["aila", "light-octahedron"]);
    let original = Original::of(&dump);
    let (whole, copy) = (arrays(&dump), folder.path().join("copy.raydump"));
    let frames = frames(&dump);
    let last = frames.len() - 1;
    for (at, frame) in frames.iter().enumerate() {
        original.write(&copy);
        flip(&copy.join("manifest.bin"), (frame.offset + 8 + frame.end) / 2);
        let lost: BTreeSet<String> = match &frame.record {
            // Without it no record has a meaning.
            Record::Header(_) => {
                let error = recover(&copy).unwrap_err();
                assert!(matches!(error, RecoverError::Nothing { .. }), "{error}");
                continue;
            }
            Record::Array(array) => [array.place.to_string()].into(),
            Record::Method(method) => {
                let part = format!("/{}/", method.name);
                whole.iter().filter(|path| path.contains(&part)).cloned().collect()
            }
            _ => BTreeSet::new(),
        };
        let recovery = assert_recovers(&copy, &whole, &lost);
        assert_eq!(recovery.cut.is_some(), at == last, "{:?}", frame.record);
        fs::remove_dir_all(recovery.leftover.unwrap().0).unwrap();
        fs::remove_dir_all(&copy).unwrap();
    }
}

/// Its records go on being read by the rules of the version that wrote them.
#[test]
fn an_older_manifest_stays_one_of_its_version() {
    let folder = sample::folder_in_memory();
    let dump = thinned(folder.path(), &[Kind::Closest], &["aila"]);
    let manifest = dump.join("manifest.bin");
    sample::set_version(&dump, 8);
    let timing = frames(&dump).into_iter().find(|frame| matches!(frame.record, Record::Timing(_))).unwrap();
    flip(&manifest, timing.end - 1);
    recover(&dump).unwrap();
    assert_eq!(scan(&manifest).unwrap().version, 8);
    assert_right(&dump, "version 8");
}

/// A length that leads nowhere: nothing after it can be believed.
#[test]
fn a_false_length_ends_what_is_read() {
    let folder = sample::folder_in_memory();
    let dump = thinned(folder.path(), &[Kind::Closest], &["aila"]);
    let frames = frames(&dump);
    let middle = &frames[frames.len() / 2];
    flip(&dump.join("manifest.bin"), middle.offset);
    let before = frames.iter().filter(|frame| frame.offset < middle.offset);
    let expected = before.filter(|frame| matches!(frame.record, Record::Array(_))).count();
    let recovery = recover(&dump).unwrap();
    assert!(recovery.cut.is_some() && recovery.arrays == expected, "{recovery:?}");
    assert_right(&dump, "a false length");
}

#[test]
fn a_manifest_cut_at_every_byte_is_recovered() {
    let folder = sample::folder_in_memory();
    let dump = thinned(folder.path(), &[Kind::Closest], &["aila"]);
    let frames = frames(&dump);
    let original = Original::of(&dump);
    let manifest = fs::read(dump.join("manifest.bin")).unwrap();
    let (partial, recovered) = (folder.path().join("cut.raydump.partial"), folder.path().join("cut.raydump"));
    original.write(&partial);
    for cut in (0..manifest.len()).rev() {
        fs::write(partial.join("manifest.bin"), &manifest[..cut]).unwrap();
        let before: Vec<_> = frames.iter().take_while(|frame| frame.end <= cut as u64).collect();
        let arrays = before.iter().filter(|frame| matches!(frame.record, Record::Array(_))).count();
        match recover(&partial) {
            Ok(recovery) => {
                assert_eq!(recovery.arrays, arrays, "cut at {cut}");
                // What is verified once stays right while only the torn record gets shorter.
                if frames.iter().any(|frame| frame.end == cut as u64) {
                    assert_right(&recovered, "a cut manifest");
                }
                // The next cut is shorter, so that what is left over is not needed any more.
                recovery.leftover.iter().for_each(|(folder, _)| fs::remove_dir_all(folder).unwrap());
                fs::rename(&recovered, &partial).unwrap();
            }
            Err(error) => {
                assert!(
                    arrays == 0 && matches!(error, RecoverError::Nothing { .. }),
                    "cut at {cut}: {error}"
                );
                assert_sentence(&error.to_string());
            }
        }
    }
}

#[test]
fn an_array_cut_at_every_byte_is_left_out() {
    let folder = sample::folder_in_memory();
    let dump = thinned(folder.path(), &[Kind::Closest], &["aila"]);
    let original = Original::of(&dump);
    let (whole, copy) = (arrays(&dump), folder.path().join("copy.raydump"));
    let array = "scene/materials.npy";
    let bytes = fs::read(dump.join(array)).unwrap();
    original.write(&copy);
    for cut in 0..bytes.len() {
        fs::write(copy.join(array), &bytes[..cut]).unwrap();
        fs::copy(dump.join("manifest.bin"), copy.join("manifest.bin")).unwrap();
        let recovery = assert_recovers(&copy, &whole, &[array.to_owned()].into());
        fs::remove_dir_all(recovery.leftover.unwrap().0).unwrap();
    }
}

/// The steps that `recover` takes, each the last one before it was killed.
#[test]
fn killed_half_way_it_can_be_run_again() {
    let folder = sample::folder_in_memory();
    let dump = thinned(folder.path(), &[Kind::Closest], &["aila"]);
    let whole = arrays(&dump);
    let lost: BTreeSet<String> = ["scene/positions.npy".to_owned()].into();
    let flipped = dump.join("scene/positions.npy");
    flip(&flipped, 130);
    let (original, damaged) = (Original::of(&dump), fs::read(&flipped).unwrap());
    recover(&dump).unwrap();
    let new_manifest = fs::read(dump.join("manifest.bin")).unwrap();
    let copy = folder.path().join("copy.raydump");
    let is_the_same = |step: &str| {
        let recovery = assert_recovers(&copy, &whole, &lost);
        assert!(fs::read(copy.join("manifest.bin")).unwrap() == new_manifest, "{step}");
        let leftover = recovery.leftover.unwrap().0;
        assert_eq!(fs::read(leftover.join("scene/positions.npy")).unwrap(), damaged, "{step}");
        for entry in fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().path()) {
            if entry.to_str().unwrap().contains("copy.raydump") {
                fs::remove_dir_all(entry).unwrap();
            }
        }
    };
    original.write(&copy);
    fs::write(copy.join("manifest.bin.new"), &new_manifest[..new_manifest.len() / 2]).unwrap();
    is_the_same("the new manifest is half written");
    original.write(&copy);
    fs::create_dir(folder.path().join("copy.raydump.leftover")).unwrap();
    fs::copy(copy.join("manifest.bin"), folder.path().join("copy.raydump.leftover/manifest.bin")).unwrap();
    fs::write(copy.join("manifest.bin.new"), &new_manifest).unwrap();
    is_the_same("the old manifest is kept");
    original.write(&copy);
    fs::write(copy.join("manifest.bin"), &new_manifest).unwrap();
    is_the_same("the new manifest has its name");
}

#[test]
fn nothing_whole_is_said_with_its_reason() {
    let folder = sample::folder_in_memory();
    let dump = thinned(folder.path(), &[], &[]);
    let manifest = fs::read(dump.join("manifest.bin")).unwrap();
    for array in arrays(&dump) {
        fs::remove_file(dump.join(array)).unwrap();
    }
    let error = recover(&dump).unwrap_err().to_string();
    assert!(error.contains("nothing is whole") && error.contains("positions.npy"), "{error}");
    assert!(fs::read(dump.join("manifest.bin")).unwrap() == manifest, "nothing was changed");
}
