//! Recordings whose records are whole and lie: no command panics, aborts, hangs or takes much memory. Checksums
//! of arrays are left as they were, since none of these commands reads them.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::fs;
use std::mem::ManuallyDrop;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use egui_kittest::Harness;
use formats::manifest::scan::scan;
use formats::manifest::{
    ArrayRecord, CacheRecord, End, Header, MethodRecord, QueueId, QueueRecord, Record, TimingRecord,
};
use formats::npy;
use formats::ray::Kind;
use formats::reader::Dump;
use inspector::app::App;
use inspector::panels::PANELS;

#[path = "../../formats/tests/sample/mod.rs"]
mod sample;

/// In the process that does the work: the folder for it.
const FOLDER: &str = "RAYSCOPE_TEST_CRAFTED";

/// How long all of it may take: many times what it does.
const PATIENCE: Duration = Duration::from_secs(240);

/// Most memory that it may take, KiB: a GPU driver's share is not in it, as nothing is drawn.
const MEMORY_KIB: u64 = 1 << 20;

/// A lie, and what it does to the records of a manifest or to the data of an array.
type Lie = (String, Box<dyn Fn(&mut Recording)>);

/// A recording in memory.
#[derive(Clone)]
struct Recording {
    records: Vec<Record>,
    /// The data of the arrays, in the order of their records.
    data: Vec<Vec<u8>>,
}

impl Recording {
    fn read(dump: &Path) -> Self {
        let frames = scan(&dump.join("manifest.bin")).unwrap().frames;
        let mut data = Vec::new();
        for frame in &frames {
            if let Record::Array(array) = &frame.record {
                let file = fs::read(dump.join(array.place.to_string())).unwrap();
                data.push(file[file.len() - array.bytes as usize..].to_vec());
            }
        }
        Self { records: frames.into_iter().map(|frame| frame.record).collect(), data }
    }

    /// Writes it with lengths that agree. Arrays that are as they were are not written again.
    fn write(&mut self, folder: &Path, before: &Self) {
        let mut at = 0;
        for record in &mut self.records {
            let Record::Array(array) = record else { continue };
            let data = &self.data[at];
            let rows = data.len() as u64 / (array.bytes / array.shape[0].max(1)).max(1);
            array.shape[0] = rows;
            array.bytes = data.len() as u64;
            if before.data[at] != *data {
                let file = folder.join(array.place.to_string());
                fs::remove_file(&file).unwrap();
                fs::write(file, [npy::header(array.dtype, &array.shape), data.clone()].concat()).unwrap();
            }
            at += 1;
        }
        sample::write_manifest(folder, &self.records);
    }
}

fn lie(name: impl Into<String>, what: impl Fn(&mut Recording) + 'static) -> Lie {
    (name.into(), Box::new(what))
}

fn of_header(name: impl Into<String>, change: impl Fn(&mut Header) + 'static) -> Lie {
    lie(format!("header: {}", name.into()), move |recording| {
        let Some(Record::Header(header)) = recording.records.first_mut() else { panic!("no header") };
        change(header);
    })
}

macro_rules! of_records {
    ($name:ident, $variant:ident, $record:ty) => {
        fn $name(name: &str, change: impl Fn(&mut $record) + 'static) -> Lie {
            lie(format!("{}: {name}", stringify!($variant)), move |recording| {
                for record in &mut recording.records {
                    if let Record::$variant(record) = record {
                        change(record);
                    }
                }
            })
        }
    };
}
of_records!(of_methods, Method, MethodRecord);
of_records!(of_queues, Queue, QueueRecord);
of_records!(of_timings, Timing, TimingRecord);
of_records!(of_caches, Cache, CacheRecord);
of_records!(of_end, End, End);

/// Every text of a header.
fn name_all(header: &mut Header, name: &str) {
    let Header {
        program_version, options, scene, adapter, self_check, features, time_source, notices, ..
    } = header;
    let texts = [
        program_version,
        &mut options.camera,
        &mut options.table_method,
        &mut options.table_layout,
        &mut options.trace_kernel,
        &mut options.keep_passes,
        &mut scene.name,
        &mut adapter.name,
        &mut adapter.driver,
        &mut adapter.device_type,
        &mut adapter.backend,
        time_source,
    ];
    let lists = [&mut options.keep, &mut features.used, &mut features.skipped, notices];
    let checks =
        self_check.iter_mut().flat_map(|check| [&mut check.name, &mut check.outcome, &mut check.detail]);
    texts.into_iter().chain(lists.into_iter().flatten()).chain(checks).for_each(|text| name.clone_into(text));
}

