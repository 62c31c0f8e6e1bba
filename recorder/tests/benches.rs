//! Benchmarks of errors, of frames, of capture and of what is skipped, small, on both backends: what they say must hold.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::collections::BTreeSet;

use clap::ValueEnum;
use formats::bench_result::{BenchResult, Rows};
use formats::key::Method;
use formats::key::method::{CONTROL, UNSORTED};
use formats::metrics::speedup::{Speedup, median};
use recorder::bench::capture::{self, CaptureBench};
use recorder::bench::error::{self, Curve, ErrorBench, ImageSize};
use recorder::bench::growth::{self, GrowthBench, Size};
use recorder::bench::{Runs, render, skip};
use recorder::options::{BackendChoice, DeviceOptions, Keep, RecordOptions};

fn run(backend: BackendChoice) -> RecordOptions {
    RecordOptions {
        width: 32,
        height: 18,
        bounces: 3,
        repeats: 2,
        orders: ["aila", "two-point-adaptive"].map(|name| Method::builtin(name).unwrap()).to_vec().into(),
        device: DeviceOptions { backend, threads: Some(2), ..DeviceOptions::default() },
        ..RecordOptions::base().unwrap()
    }
}

/// What a file of a result would be read as.
fn through_json(result: &BenchResult) -> BenchResult {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bench.json");
    std::fs::write(&path, serde_json::to_string(result).unwrap()).unwrap();
    BenchResult::read(&path).unwrap()
}

#[test]
fn errors_are_those_of_what_was_measured() {
    for backend in [BackendChoice::Cpu, BackendChoice::Gpu] {
        let bench = ErrorBench {
            scenes: vec!["builtin:cornell".into()],
            curves: vec![Curve::Precision, Curve::KeyBits, Curve::Image],
            rays: 500,
            key_bits: vec![8, 32],
            image: ImageSize { width: 16, height: 9, passes: 6, reference_passes: 32 },
            run: run(backend),
        };
        let result = error::run(&bench).unwrap();
        // The reader of JSON may be off in a number's last digit.
        assert_eq!(format!("{:.9?}", through_json(&result)), format!("{result:.9?}"));
        let Rows::Error(rows) = &result.rows else { panic!("errors") };
        assert!(rows.precision.len() >= 8, "two kernels, two triangle tests, two box tests");
        for row in &rows.precision {
            assert!(row.errors.rays > 300 && row.rays_timed == row.errors.rays, "{row:?}");
            assert_eq!(row.samples_ns.len(), 2);
            let wrong = row.errors.missed + row.errors.false_hits + row.errors.wrong_triangles;
            assert!(row.triangle_test != "watertight" || row.box_test != "padded" || wrong == 0, "{row:?}");
            assert!(row.errors.relative.median > 0.0 && row.errors.relative.median < 1e-6, "{row:?}");
        }
        let area = |method: &str, bits| {
            let row = rows.key_bits.iter().find(|row| (row.method.as_str(), row.key_bits) == (method, bits));
            row.unwrap().capsule_area
        };
        // Few rays in a bare box: a fine order is more coherent than pixels, a coarse one need not be.
        assert!(area("aila", 32) < area(UNSORTED, 0), "{:?}", rows.key_bits);
        assert!(area("aila", 8) > 0.0);
        let noise = |method: &str, passes| {
            let row = rows.image.iter().find(|row| (row.method.as_str(), row.passes) == (method, passes));
            row.unwrap().relative_mse
        };
        assert!(noise(UNSORTED, 4) < noise(UNSORTED, 1));
        assert_eq!(noise("aila", 4), noise(UNSORTED, 4), "pictures do not depend on the order");
        for pair in rows.image.windows(4).filter(|rows| rows[0].method == rows[3].method) {
            assert!(pair[3].wall_ns > pair[0].wall_ns, "time goes on: {pair:?}");
        }
        for row in &rows.image {
            assert_eq!(row.speedup.is_some(), row.method != UNSORTED, "{row:?}");
            let interval = row.speedup.and_then(|speedup| speedup.interval);
            assert_eq!(interval.is_some(), row.method != UNSORTED && row.passes >= 6, "a pass is a round");
        }
    }
}

