//! The analysis of a small recording against brute force, and what it says where arrays are missing.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::path::Path;
use std::process::Command;

use formats::key::method::{CONTROL, UNSORTED};
use formats::manifest::{
    End, MethodArray, Outcome, Place, QueueArray, QueueRecord, Record, Source, Stage, TimingRecord,
};
use formats::metrics::capsule::{Capsule, Segment};
use formats::metrics::speedup::{Verdict, median};
use formats::ray::{Kind, Ray, Work};
use formats::reader::{Dump, Loaded};
use formats::traced::Traced;
use formats::writer::DumpWriter;
use inspector::analysis::{Analysis, AnalysisOptions, Depth, GroupWidth, analyse};

#[path = "../../formats/tests/sample/mod.rs"]
mod sample;

fn analysed(dumps: &[Dump], group_width: GroupWidth, threads: usize) -> Analysis {
    let options = AnalysisOptions { group_width, threads: Some(threads), depth: Depth::Arrays };
    analyse(dumps, &options).unwrap()
}

fn json(analysis: &Analysis) -> String {
    serde_json::to_string(analysis).unwrap()
}

fn assert_close(found: f64, expected: f64, what: &str) {
    assert!((found - expected).abs() <= 1e-9 * expected.abs(), "{what}: {found}, expected {expected}");
}

/// Canonical indices of an order, read without the analysis.
fn order(dump: &Dump, place: impl Fn(MethodArray) -> Place, method: &str, rays: usize) -> Vec<usize> {
    if method == "unsorted" {
        return (0..rays).collect();
    }
    let permutation: Loaded<u32> = dump.array(&place(MethodArray::Permutation)).unwrap();
    permutation.iter().map(|&ray| ray as usize).collect()
}

#[test]
fn coherence_and_lanes_are_those_of_brute_force() {
    let folder = tempfile::tempdir().unwrap();
    let dump = Dump::open(&sample::write(folder.path())).unwrap();
    for width in [GroupWidth::Rays32, GroupWidth::Rays64, GroupWidth::Rays128] {
        let analysis = analysed(std::slice::from_ref(&dump), width, 2);
        let recording = &analysis.recordings[0];
        let mut compared = 0;
        for (queue, record) in recording.queues.iter().zip(&dump.manifest().queues) {
            let traced = Traced::open(&dump, record.id).unwrap();
            let rays: Loaded<Ray> = dump.array(&Place::Queue(record.id, QueueArray::Rays)).unwrap();
            let work: Loaded<Work> = dump.array(&Place::Queue(record.id, QueueArray::Work)).unwrap();
            for found in &queue.orders {
                let place = |array| Place::Method(record.id, found.method.clone(), array);
                let order = order(&dump, place, &found.method, rays.len());
                let (mut area, mut spread) = (0.0, 0.0);
                for group in order.chunks(width.rays()) {
                    let segment = |&ray: &usize| Segment::of(traced.unit(), &rays[ray], traced.length(ray));
                    let segments: Vec<Segment> = group.iter().map(segment).collect();
                    let sum = [0, 1, 2]
                        .map(|k| group.iter().map(|&ray| f64::from(rays[ray].direction[k])).sum::<f64>());
                    area += Capsule::around(&segments).unwrap().area() * group.len() as f64;
                    spread += group.len() as f64 - sum.iter().map(|along| along * along).sum::<f64>().sqrt();
                }
                let coherence = found.coherence.known().unwrap();
                assert_close(coherence.mean_capsule_area, area / rays.len() as f64, &found.method);
                assert_close(coherence.mean_direction_spread, spread / rays.len() as f64, &found.method);
                assert!(coherence.area_quantiles.is_sorted() && coherence.area_quantiles.len() == 101);
                for lanes in found.lanes.known().unwrap() {
                    let work_at = |&ray: &usize| f64::from(work[ray].nodes + work[ray].triangles);
                    let slowest: f64 = order
                        .chunks(lanes.width)
                        .map(|group| group.iter().map(work_at).fold(0.0, f64::max))
                        .sum();
                    let all: f64 = order.iter().map(work_at).sum();
                    assert_close(lanes.utilisation, all / (slowest * lanes.width as f64), &found.method);
                }
                compared += 1;
            }
        }
        assert_eq!(compared, 2 * 6 + 2 * 7 + 1, "orders of the measured pass");
    }
}

