//! `verify` says what a header and records claim that cannot be, and what is not there.
#![allow(clippy::unwrap_used, reason = "this is test code, also outside test functions")]

mod sample;

use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use formats::key::{LightSite, Termination};
use formats::manifest::{
    CacheRecord, CalibrationRecord, DecisionRecord, DisturbedRecord, End, Header, MethodRecord, Mismatches,
    Outcome, Place, QueueArray, QueueId, QueueRecord, Record, Source, Stage, TimingRecord, WayRecord,
};
use formats::ray::Kind;
use formats::reader::Dump;
use formats::verify::verify;
use sample::part;

fn problems(dump: &Dump) -> Vec<String> {
    verify(dump).checks.into_iter().flat_map(|check| check.problems.first).collect()
}

fn problems_in(dump: &Path) -> Vec<String> {
    problems(&Dump::open(dump).unwrap())
}

#[track_caller]
fn assert_said(problems: &[String], part: &str) {
    assert!(problems.iter().any(|problem| problem.contains(part)), "expected {part}: {problems:#?}");
}

/// A change of a part of a record, and what is said of it.
type Case<T> = (fn(&mut T), &'static str);

/// Asserts that each of these edits of every record that has such a part is found.
fn assert_found<T>(part_of: fn(&mut Record) -> Option<&mut T>, cases: &[Case<T>]) {
    let (_folder, dump) = sample::in_memory();
    let manifest = fs::read(dump.join("manifest.bin")).unwrap();
    for (change, said) in cases {
        sample::edit_parts(&dump, part_of, change);
        assert_said(&problems_in(&dump), said);
        fs::write(dump.join("manifest.bin"), &manifest).unwrap();
    }
    assert!(verify(&Dump::open(&dump).unwrap()).is_ok());
}

/// The time of one queue's unsorted rays.
fn baseline(record: &mut Record) -> Option<&mut TimingRecord> {
    let is_meant = |timing: &&mut TimingRecord| {
        timing.method == "unsorted" && (timing.bounce, timing.kind) == (1, Some(Kind::Shadow))
    };
    part::timing(record).filter(is_meant)
}

/// The record of one queue's unsorted rays, since one is told once.
fn disturbed(record: &mut Record) -> Option<&mut DisturbedRecord> {
    part::disturbed(record)
        .filter(|disturbed| (disturbed.queue.bounce, disturbed.queue.kind) == (1, Kind::Shadow))
}

/// Whatever the header says, nothing panics and nothing huge is allocated.
#[test]
fn absurd_headers_are_found() {
    let cases: &[Case<Header>] = &[
        (|header| header.options.width = 0, "0 × 12 pixels, expected"),
        (|header| header.options.height = 0, "16 × 0 pixels"),
        (|header| header.options.bounces = 0, "0 bounces, expected 1 to 99"),
        (|header| header.options.passes = 0, "0 passes, expected 1 to 999"),
        (|header| header.options.passes = u32::MAX, "4294967295 passes"),
        (|header| header.options.repeats = 0, "0 repeats"),
        (|header| header.options.key_bits = 0, "0 key bits"),
        (|header| header.options.key_bits = 65, "65 key bits, expected 8 to 64"),
        (|header| header.options.table_bits = 7, "7 table bits"),
        (|header| header.options.table_bits = 60, "60 table bits"),
        (|header| header.options.table_layout = "light".into(), "gives every ray a cell"),
        (|header| header.options.two_point_length = f32::NAN, "length of two-point is NaN, expected 0 to 2"),
        (|header| header.options.two_point_length = 2.5, "2.5"),
        (|header| header.options.two_point_length = -0.5, "-0.5"),
        (|header| header.camera.eye[1] = f32::INFINITY, "the camera's eye"),
        (|header| header.camera.forward = [f32::NAN; 3], "the camera's forward"),
        (|header| header.camera.right = [0.0; 3], "the camera's right"),
        (|header| header.camera.up[0] = 0.1, "the camera's up"),
        (|header| header.camera.yfov_radians = 0.0, "field of view is 0 radians"),
        (|header| header.camera.yfov_radians = f32::NAN, "field of view is NaN"),
        (|header| header.camera.yfov_radians = 3.2, "less than π"),
        (|header| header.scene.bounds_max[1] = f32::NAN, "box goes from"),
        (|header| header.scene.bounds_max[2] = f32::INFINITY, "box goes from"),
        (|header| header.scene.bounds_min = [5.0; 3], "the lowest first"),
        (|header| (header.scene.bounds_min, header.scene.bounds_max) = ([-3e38; 3], [3e38; 3]), "box"),
        (|header| header.options.keep.push("everything".into()), "it kept 'everything'"),
        (|header| header.options.table_method = "nope".into(), "addressed by 'nope'"),
        (|header| header.options.table_method = "two-point".into(), "addressed by 'two-point'"),
        (|header| header.options.methods.push("nope".into()), "no record of method nope"),
        (|header| header.lights.clear(), "for 0 lights"),
        (|header| header.lights[0] = LightSite::Placed { centre: [f32::NAN; 3] }, "light 0 is"),
        (|header| header.lights[2] = LightSite::directional([f32::INFINITY; 3]), "light 2 is"),
    ];
    assert_found(part::header, cases);
}

#[test]
fn queues_outside_of_the_recording_are_found() {
    let cases: &[Case<Header>] = &[
        (
            |header| header.options.passes = 1,
            "pass-001/bounce-00/closest: pass 1, bounce 0 of a recording of 1 pass and 2 bounces",
        ),
        (
            |header| header.options.bounces = 1,
            "pass-000/bounce-01/closest: pass 0, bounce 1 of a recording of 2 passes and 1 bounce",
        ),
    ];
    assert_found(part::header, cases);
}

#[test]
fn impossible_queues_are_found() {
    let cases: &[Case<QueueRecord>] = &[
        (|queue| queue.rays = 193, "193 rays, expected at most 16 × 12"),
        (|queue| queue.rays += 1, "entries, its record has"),
        (|queue| queue.methods.push("nope".into()), "no record of method nope"),
        (
            |queue| queue.mismatches.iter_mut().for_each(|found| found.rays = 193),
            "193 results of unsorted differ, of 192 rays",
        ),
        (|queue| queue.methods.truncate(1), "does not name aila"),
        (
            |queue| queue.mismatches.iter_mut().for_each(|found| found.rays = 1),
            "1 results of unsorted differ from themselves",
        ),
        (
            |queue| queue.mismatches.push(Mismatches { method: "reis".into(), rays: 0 }),
            "results of reis are said to differ, but it was not measured",
        ),
    ];
    assert_found(part::queue, cases);
}

#[test]
fn absurd_methods_are_found() {
    let cases: &[Case<MethodRecord>] = &[
        (|method| method.key_bits = 65, "method aila: keys of 65 bits"),
        (|method| method.text = "oq".into(), "method aila: unknown coordinate"),
        (|method| method.text = "(ox)*23".into(), "method aila: 'ox' is mentioned more than 22"),
        (|method| method.layout.reverse(), "method aila: its bits are not those"),
        (|method| method.name.insert_str(0, "x-"), "there is no record of this method"),
    ];
    assert_found(part::method, cases);
}

#[test]
fn lengths_that_do_not_fit_a_layout_are_found() {
    let cases: &[Case<MethodRecord>] = &[
        (
            |method| method.termination = Termination::Unused,
            "method two-point-adaptive: its length is Unused",
        ),
        (|method| method.termination = Termination::Real, "method aila: its length is Real"),
    ];
    assert_found(part::method, cases);
}

#[test]
fn times_of_what_was_not_measured_are_found() {
    let cases: &[Case<TimingRecord>] = &[
        (|timing| timing.pass = 7, "in pass 7, bounce 0: pass 7, bounce 0 of a recording of 2 passes"),
        (|timing| timing.bounce += 2, "bounce 2 of a recording"),
        (
            |timing| timing.method.insert(0, 'n'),
            "time of trace by nunsorted in pass 1, bounce 0: there is no record of method nunsorted",
        ),
        (|timing| timing.samples_ns.clear(), "it has 0 samples, expected 7"),
        (|timing| timing.samples_ns.push(1), "it has 8 samples, expected 7"),
    ];
    assert_found(part::timing, cases);
    // Of one queue, since a time is told once.
    let cases: &[Case<TimingRecord>] = &[
        (|timing| timing.kind = None, "it has no kind of queue, expected one"),
        (|timing| timing.stage = Stage::Shade, "it has a kind of queue, expected none"),
        (|timing| timing.stage = Stage::TraceIndirect, "unsorted rays are traced, and nothing else"),
    ];
    assert_found(baseline, cases);
    let shuffle: fn(&mut Record) = |record| match record {
        Record::Queue(queue) => queue.methods.push("shuffled".into()),
        Record::Timing(timing) if (timing.method.as_str(), timing.stage) == ("aila", Stage::Key) => {
            timing.method = "shuffled".into();
        }
        _ => {}
    };
    assert_found(|record| Some(record), &[(shuffle, "a random order has no key, and nothing to sort")]);
}

#[test]
fn disturbed_samples_and_ways_are_of_what_was_timed() {
    let cases: &[Case<DisturbedRecord>] = &[
        (|disturbed| disturbed.samples = vec![7], "there is a time of 7 samples"),
        (|disturbed| disturbed.stage = Stage::Scatter, "there is no such time"),
        (|disturbed| disturbed.method.push('x'), "there is no such time"),
    ];
    assert_found(disturbed, cases);
    let cases: &[Case<WayRecord>] =
        &[(|way| way.method.push('x'), "the ways of methods: there is no record of method ailax")];
    assert_found(part::way, cases);
}

#[test]
fn impossible_caches_are_found() {
    let cases: &[Case<CacheRecord>] = &[
        (
            |cache| cache.l1_hits = 994,
            "caches of unsorted in pass-001/bounce-00/closest: 994 and 7 hits of 1000",
        ),
        (|cache| cache.l2_hits = u64::MAX, "hits of 1000 accesses"),
        (|cache| (cache.rays, cache.groups) = (500, 8), "500 rays were sampled, of 192"),
        (|cache| cache.groups = 0, "0 groups of 64 rays, 64 each"),
        (|cache| cache.queue.bounce += 5, "bounce 5 of a recording"),
        (|cache| cache.method = format!("{}x", cache.method), "no record of method unsortedx"),
    ];
    assert_found(part::cache, cases);
}

/// A queue that was measured in a complete recording has its record.
#[test]
fn times_of_a_queue_without_a_record_are_found() {
    let (_folder, dump) = sample::in_memory();
    let gone = QueueId { pass: 1, bounce: 0, kind: Kind::Shadow };
    sample::edit_manifest(&dump, |records| {
        records.retain(|record| !matches!(record, Record::Queue(queue) if queue.id == gone));
    });
    assert_said(&problems_in(&dump), "no record of queue pass-001/bounce-00/shadow");
}

/// A replay holds the orders alone: without its source nothing of them can be checked.
#[test]
fn a_replay_without_its_source_is_not_right() {
    let (folder, source) = sample::in_memory();
    let manifest_sha256 = Dump::open(&source).unwrap().manifest_sha256().unwrap();
    let replay = folder.path().join("replay.raydump");
    fs::create_dir(&replay).unwrap();
    let found = || problems_in(&replay);
    sample::empty_replay(&replay, "sample.raydump", manifest_sha256);
    assert_eq!(found(), [""; 0]);
    fs::write(
        source.join("manifest.bin"),
        [&fs::read(source.join("manifest.bin")).unwrap()[..], b"x"].concat(),
    )
    .unwrap();
    assert!(
        found()[0].contains("a replay of sample.raydump, which is not in the same folder"),
        "{:?}",
        found()
    );
    sample::empty_replay(&replay, &"x".repeat(5_000_000), manifest_sha256);
    assert!(found()[0].len() < 500, "{:?}", found()[0].len());
}

/// What a replay reads of its source is checked like its own.
#[test]
fn a_damaged_array_of_the_source_is_found() {
    let (folder, source) = sample::in_memory();
    let manifest_sha256 = Dump::open(&source).unwrap().manifest_sha256().unwrap();
    let replay = folder.path().join("replay.raydump");
    fs::create_dir(&replay).unwrap();
    let name = "sample.raydump".to_owned();
    let mut header = Header { source: Source::Replayed { name, manifest_sha256 }, ..sample::header() };
    header.options.keep.clear();
    fs::copy(source.join("manifest.bin"), replay.join("manifest.bin")).unwrap();
    sample::edit_manifest(&replay, |records| {
        let end = Record::End(End { outcome: Outcome::Complete, image: None, wall_ns: 1 });
        records.retain(|record| matches!(record, Record::Queue(_) | Record::Method(_) | Record::Timing(_)));
        records.insert(0, Record::Header(Box::new(header)));
        records.push(end);
    });
    let check = || problems_in(&replay);
    assert_eq!(check(), [""; 0]);
    let queue = QueueId { pass: 1, bounce: 1, kind: Kind::Closest };
    let rays = Place::Queue(queue, QueueArray::Rays).to_string();
    fs::File::options().write(true).open(source.join(&rays)).unwrap().set_len(200).unwrap();
    let found = check();
    assert!(found[0].contains("rays.npy is 200 bytes long"), "{found:?}");
}

/// Where a name goes, and what is said of it.
type NameCase = (fn(&mut Record) -> Option<&mut String>, &'static str);

/// A 5 MB name is not printed, whatever it is the name of.
#[test]
fn long_names_are_cut() {
    let cases: &[NameCase] = &[
        (|record| part::method(record).map(|method| &mut method.text), "method aila"),
        (|record| part::method(record).map(|method| &mut method.name), "is not the name of a method"),
        (|record| part::timing(record).map(|timing| &mut timing.method), "time of trace"),
        (|record| part::cache(record).map(|cache| &mut cache.method), "caches of xxx"),
        (|record| part::header(record).map(|header| &mut header.options.table_layout), "layout"),
        (
            |record| {
                let methods = &mut part::queue(record)?.methods;
                methods.push(String::new());
                methods.last_mut()
            },
            "is not the name of a method",
        ),
    ];
    let (_folder, dump) = sample::in_memory();
    let manifest = fs::read(dump.join("manifest.bin")).unwrap();
    for (name_of, said) in cases {
        let mut number = 0;
        sample::edit_parts(&dump, *name_of, |name| {
            *name = format!("{}{number}", "x".repeat(500_000));
            number += 1;
        });
        let found = match Dump::open(&dump) {
            Ok(opened) => problems(&opened),
            Err(error) => vec![error.to_string()],
        };
        assert_said(&found, said);
        let longest = found.iter().map(String::len).max().unwrap();
        assert!(longest < 1000, "{said}: {longest} bytes");
        fs::write(dump.join("manifest.bin"), &manifest).unwrap();
    }
}

/// A mapped file that is cut ends the process by a signal.
#[test]
fn a_file_that_shrinks_meanwhile_is_a_sentence() {
    let (_folder, dump) = sample::in_memory();
    let queue = QueueId { pass: 1, bounce: 0, kind: Kind::Closest };
    let file = dump.join(Place::Queue(queue, QueueArray::Rays).to_string());
    let bytes = fs::read(&file).unwrap();
    let (opened, is_done) = (Dump::open(&dump).unwrap(), AtomicBool::new(false));
    std::thread::scope(|scope| {
        scope.spawn(|| {
            while !is_done.load(Ordering::Relaxed) {
                fs::File::options().write(true).open(&file).unwrap().set_len(200).unwrap();
                fs::write(&file, &bytes).unwrap();
            }
        });
        for _ in 0..200 {
            for problem in problems(&opened) {
                assert!(!problem.is_empty());
            }
        }
        is_done.store(true, Ordering::Relaxed);
    });
    assert!(verify(&opened).is_ok());
}

/// What a complete recording lacks, and what nobody said was kept.
#[test]
fn what_was_kept_is_there() {
    let (_folder, dump) = sample::in_memory();
    let manifest = fs::read(dump.join("manifest.bin")).unwrap();
    let without = |is_gone: &dyn Fn(&Record) -> bool| {
        sample::edit_manifest(&dump, |records| records.retain(|record| !is_gone(record)));
        let found = problems_in(&dump);
        fs::write(dump.join("manifest.bin"), &manifest).unwrap();
        found
    };
    let words = sample::header().options.keep;
    for word in words.iter().filter(|word| *word != "caches") {
        let is_of_word =
            |record: &Record| matches!(record, Record::Array(array) if array.place.kept_with() == word);
        assert_said(&without(&is_of_word), &format!("but {word} were kept by the header"));
    }
    let is_cache = |record: &Record| matches!(record, Record::Cache(_));
    assert_said(&without(&is_cache), "there are no caches of unsorted");
    let is_timing = |record: &Record| matches!(record, Record::Timing(_));
    assert_said(&without(&is_timing), "there are no times of unsorted");
    let cases: &[Case<Header>] = &[
        (|header| header.options.keep.clear(), "the header does not say that scene were kept"),
        (|header| header.options.keep.push("rays".into()), "kept arrays name 'rays' twice"),
        (|header| header.options.methods.truncate(1), "method aila is not among the header's"),
        (|header| header.options.methods.push("aila".into()), "methods name 'aila' twice"),
        (|header| header.options.passes = 3, "pass 2 of 3 has no queue, kept: all"),
        (|header| header.options.keep_passes = "measured".into(), "pass 0 of 2 has queues, kept: measured"),
        (
            |header| header.options.two_point_length = 0.5,
            "method aila assumes a length of 0.25, the header says 0.5",
        ),
        (|header| header.options.threads = 0, "it ran on 0 threads"),
        (|header| header.options.trace_kernel = "ray-query".into(), "by ray-query"),
    ];
    assert_found(part::header, cases);
}

/// A second time of the same would hide the first.
#[test]
fn a_time_is_told_once() {
    let (_folder, dump) = sample::in_memory();
    let times = |record: &Record| 1 + usize::from(matches!(record, Record::Timing(_)));
    sample::edit_manifest(&dump, |records| {
        *records = records.iter().flat_map(|record| vec![record.clone(); times(record)]).collect();
    });
    let error = Dump::open(&dump).unwrap_err().to_string();
    assert!(
        error.contains("it describes times of trace by unsorted in pass 1")
            && error.contains("a second time"),
        "{error}"
    );
}

#[test]
fn what_auto_chose_follows_from_its_calibration() {
    let cases: &[Case<DecisionRecord>] = &[
        (|decision| decision.area *= 2.0, "closest: its sample has area"),
        (|decision| decision.area = 0.0, "closest: its sample has area 0, expected"),
        (|decision| decision.choice = None, "None was chosen, by the calibration it is Some(Choice"),
        (
            |decision| decision.queue.bounce = 7,
            "there is no record of what auto chose for pass-001/bounce-01/closest",
        ),
    ];
    assert_found(part::decision, cases);
    let cases: &[Case<CalibrationRecord>] = &[
        (|calibration| calibration.candidates[0].net_low = 0.99, "by the calibration it is None"),
        (|calibration| calibration.candidates[0].choice.key_bits = 7, "7 bits, expected 8 to 64"),
        (|calibration| calibration.candidates[0].choice.method = "nope".into(), "there is no method 'nope'"),
    ];
    assert_found(part::calibration, cases);
    // Both records say something else than what the rays were sorted by.
    let other: fn(&mut Record) = |record| match record {
        Record::Decision(DecisionRecord { choice: Some(choice), .. }) => choice.method = "origin".into(),
        Record::Calibration(calibration) => calibration.candidates[0].choice.method = "origin".into(),
        _ => {}
    };
    assert_found(|record| Some(record), &[(other, "auto/permutation.npy: ")]);
}

/// Nor is one asked for where the queue has rays and no record, as when a recording was ended early.
#[test]
fn a_queue_of_a_calibrated_bounce_needs_no_sample() {
    let (_folder, dump) = sample::in_memory();
    sample::edit_records(&dump, |record| match record {
        Record::Calibration(calibration) => calibration.bounce = 1,
        Record::Decision(decision) => decision.area = 0.0,
        _ => {}
    });
    assert_eq!(problems_in(&dump), [""; 0]);
    sample::edit_manifest(&dump, |records| records.retain(|record| !matches!(record, Record::Queue(_))));
    let found = problems_in(&dump);
    assert!(!found.iter().any(|problem| problem.contains("sample")), "{found:#?}");
}

#[test]
fn what_auto_chose_is_held_against_the_rule_of_its_version() {
    let (_folder, dump) = sample::in_memory();
    sample::edit_parts(&dump, part::calibration, |record| record.candidates[0].net_low = 1.01);
    assert_said(&problems_in(&dump), "by the calibration it is None");
    sample::set_version(&dump, 8);
    assert_eq!(problems_in(&dump), [""; 0]);
}

/// What is looked up for each of many times is not searched for: opening looks at each record once, too.
#[test]
fn many_methods_are_verified_as_fast_as_read() {
    const COUNT: usize = 60_000;
    let (_folder, dump) = sample::in_memory();
    let mut records = sample::records(&dump);
    let method = records.iter_mut().find_map(part::method).unwrap().clone();
    let timing = records.iter_mut().find_map(part::timing).unwrap().clone();
    let names: Vec<String> = (0..COUNT).map(|number| format!("{number:0>100}")).collect();
    let many = names.iter().flat_map(|name| {
        let method = MethodRecord { name: name.clone(), ..method.clone() };
        let timing = TimingRecord { method: name.clone(), stage: Stage::Sort, ..timing.clone() };
        [Record::Method(method), Record::Timing(timing)]
    });
    let id = QueueId { pass: timing.pass, bounce: timing.bounce, kind: timing.kind.unwrap() };
    sample::edit_manifest(&dump, |records| {
        let of_time = records.iter_mut().filter_map(part::queue).find(|queue| queue.id == id);
        of_time.unwrap().methods.extend(names.clone());
        let end = records.pop();
        records.extend(many.chain(end));
    });
    let start = Instant::now();
    let opened = Dump::open(&dump).unwrap();
    let opening = start.elapsed();
    assert!(!problems(&opened).is_empty());
    let verifying = start.elapsed() - opening;
    eprintln!("opened in {opening:?}, verified in {verifying:?}");
    // About 5 times as long, most of it reading layouts; one search of all methods for each takes 120 times.
    assert!(verifying < 12 * opening, "opened in {opening:?}, verified in {verifying:?}");
}