/// Names that no one expects: none, a very long one, one that a terminal obeys and markup would.
fn names() -> [(&'static str, String); 3] {
    let markup = "\x1b[31m\u{202e}\u{9b}2J\0\n\r\t<b>&\"'\\input{x}%$#_^~, ;\u{ffff}".to_owned();
    [("empty", String::new()), ("long", "x".repeat(1 << 20)), ("markup", markup)]
}

fn of_headers() -> Vec<Lie> {
    let mut lies = Vec::new();
    for (what, name) in names() {
        lies.push(of_header(format!("{what} names"), move |header| name_all(header, &name)));
    }
    type Number = fn(&mut Header) -> &mut u32;
    let numbers: [(&str, Number); 9] = [
        ("width", |header| &mut header.options.width),
        ("height", |header| &mut header.options.height),
        ("bounces", |header| &mut header.options.bounces),
        ("passes", |header| &mut header.options.passes),
        ("repeats", |header| &mut header.options.repeats),
        ("key bits", |header| &mut header.options.key_bits),
        ("table bits", |header| &mut header.options.table_bits),
        ("threads", |header| &mut header.options.threads),
        ("table bits and width", |header| {
            header.options.table_bits = u32::MAX;
            &mut header.options.width
        }),
    ];
    for (name, number) in numbers {
        for value in [0, u32::MAX] {
            lies.push(of_header(format!("{name} {value}"), move |header| *number(header) = value));
        }
    }
    for value in [0.0, f32::NAN, f32::INFINITY] {
        lies.push(of_header(format!("lengths {value}"), move |header| {
            header.options.two_point_length = value
        }));
        lies.push(of_header(format!("bounds {value}"), move |header| header.scene.bounds_max = [value; 3]));
        lies.push(of_header(format!("camera {value}"), move |header| {
            let camera = &mut header.camera;
            (camera.eye, camera.forward, camera.up, camera.right) =
                ([value; 3], [value; 3], [value; 3], [value; 3]);
            camera.yfov_radians = value;
        }));
    }
    lies.push(of_header("counts", |header| {
        (header.scene.triangles, header.scene.vertices) = (u64::MAX, u64::MAX);
    }));
    lies.push(of_header("no lights", |header| header.lights.clear()));
    lies.push(of_header("methods", |header| header.options.methods = vec![String::new(); 3]));
    lies
}

fn of_other_records() -> Vec<Lie> {
    let mut lies = Vec::new();
    for bits in [0, 1, 65, u32::MAX] {
        lies.push(of_methods(&format!("{bits} bits"), move |method| method.key_bits = bits));
    }
    lies.push(of_methods("no layout", |method| method.layout.clear()));
    lies.push(of_methods("a layout of one coordinate", |method| method.layout = vec!["ox".into(); 64]));
    lies.push(of_methods("a long layout", |method| method.layout = vec!["ox".into(); 1000]));
    lies.push(of_methods("an unknown layout", |method| method.layout = vec!["what".into(); 9]));
    lies.push(of_methods("lengths", |method| method.two_point_length = f32::NAN));
    for (what, name) in names() {
        let text = name.clone();
        lies.push(of_methods(&format!("{what} words"), move |method| {
            (method.text, method.base) = (text.clone(), text.clone());
        }));
        let method = name.clone();
        lies.push(of_queues(&format!("{what} methods"), move |queue| queue.methods.push(method.clone())));
        lies.push(of_timings(&format!("{what} methods"), move |timing| timing.method.clone_from(&name)));
    }
    for rays in [0, 1, 1 << 40, u64::MAX] {
        lies.push(of_queues(&format!("{rays} rays"), move |queue| queue.rays = rays));
    }
    lies.push(of_queues("no methods", |queue| queue.methods.clear()));
    lies.push(of_queues("methods twice", |queue| queue.methods.extend(queue.methods.clone())));
    lies.push(of_queues("an unknown method", |queue| queue.methods.push("nobody".into())));
    lies.push(of_queues("mismatches", |queue| queue.mismatches.iter_mut().for_each(|of| of.rays = u64::MAX)));
    lies.push(of_queues("another place", |queue| (queue.id.pass, queue.id.bounce) = (u32::MAX, u32::MAX)));
    for samples in [vec![], vec![0], vec![0; 3], vec![u64::MAX; 3], vec![1; 10_000]] {
        let name = format!("{} samples of {:?}", samples.len(), samples.first());
        lies.push(of_timings(&name, move |timing| timing.samples_ns.clone_from(&samples)));
    }
    lies.push(of_timings("another pass", |timing| timing.pass = u32::MAX));
    lies.push(of_timings("another kind", |timing| timing.kind = None));
    for (accesses, hits) in [(0, 0), (1, u64::MAX), (u64::MAX, u64::MAX)] {
        lies.push(of_caches(&format!("{hits} of {accesses}"), move |cache| {
            (cache.accesses, cache.l1_hits, cache.l2_hits) = (accesses, hits, hits);
        }));
    }
    lies.push(of_end("a long time", |end| end.wall_ns = u64::MAX));
    lies
}

/// Of each array: one element less, and elements of nothing but ones or NaN.
fn of_arrays(whole: &Recording) -> Vec<Lie> {
    let arrays = whole.records.iter().filter_map(|record| match record {
        Record::Array(array) => Some(array),
        _ => None,
    });
    let mut lies = Vec::new();
    for (at, ArrayRecord { place, bytes, shape, .. }) in arrays.enumerate() {
        let row = (bytes / shape[0].max(1)) as usize;
        type Change = fn(&mut Vec<u8>, usize);
        let changes: [(&str, Change); 3] = [
            ("one less", |data, row| data.truncate(data.len().saturating_sub(row))),
            ("ones", |data, _| data.fill(0xff)),
            ("NaN", |data, _| {
                data.chunks_exact_mut(4).for_each(|word| word.copy_from_slice(&f32::NAN.to_le_bytes()));
            }),
        ];
        for (what, change) in changes {
            lies.push(lie(format!("{place}: {what}"), move |recording| change(&mut recording.data[at], row)));
        }
    }
    lies
}

/// The files of a recording, linked: to change one, it is removed first.
fn linked(dump: &Path, to: &Path) {
    let _ = fs::remove_dir_all(to);
    for frame in scan(&dump.join("manifest.bin")).unwrap().frames {
        if let Record::Array(array) = frame.record {
            let file = to.join(array.place.to_string());
            fs::create_dir_all(file.parent().unwrap()).unwrap();
            fs::hard_link(dump.join(array.place.to_string()), file).unwrap();
        }
    }
}

/// Has every command look at it but those that need a GPU, and every panel draw what it makes of it.
fn look(dump: &Path, out: &Path) {
    let run = |arguments: &[&str]| {
        let words = ["inspector"].iter().chain(arguments).map(|word| (*word).to_owned());
        inspector::cli::run(words.collect::<Vec<_>>());
    };
    let (dump_text, out_text) = (dump.to_str().unwrap(), out.to_str().unwrap());
    run(&["info", dump_text]);
    run(&["info", dump_text, "--json", "--metrics"]);
    run(&["report", dump_text, "--out", out_text]);
    let method = "two-point-adaptive";
    for (format, kind) in [("csv", "shadow"), ("ply", "closest")] {
        run(&[
            "export", dump_text, "--out", out_text, "--format", format, "--kind", kind, "--method", method,
        ]);
    }
    let dataset = out.join("dataset");
    run(&["export", dump_text, "--out", dataset.to_str().unwrap(), "--format", "parquet", "--force"]);
    let mut app = App::new(&[dump.to_owned()], wgpu::TextureFormat::Rgba8Unorm);
    app.context.selection.order_by("two-point-adaptive");
    let mut panels: Vec<_> =
        PANELS.iter().map(|entry| (entry.make)(&wgpu::TextureFormat::Rgba8Unorm.into())).collect();
    // Where a panic goes through it, its own fault would end the process.
    let mut harness = ManuallyDrop::new(
        Harness::builder()
            .with_size([900.0, 640.0])
            .with_accessibility_check(false)
            .allow_missing_glyphs()
            .build_ui_state(
                |ui, (app, has_gpu): &mut (App, bool)| {
                    if !*has_gpu {
                        return;
                    }
                    for (at, panel) in panels.iter_mut().enumerate() {
                        // One over the other: nothing of it is looked at.
                        let all = egui::UiBuilder::new().id_salt(at).max_rect(ui.max_rect());
                        panel.show(&mut ui.new_child(all), &mut app.context);
                    }
                },
                (app, false),
            ),
    );
    // The least that GPUs can do, which nobody told the harness before its first frame.
    harness.input_mut().max_texture_side = Some(8192);
    harness.state_mut().1 = true;
    for frame in 0..6 {
        harness.step();
        harness.state_mut().0.context.finish();
        if frame == 3 {
            harness.state_mut().0.context.select_ray(Some(0));
        }
    }
    drop(ManuallyDrop::into_inner(harness));
}

fn small(folder: &Path) -> PathBuf {
    let queue = |kind| QueueId { pass: 1, bounce: 1, kind };
    let queues = [queue(Kind::Closest), queue(Kind::Shadow)];
    sample::thinned(&sample::write(folder), "small", &queues, &["unsorted", "aila", "two-point-adaptive"])
}

/// Adds what the thinned sample lacks: caches.
fn completed(mut recording: Recording, whole: &Path) -> Recording {
    let end = recording.records.pop().unwrap();
    for frame in scan(&whole.join("manifest.bin")).unwrap().frames {
        let is_kept = |method: &str| ["unsorted", "aila", "two-point-adaptive"].contains(&method);
        let is_more = matches!(&frame.record, Record::Cache(cache) if cache.queue.bounce == 1 && is_kept(&cache.method));
        recording.records.extend(is_more.then_some(frame.record));
    }
    recording.records.push(end);
    recording
}

/// In a process of its own, so that aborts and hangs are noticed and what is printed is not.
#[test]
fn no_lie_ends_a_command() {
    let folder = tempfile::tempdir().unwrap();
    let log = fs::File::create(folder.path().join("log")).unwrap();
    let mut child = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "look_at_all", "--ignored", "--nocapture"])
        .env(FOLDER, folder.path())
        .stdout(Stdio::null())
        .stderr(log)
        .spawn()
        .unwrap();
    let (start, read) = (Instant::now(), |name: &str| fs::read_to_string(folder.path().join(name)));
    let status = loop {
        match child.try_wait().unwrap() {
            Some(status) => break Some(status),
            None if start.elapsed() > PATIENCE => break None,
            None => std::thread::sleep(Duration::from_millis(20)),
        }
    };
    if status.is_none() {
        child.kill().unwrap();
        child.wait().unwrap();
    }
    let now = read("now").unwrap_or_default();
    assert!(
        status.is_some_and(|status| status.success()),
        "{status:?} at '{now}':\n{}",
        read("log").unwrap()
    );
    assert_eq!(read("panicked").unwrap(), "", "{}", read("log").unwrap());
}