#[test]
fn results_do_not_depend_on_threads() {
    let folder = tempfile::tempdir().unwrap();
    let dumps = [Dump::open(&sample::write(folder.path())).unwrap()];
    let one = json(&analysed(&dumps, GroupWidth::Rays64, 1));
    assert_eq!(one, json(&analysed(&dumps, GroupWidth::Rays64, 3)));
}

/// An order that is 5 % faster is not called so beside a control that is off by 11 %.
#[test]
fn what_a_bounce_gains_must_exceed_what_the_control_misses_by() {
    let folder = tempfile::tempdir().unwrap();
    let root = sample::write(folder.path());
    let verdict = || {
        let dump = Dump::open(&root).unwrap();
        let analysis = analyse(std::slice::from_ref(&dump), &AnalysisOptions::default()).unwrap();
        let queue = analysis.recordings[0].measured().find(|queue| queue.bounce == 1).unwrap();
        queue.order("aila").unwrap().trace_speedup.known().unwrap().verdict
    };
    sample::edit_parts(&root, sample::part::timing, |timing| match (timing.method.as_str(), timing.stage) {
        (UNSORTED, Stage::Trace) => timing.samples_ns = vec![10_000; 7],
        ("aila", Stage::Trace) => timing.samples_ns = vec![9_500; 7],
        _ => {}
    });
    assert_eq!(verdict(), Verdict::Faster);
    sample::edit_manifest(&root, |records| {
        let timings = records.iter_mut().filter_map(sample::part::timing);
        let unsorted = timings.filter(|timing| timing.method == UNSORTED && timing.stage == Stage::Trace);
        let control = |timing: &mut TimingRecord| {
            let (method, samples_ns) = (CONTROL.to_owned(), vec![9_000; 7]);
            Record::Timing(TimingRecord { method, samples_ns, ..timing.clone() })
        };
        let controls: Vec<Record> = unsorted.map(control).collect();
        let end = records.len() - 1;
        records.splice(end..end, controls);
    });
    assert_eq!(verdict(), Verdict::WithinControl);
}

#[test]
fn speedups_rates_and_bandwidths_follow_from_the_samples() {
    let folder = tempfile::tempdir().unwrap();
    let dump = Dump::open(&sample::write(folder.path())).unwrap();
    let analysis = analyse(std::slice::from_ref(&dump), &AnalysisOptions::default()).unwrap();
    let queue = analysis.recordings[0].measured().find(|queue| queue.bounce == 1).unwrap();
    let samples = |method: &str, stage: Stage| {
        let of = |timing: &&formats::manifest::TimingRecord| {
            timing.method == method
                && timing.stage == stage
                && timing.bounce == 1
                && timing.kind == Some(queue.kind)
        };
        median(&dump.manifest().timings.iter().find(of).unwrap().samples_ns).unwrap()
    };
    let own = |method: &str| queue.order(method).unwrap();
    let trace = own("aila").trace_speedup.known().unwrap();
    assert_close(trace.ratio, samples("unsorted", Stage::Trace) / samples("aila", Stage::Trace), "trace");
    assert_eq!(trace.verdict, Verdict::Faster);
    assert!(own("unsorted").trace_speedup.reason().is_some());
    assert!(own("two-point-real").net_speedup.reason().unwrap().contains("upper bound"));
    assert!(own("aila").coherence.reason().unwrap().contains("not read"));
    let sort = own("aila").stages.iter().find(|stage| stage.stage == Stage::Sort).unwrap();
    assert_eq!(sort.bytes_per_ray, Some(2 * 20), "16-bit keys");
    let expected = 40.0 * queue.rays as f64 / samples("aila", Stage::Sort) * 1e9;
    assert_close(sort.bytes_per_second.unwrap(), expected, "bandwidth");
    let hits = own("aila").caches.known().unwrap();
    assert_eq!((hits.l1, hits.accesses), (0.7, 1000));
}