#[test]
fn a_table_learns_what_a_constant_cannot() {
    let bench = ErrorBench {
        scenes: vec!["builtin:cornell".into()],
        curves: vec![Curve::Estimator],
        rays: 500,
        key_bits: vec![32],
        image: ImageSize { width: 16, height: 9, passes: 1, reference_passes: 1 },
        run: run(BackendChoice::Cpu),
    };
    let Rows::Error(rows) = error::run(&bench).unwrap().rows else { panic!("errors") };
    let error = |method: &str, bits, pass| {
        let is_it = |row: &&formats::bench_result::error::EstimatorRow| {
            (row.table_method.as_str(), row.table_bits, row.pass) == (method, bits, pass)
                && row.kind == formats::ray::Kind::Closest
        };
        rows.estimator.iter().find(is_it).unwrap()
    };
    let (first, last) = (error("aila", 12, 1), error("aila", 12, 8));
    assert!(last.error.mean_absolute < first.error.mean_absolute);
    assert!(last.error.mean_absolute < error("constant", 0, 8).error.mean_absolute);
    assert!(last.cells_touched > first.cells_touched && last.cells_touched <= 1 << 12);
    assert_eq!((last.key_ns.len(), last.accumulate_ns.len()), (2, 2));
    assert!(first.key_ns.is_empty(), "costs are those of the last pass");
}

#[test]
fn frames_are_measured_end_to_end() {
    for backend in [BackendChoice::Cpu, BackendChoice::Gpu] {
        let methods = ["aila", "two-point-real", "two-point-adaptive"];
        let methods = methods.map(|name| Method::builtin(name).unwrap()).to_vec();
        let run = RecordOptions { orders: methods.into(), repeats: 6, passes: 2, ..run(backend) };
        let bench = Runs { scenes: vec!["builtin:cornell".into()], run };
        let result = render::run(&bench).unwrap();
        assert_eq!(format!("{:.9?}", through_json(&result)), format!("{result:.9?}"));
        assert_eq!(result.instrument.as_ref().map(|instrument| instrument.experiments), Some(1));
        let Rows::Render(rows) = &result.rows else { panic!("frames") };
        let orders: Vec<&str> = rows.iter().map(|row| row.method.as_str()).collect();
        let hits = ["hits by material", "hits by triangle", "hits by place"];
        let expected = [&[UNSORTED, CONTROL, "aila", "two-point-adaptive"][..], &hits].concat();
        assert_eq!(orders, expected, "no rays by what is known once they are traced");
        let materials = |method: &str| {
            let row = rows.iter().find(|row| row.method == method).unwrap();
            row.coherence.unwrap().materials
        };
        assert!(materials(hits[0]) < materials(hits[1]) && materials(hits[1]) < materials(UNSORTED));
        assert_eq!(materials(UNSORTED), materials(CONTROL));
        for row in rows {
            let is_sorted = row.method != UNSORTED;
            assert_eq!(row.speedup.and_then(|speedup| speedup.interval).is_some(), is_sorted, "{row:?}");
            assert_eq!([row.frame_ns.len(), row.trace_ns.len(), row.reorder_ns.len()], [6; 3], "{row:?}");
            assert!(row.trace_ns.iter().chain(&row.frame_ns).all(|&ns| ns > 0), "{row:?}");
            assert!(row.reorder_ns.iter().all(|&ns| (ns > 0) == is_sorted), "{row:?}");
            assert!(row.shade_ns().all(|ns| ns > 0), "{row:?}");
        }
    }
}

#[test]
fn what_is_kept_is_written_in_turns_with_nothing_and_leaves_nothing_behind() {
    for backend in [BackendChoice::Cpu, BackendChoice::Gpu] {
        let folder = tempfile::tempdir().unwrap();
        let run = RecordOptions {
            repeats: 6,
            keep: Keep::parse("rays,hits,keys,permutations,lengths,scene,image").unwrap(),
            ..run(backend)
        };
        let scenes = vec!["builtin:cornell".into()];
        let result = capture::run(&CaptureBench { scenes, folder: folder.path().into(), run }).unwrap();
        assert_eq!(format!("{:.9?}", through_json(&result)), format!("{result:.9?}"));
        assert_eq!(result.instrument.as_ref().map(|instrument| instrument.experiments), Some(1));
        let Rows::Capture(rows) = &result.rows else { panic!("captured bytes") };
        let [row] = &rows[..] else { panic!("one scene") };
        assert_eq!([row.nothing_ns.len(), row.everything_ns.len(), row.alone_ns.len()], [6; 3], "{row:?}");
        assert!(row.cost.interval.is_some() && row.control.interval.is_some(), "{row:?}");
        // Of each ray at least itself, its path, and a key and a permutation of each method.
        assert!(row.rays > 32 * 18 && row.bytes > row.rays * (32 + 4 + 2 * 8), "{row:?}");
        let larger =
            if median(&row.nothing_ns) < median(&row.alone_ns) { &row.alone_ns } else { &row.nothing_ns };
        assert_eq!(Some(row.cost), Speedup::of(&row.everything_ns, larger), "over the larger of the two");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "nothing is left");
    }
}