#[test]
#[ignore = "the other test runs it"]
fn look_at_all() {
    let Some(folder) = std::env::var_os(FOLDER).map(PathBuf::from) else { return };
    let dump = small(&folder);
    let mut whole = completed(Recording::read(&dump), &folder.join("sample.raydump"));
    let honest = folder.join("honest.raydump");
    linked(&dump, &honest);
    whole.write(&honest, &whole.clone());
    // Else each lie below would be refused for something that it is not about.
    Dump::open(&honest).unwrap();
    let lies = [of_headers(), of_other_records(), of_arrays(&whole)].into_iter().flatten();
    let (crafted, mut panicked) = (folder.join("crafted.raydump"), Vec::new());
    for (name, tell) in lies {
        fs::write(folder.join("now"), &name).unwrap();
        linked(&dump, &crafted);
        let mut recording = whole.clone();
        tell(&mut recording);
        recording.write(&crafted, &whole);
        let start = Instant::now();
        if catch_unwind(AssertUnwindSafe(|| look(&crafted, &folder.join("out")))).is_err() {
            panicked.push(name.clone());
        }
        eprintln!("{name}: {} ms, {} KiB", start.elapsed().as_millis(), peak_kib());
    }
    fs::write(folder.join("panicked"), panicked.join("\n")).unwrap();
    assert!(peak_kib() < MEMORY_KIB, "{} KiB", peak_kib());
}

/// The most memory that this process had, KiB; 0 where the system does not say.
fn peak_kib() -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    line.and_then(|line| line.split_whitespace().next()?.parse().ok()).unwrap_or(0)
}