#[test]
fn what_was_not_kept_is_said_and_does_not_fail() {
    let folder = tempfile::tempdir().unwrap();
    let path = sample::write(folder.path());
    std::fs::remove_file(path.join("pass-001/bounce-01/closest/hits.npy")).unwrap();
    std::fs::remove_file(path.join("pass-001/bounce-01/shadow/work.npy")).unwrap();
    let analysis = analysed(&[Dump::open(&path).unwrap()], GroupWidth::Rays64, 1);
    let last = analysis.recordings[0].measured().filter(|queue| queue.bounce == 1);
    let [closest, shadow] = last.collect::<Vec<_>>()[..] else { panic!("two kinds") };
    assert!(closest.orders[0].coherence.reason().unwrap().contains("hits.npy"));
    assert!(closest.orders[0].lanes.known().is_some() && closest.table.known().is_some());
    assert!(closest.estimators.reason().unwrap().contains("hits.npy"));
    assert!(shadow.orders[0].lanes.reason().unwrap().contains("work.npy"));
    assert!(shadow.orders[0].coherence.known().is_some());
}

/// A replay without arrays but its permutations: rays and results are its source's, and so is the work if
/// the kernel is the same.
#[test]
fn a_replay_is_analysed_with_the_arrays_of_its_source() {
    let folder = tempfile::tempdir().unwrap();
    let source = Dump::open(&sample::write(folder.path())).unwrap();
    let record = source.manifest().queues.iter().rfind(|queue| queue.id.kind == Kind::Closest).unwrap();
    let mut dumps = vec![Dump::open(source.root()).unwrap()];
    for kernel in ["bvh2", "cwbvh"] {
        let mut header = sample::header();
        let manifest_sha256 = source.manifest_sha256().unwrap();
        header.source = Source::Replayed { name: "sample.raydump".into(), manifest_sha256 };
        header.options.trace_kernel = kernel.into();
        let mut writer = DumpWriter::create(&folder.path().join(kernel), header, false).unwrap();
        writer.record(&Record::Method(source.manifest().methods[0].clone())).unwrap();
        let place = Place::Method(record.id, "aila".into(), MethodArray::Permutation);
        let permutation: Loaded<u32> = source.array(&place).unwrap();
        writer.whole_array(&place, &[record.rays], &permutation[..]).unwrap();
        let methods = vec!["unsorted".to_owned(), "aila".to_owned()];
        let mismatches = Vec::new();
        writer
            .record(&Record::Queue(QueueRecord { id: record.id, rays: record.rays, methods, mismatches }))
            .unwrap();
        let end = End { outcome: Outcome::Complete, image: None, wall_ns: 1 };
        dumps.push(Dump::open(&writer.finish(end).unwrap()).unwrap());
    }
    let analysis = analysed(&dumps, GroupWidth::Rays64, 1);
    let aila = |recording: usize| {
        let queue =
            analysis.recordings[recording].measured().rfind(|queue| queue.kind == Kind::Closest).unwrap();
        queue.order("aila").unwrap()
    };
    assert_eq!(aila(1).coherence, aila(0).coherence);
    assert_eq!((&aila(2).coherence, &aila(1).lanes), (&aila(0).coherence, &aila(0).lanes));
    assert!(aila(2).lanes.reason().unwrap().contains("another kernel"));
    let labels: Vec<&str> = analysis.recordings.iter().map(|recording| recording.label.as_str()).collect();
    assert_eq!(labels, ["open box", "open box (replay bvh2)", "open box (replay cwbvh)"]);
}

/// A permutation whose last place names a ray that does not exist, or one that another place has, is a
/// reason, and neither a panic nor a number.
#[test]
fn a_broken_permutation_is_a_reason() {
    let folder = tempfile::tempdir().unwrap();
    let path = sample::write(folder.path());
    let file = path.join("pass-001/bounce-00/closest/aila/permutation.npy");
    let right = std::fs::read(&file).unwrap();
    let (before, last) = right.split_at(right.len() - 4);
    let other = &before[before.len() - 4..];
    for (last, part) in [(&[0xff; 4][..], "4294967295"), (other, "earlier"), (last, "")] {
        std::fs::write(&file, [before, last].concat()).unwrap();
        let analysis = analysed(&[Dump::open(&path).unwrap()], GroupWidth::Rays64, 1);
        let queue = analysis.recordings[0].measured().next().unwrap();
        let aila = queue.order("aila").unwrap();
        let reason = aila.coherence.reason().unwrap_or_default();
        assert!(reason.contains(part) && reason.is_empty() == part.is_empty(), "{:?}", aila.coherence);
    }
}