#[test]
fn costs_are_measured_over_each_size_and_have_exponents() {
    for backend in [BackendChoice::Cpu, BackendChoice::Gpu] {
        let bench = GrowthBench {
            only: Size::value_variants().to_vec(),
            scene: "builtin:cornell".into(),
            triangles: vec![100, 400, 1600],
            pictures: vec![[16, 9], [32, 18], [64, 36]],
            bounces: vec![1, 2, 3],
            lights: vec![1, 10, 100],
            run: run(backend),
        };
        let result = growth::run(&bench).unwrap();
        assert_eq!(through_json(&result), result);
        let Rows::Growth(rows) = &result.rows else { panic!("growth") };
        let stages = ["generate", "trace", "shade", "key", "sort", "gather", "accumulate"];
        for against in ["triangles", "rays", "bounces", "lights", "threads"] {
            let points = if against == "threads" { 2 } else { 3 };
            for cost in stages.into_iter().chain(["memory to trace"]) {
                let found = rows.iter().find(|row| row.against == against && row.cost == cost);
                if (against, backend) == ("threads", BackendChoice::Gpu) {
                    assert!(found.is_none(), "{found:?}");
                    continue;
                }
                let row = found.unwrap();
                assert_eq!(row.points.len(), points, "{row:?}");
                assert!(row.points.is_sorted_by(|one, other| one.n < other.n), "{row:?}");
                let samples = if row.unit == "ns" { 2 } else { 1 };
                assert!(row.points.iter().all(|point| point.samples.len() == samples), "{row:?}");
                assert!(row.unit == "bytes" || row.verdict().is_some(), "{row:?}");
            }
        }
        let built = rows.iter().find(|row| row.cost == "hierarchy").unwrap();
        assert!(built.points[0].n.abs_diff(100) < 10 && built.points[2].n.abs_diff(1600) < 80, "{built:?}");
        let over_rays = rows.iter().find(|row| row.against == "rays").unwrap();
        let rays: Vec<u64> = over_rays.points.iter().map(|point| point.n).collect();
        assert!(rays[0] > 16 * 9 && rays[1].abs_diff(4 * rays[0]) < rays[0], "{rays:?}");
    }
}

#[test]
fn what_is_skipped_changes_nothing_but_time_and_bytes() {
    for backend in [BackendChoice::Cpu, BackendChoice::Gpu] {
        let bench = Runs { scenes: vec!["builtin:cornell".into()], run: run(backend) };
        let result = skip::run(&bench).unwrap();
        assert_eq!(through_json(&result), result);
        let Rows::Skip(rows) = &result.rows else { panic!("skipped things") };
        for row in rows {
            assert!(row.is_same, "{row:?}");
        }
        let what: BTreeSet<&str> = rows.iter().map(|row| row.what.as_str()).collect();
        let mut expected = vec!["alpha-masks", "textures", "vertex-normals", "all these features"];
        if backend == BackendChoice::Gpu {
            expected.extend(["specular", "sphere-lights", "punctual-lights", "environment"]);
        }
        for name in expected {
            assert!(what.contains(name), "{name} is not among {what:?}");
        }
        assert!(!what.contains("emissive-triangles"), "the box has a lamp");
        let bytes = |name: &str| {
            let row = rows.iter().find(|row| row.what == name).unwrap();
            (row.skipped.bytes, row.done.bytes)
        };
        assert_eq!(bytes("vertex-normals").0, 0);
        assert!(bytes("vertex-normals").1 > 0 && bytes("alpha-masks").1 > 0);
        let (none, all) = bytes("arrays that nobody asked for");
        assert!(none < all);
        let (measured, every_pass) = bytes("arrays of passes that are not measured");
        assert!(all == measured && measured < every_pass);
    }
}