#[test]
fn an_unfinished_recording_is_refused_with_a_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let path = sample::write(folder.path());
    let partial = folder.path().join("sample.raydump.partial");
    std::fs::rename(&path, &partial).unwrap();
    let manifest = partial.join("manifest.bin");
    let bytes = std::fs::read(&manifest).unwrap();
    std::fs::write(&manifest, &bytes[..bytes.len() - 1]).unwrap();
    let message =
        analyse(&[Dump::open(&partial).unwrap()], &AnalysisOptions::default()).unwrap_err().to_string();
    assert!(message.contains("not finished") && message.contains("inspector recover"), "{message}");
}

#[test]
fn info_shows_means_and_with_metrics_the_arrays() {
    let folder = tempfile::tempdir().unwrap();
    let path = sample::write(folder.path());
    let info = |path: &Path, options: &[&str]| {
        let inspector = env!("CARGO_BIN_EXE_inspector");
        let output = Command::new(inspector).arg("info").arg(path).args(options).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    let text = info(&path, &[]);
    assert!(text.contains("\nWhole frame: ") && !text.contains("Queues"), "{text}");
    assert!(text.lines().count() <= 25 && text.lines().all(|line| line.chars().count() <= 80), "{text}");
    let text = info(&path, &["--details"]);
    assert!(text.contains("\nWhole frame: ") && !text.contains("capsule area"), "{text}");
    let analysis = analysed(&[Dump::open(&path).unwrap()], GroupWidth::Rays64, 1);
    let mut nets = 0;
    for queue in analysis.recordings[0].measured() {
        let heading =
            format!("Pass {}, bounce {}, {}: {} rays", queue.pass, queue.bounce, queue.kind, queue.rays);
        let rows = text.split("\n\n").find(|part| part.starts_with(&heading)).unwrap();
        assert!(rows.lines().all(|line| line.chars().count() <= 120), "{rows}");
        for order in &queue.orders {
            let Some(net) = order.net_speedup.known() else { continue };
            let row = rows.lines().find(|line| line.starts_with(&format!("{} ", order.method))).unwrap();
            let shown = net.speedup().to_string();
            let remark = matches!(order.method.as_str(), CONTROL | "two-point-real");
            assert_eq!(row.ends_with(&shown), !remark, "{rows}");
            nets += 1;
        }
    }
    assert!(nets > 3, "{nets}");
    let text = info(&path, &["--metrics", "--details", "--threads", "1"]);
    for part in ["capsule area", "direction spread", "table fill", "Pearson", "lanes of 8"] {
        assert!(text.contains(part), "{part}: {text}");
    }
    let text = info(&path, &["--metrics"]);
    assert!(text.lines().count() <= 60 && text.lines().all(|line| line.chars().count() <= 80), "{text}");
    let row = text.lines().rfind(|line| line.starts_with("two-point ")).unwrap();
    let (mut sum, mut rays) = (0.0, 0.0);
    for queue in analysis.recordings[0].queues.iter().filter(|queue| queue.kind == Kind::Shadow) {
        let Some(order) = queue.order("two-point") else { continue };
        sum += order.coherence.known().unwrap().mean_capsule_area * queue.rays as f64;
        rays += queue.rays as f64;
    }
    assert_eq!(row.split_whitespace().nth(5).unwrap(), format!("{:.3}", sum / rays), "{text}");
    let value: serde_json::Value = serde_json::from_str(&info(&path, &["--json"])).unwrap();
    assert!(value.get("metrics").is_none() && value.get("timings").is_some());
    let value: serde_json::Value = serde_json::from_str(&info(&path, &["--json", "--metrics"])).unwrap();
    assert_eq!(value["metrics"]["recordings"][0]["queues"][0]["orders"], serde_json::json!([]));
    assert!(value["metrics"]["summaries"][0]["capsule_area_ratio"].as_f64().is_some());
}
