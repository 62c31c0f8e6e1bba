//! Recorded rays measured again, and rays of other programs.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::fs;
use std::path::Path;

use formats::manifest::{Backend, CalibrationRecord, FILE_NAME, MAGIC, Outcome, Record, Source};
use formats::reader::Dump;
use serde_json::Value;
use tempfile::{TempDir, tempdir};
use tests::crafted::{copy, edit_manifest, edit_records};
use tests::programs::{FAILED, Program, USAGE, finish, python};
use tests::recordings::{SMALL, arrays, record, verify};

fn recorded(scene: &str, options: &str) -> TempDir {
    let folder = tempdir().unwrap();
    record(folder.path(), "first", scene, options);
    folder
}

fn run(folder: &Path, line: &str) -> Value {
    Program::Recorder.run(folder, &format!("{line} --json")).succeeded().json()
}

/// Keys and permutations of a recording by path.
fn orders(folder: &Path, name: &str) -> Vec<(String, Vec<u8>)> {
    let found = arrays(&folder.join(name)).into_iter();
    found.filter(|(path, _)| path.ends_with("keys.npy") || path.ends_with("permutation.npy")).collect()
}

fn the_same_settings_give_the_same_orders(backend: &str) {
    let folder = recorded("builtin:cornell", &format!("--backend {backend} --repeats 1"));
    let line = format!("replay first.raydump --out again.raydump --backend {backend}");
    let json = run(folder.path(), &line);
    assert_eq!(json["source"]["how"], "replayed");
    assert_eq!(json["source"]["name"], "first.raydump");
    let (first, again) = (orders(folder.path(), "first.raydump"), orders(folder.path(), "again.raydump"));
    assert!(first.len() > 60, "{}", first.len());
    assert!(first == again, "keys or permutations of the replay on {backend} differ");
    // What does not depend on the methods is not repeated.
    assert_eq!(arrays(&folder.path().join("again.raydump")).len(), again.len());
    let report = Program::Inspector.run(folder.path(), "verify again.raydump --json").succeeded().json();
    let keys = report["checks"].as_array().unwrap().iter().find(|check| check["name"] == "keys").unwrap();
    assert!(keys["checked"].as_u64().unwrap() > 10_000, "{keys}");
}

#[test]
fn the_same_settings_give_the_same_orders_on_threads() {
    the_same_settings_give_the_same_orders("cpu");
}

#[test]
fn the_same_settings_give_the_same_orders_on_the_gpu() {
    the_same_settings_give_the_same_orders("gpu");
}

/// It has a permutation and times, but no key, and depends on nothing but the seed.
#[test]
fn a_random_order_is_measured_where_it_is_named() {
    let folder = recorded("builtin:cornell", "--backend cpu --methods aila,shuffled --repeats 1");
    let of_shuffled = |name: &str| -> Vec<(String, Vec<u8>)> {
        orders(folder.path(), name).into_iter().filter(|(path, _)| path.contains("/shuffled/")).collect()
    };
    let first = of_shuffled("first.raydump");
    let is_permutation = |(path, _): &(String, Vec<u8>)| path.ends_with("/shuffled/permutation.npy");
    assert!(first.len() > 3 && first.iter().all(is_permutation), "{}", first.len());
    for (path, bytes) in &first {
        let last =
            bytes[bytes.len() - 64..].chunks_exact(4).map(|ray| u32::from_le_bytes(ray.try_into().unwrap()));
        assert!(!last.is_sorted(), "{path}");
    }
    for (line, others) in [("", "aila"), ("--methods shuffled --keep permutations", "control")] {
        let line = format!("replay first.raydump --out again.raydump --backend cpu --force {line}");
        let table = Program::Recorder.run(folder.path(), &line).succeeded().stdout;
        assert!(table.contains("shuffled") && table.contains(others), "{table}");
        assert!(first == of_shuffled("again.raydump"), "another order in {line}");
        for name in ["first", "again"] {
            verify(folder.path(), name);
        }
    }
    let info = Program::Inspector.run(folder.path(), "info again.raydump --details").succeeded().stdout;
    assert!(info.contains("unsorted, shuffled"), "{info}");
}

/// It is measured anyway; by name it is listed, with a permutation that leaves every ray in its place.
#[test]
fn the_control_is_a_row_where_it_is_named() {
    let folder = recorded("builtin:cornell", "--backend cpu --methods control --repeats 1");
    for line in ["", "--methods aila,control --keep permutations"] {
        let line = format!("replay first.raydump --out again.raydump --backend cpu --force {line}");
        Program::Recorder.run(folder.path(), &line).succeeded();
        for name in ["first", "again"] {
            let found = orders(folder.path(), &format!("{name}.raydump"));
            let of_control = found.iter().filter(|(path, _)| path.contains("/control/"));
            let mut permutations = 0;
            for (path, bytes) in of_control {
                assert!(path.ends_with("/control/permutation.npy"), "{path}");
                let indices = bytes[bytes.len() - 64..].chunks_exact(4);
                let last: Vec<u32> = indices.map(|ray| u32::from_le_bytes(ray.try_into().unwrap())).collect();
                assert!(last.windows(2).all(|pair| pair[0] + 1 == pair[1]), "{path}: {last:?}");
                permutations += 1;
            }
            assert!(permutations > 3, "{name}: {permutations}");
            verify(folder.path(), name);
        }
    }
    let info = Program::Inspector.run(folder.path(), "info again.raydump --details").succeeded().stdout;
    assert!(info.contains("unsorted, control, aila"), "{info}");
    Program::Recorder
        .run(folder.path(), "record builtin:cornell --out no --methods nothing")
        .failed_with(2, &["there are unsorted control shuffled auto origin"]);
}

/// On the machine that it was made on, a calibration is taken over, and gives the same orders; elsewhere, here by
/// another kernel, there is another one.
#[test]
fn what_auto_chooses_is_repeated_with_its_calibration() {
    for (backend, kernels) in [("cpu", ["wide", "bvh2"]), ("gpu", ["cwbvh", "bvh2"])] {
        let folder = tempdir().unwrap();
        // Camera rays alone are as many as candidates are tried on.
        let size = SMALL.replace("--width 64 --height 36", "--width 128 --height 72");
        let line = format!(
            "record builtin:cornell --out first.raydump --backend {backend} --methods auto --repeats 2"
        );
        Program::Recorder.run(folder.path(), &format!("{line} {size}")).succeeded();
        let records = |name: &str| {
            let dump = Dump::open(&folder.path().join(name)).unwrap();
            (dump.manifest().calibration.clone(), dump.manifest().decisions.clone())
        };
        let (calibration, decisions) = records("first.raydump");
        let is_short = |queue: &&CalibrationRecord| queue.rays < 8192;
        let (short, long): (Vec<_>, Vec<_>) = calibration.iter().partition(is_short);
        assert!(short.iter().all(|queue| queue.candidates.is_empty()), "{short:?}");
        assert!(long.iter().all(|queue| queue.candidates.len() >= 3), "{long:?}");
        assert!(short.len() > 1 && !long.is_empty() && calibration.iter().all(|queue| queue.area > 0.0));
        assert!(decisions.len() > 3 && decisions.len() == calibration.len(), "{decisions:?}");
        for kernel in kernels {
            let line = format!(
                "replay first.raydump --out again.raydump --backend {backend} --trace {kernel} --force --details"
            );
            let table = Program::Recorder.run(folder.path(), &line).succeeded().stdout;
            let of_bounce = table.split("\n\n").find(|part| part.contains(", bounce 1, shadow: "));
            assert!(of_bounce.is_some_and(|part| part.contains("auto:")), "{table}");
            let again = records("again.raydump");
            assert_eq!(again.1.len(), decisions.len());
            if kernel == kernels[0] {
                assert_eq!(again, (calibration.clone(), decisions.clone()));
                assert!(orders(folder.path(), "first.raydump") == orders(folder.path(), "again.raydump"));
            } else {
                assert_ne!(again.0, calibration, "measured anew");
            }
            for name in ["first", "again"] {
                verify(folder.path(), name);
            }
        }
    }
}

/// Others time, try and choose other things.
#[test]
fn a_calibration_of_another_version_is_not_taken_over() {
    let folder = recorded("builtin:cornell", "--backend cpu --methods auto --repeats 1");
    let calibration =
        |name: &str| Dump::open(&folder.path().join(name)).unwrap().manifest().calibration.clone();
    let first = calibration("first.raydump");
    let manifest = folder.path().join("first.raydump").join(FILE_NAME);
    let mut bytes = fs::read(&manifest).unwrap();
    bytes[MAGIC.len()] -= 1;
    fs::write(&manifest, bytes).unwrap();
    run(folder.path(), "replay first.raydump --out again.raydump --backend cpu");
    assert_eq!(calibration("first.raydump"), first);
    assert_ne!(calibration("again.raydump"), first);
}

#[test]
fn alpha_masks_are_replayed() {
    let folder = tempdir().unwrap();
    fs::write(folder.path().join("leaf.glb"), tests::scene_files::masked()).unwrap();
    record(folder.path(), "first", "leaf.glb", "--backend cpu --repeats 1");
    let outcome =
        Program::Recorder.run(folder.path(), "replay first.raydump --out again.raydump --backend cpu");
    let outcome = outcome.succeeded();
    assert!(!outcome.stdout.contains("something else"), "{}", outcome.stdout);
    assert!(orders(folder.path(), "first.raydump") == orders(folder.path(), "again.raydump"));
}

#[test]
fn shares_of_the_origin_are_swept_over_and_drawn() {
    let folder = recorded("builtin:cornell", "--backend cpu --repeats 1 --methods two-point");
    let line = "replay first.raydump --out split.raydump --backend cpu --repeats 1 --methods octahedron,two-point \
        --split 4..28:3";
    run(folder.path(), line);
    verify(folder.path(), "split");
    let info = Program::Inspector.run(folder.path(), "info split.raydump --json").succeeded().json();
    let methods = ["octahedron", "two-point"].into_iter().flat_map(|method| {
        ["4-28", "16-16", "28-4"].map(|split| Value::from(format!("{method}-split-{split}")))
    });
    let expected: Vec<Value> = [Value::from("unsorted")].into_iter().chain(methods).collect();
    assert_eq!(info["options"]["methods"], Value::from(expected));
    let plot = "plot split.raydump --figure origin-bits --out figures";
    Program::Inspector.run(folder.path(), plot).succeeded();
    let drawn = std::fs::read_to_string(folder.path().join("figures/origin-bits.csv")).unwrap();
    assert!(["octahedron", "two-point"].iter().all(|method| drawn.contains(method)), "{drawn}");
    Program::Inspector.run(folder.path(), "report split.raydump --out page").succeeded();
    let page = std::fs::read_to_string(folder.path().join("page/report.html")).unwrap();
    assert!(page.contains("--split 4,16,28"), "the page says how to make it again");
    // The layouts of variants are not those of the method.
    run(folder.path(), "replay split.raydump --out again.raydump --backend cpu --repeats 1");
    let info = Program::Inspector.run(folder.path(), "info again.raydump --json").succeeded().json();
    assert_eq!(info["options"]["methods"], serde_json::json!(["unsorted", "octahedron", "two-point"]));
}

#[test]
fn sweeps_and_other_tables() {
    let folder =
        recorded("builtin:cornell", "--backend cpu --repeats 1 --methods two-point,two-point-adaptive");
    let sweep = "replay first.raydump --out sweep.raydump --backend cpu --repeats 1";
    run(folder.path(), &format!("{sweep} --key-bits 8,40 --two-point-length 0.1..0.3:2"));
    let names = |json: &Value| -> Vec<String> {
        json["options"]["methods"]
            .as_array()
            .unwrap()
            .iter()
            .map(|name| name.as_str().unwrap().to_owned())
            .collect()
    };
    let json = Program::Inspector.run(folder.path(), "info sweep.raydump --json").succeeded().json();
    assert_eq!(
        names(&json),
        [
            "unsorted",
            "two-point-8-bits-length-0-1",
            "two-point-8-bits-length-0-3",
            "two-point-40-bits-length-0-1",
            "two-point-40-bits-length-0-3",
            "two-point-adaptive-8-bits",
            "two-point-adaptive-40-bits",
        ]
    );
    verify(folder.path(), "sweep");
    // A table of other addresses is learnt anew, and kept.
    let line =
        "replay first.raydump --out table.raydump --backend cpu --table-bits 12 --table-method octahedron";
    run(folder.path(), line);
    assert!(arrays(&folder.path().join("table.raydump")).keys().any(|path| path.ends_with("/lengths.npy")));
    verify(folder.path(), "table");
    // A replay of a replay measures the rays of the first recording.
    let json = run(folder.path(), "replay table.raydump --out twice.raydump --backend cpu --trace bvh2");
    assert_eq!(json["source"]["name"], "first.raydump");
    assert_eq!(json["options"]["table_bits"], 12);
    assert_eq!(json["options"]["trace_kernel"], "bvh2");
    // Ray queries that nobody asks for are replayed by threads, too.
    edit_records(&folder.path().join("first.raydump"), |record| {
        if let Record::Header(header) = record {
            header.backend = Backend::Gpu;
            header.options.threads = 0;
            header.options.trace_kernel = "ray-query".to_owned();
        }
    });
    let json = run(folder.path(), "replay first.raydump --out query.raydump --backend cpu");
    assert_eq!(json["options"]["trace_kernel"], "wide");
    let asked = "replay first.raydump --out y --backend cpu --trace ray-query";
    Program::Recorder.run(folder.path(), asked).failed_with(USAGE, &["ray-query needs a GPU"]);
}

#[test]
fn what_cannot_be_replayed_is_refused() {
    let folder = recorded("builtin:cornell", "--backend cpu --repeats 1 --methods aila");
    let fails = |line: &str, code: i32, words: &[&str]| {
        Program::Recorder.run(folder.path(), line).failed_with(code, words);
    };
    fails("replay none.raydump --out y.raydump", FAILED, &["none.raydump"]);
    fails("replay first.raydump --out first.raydump", FAILED, &["would replace or lie in", "another name"]);
    fails("replay first.raydump --out y --key-bits 4", USAGE, &["key-bits", "8", "64"]);
    fails(
        "replay first.raydump --out y --two-point-length 0.1..",
        USAGE,
        &["two-point-length", "0.05..0.4:8"],
    );
    fails("replay first.raydump --out y --methods nope", USAGE, &["nope"]);
    fails("replay first.raydump --out y --keep rays", USAGE, &["rays", "refers to"]);
    fails("replay first.raydump --out y --table-method two-point", USAGE, &["two-point", "aila"]);
    let bare =
        "record builtin:cornell --out bare.raydump --width 32 --height 18 --bounces 1 --passes 1 --repeats 1";
    run(folder.path(), &format!("{bare} --backend cpu --methods aila --keep hits,scene"));
    fails(
        "replay bare.raydump --out y --backend cpu",
        FAILED,
        &["rays.npy", "needs the rays, length tables and scene of a recording: ", "`--keep hits,scene,rays`"],
    );
    run(folder.path(), "replay first.raydump --out again.raydump --backend cpu");
    // The source must be there, and be what it was.
    fs::rename(folder.path().join("first.raydump"), folder.path().join("other.raydump")).unwrap();
    fails("replay again.raydump --out y", FAILED, &["first.raydump", "same folder"]);
    let outcome = Program::Inspector.run(folder.path(), "export again.raydump --format csv --out z");
    outcome.failed_with(FAILED, &["first.raydump"]);
}

/// A recording that names itself or another that names it back is read, and ends nobody's stack.
#[test]
fn recordings_that_name_each_other() {
    let folder = recorded("builtin:cornell", "--backend cpu --repeats 1 --methods aila");
    let at = |name: &str| folder.path().join(name);
    run(folder.path(), "replay first.raydump --out second.raydump --backend cpu");
    run(folder.path(), "replay second.raydump --out third.raydump --backend cpu");
    // As after a plain `mv` of two folders: both are replays of "first.raydump", of which one is itself.
    fs::rename(at("first.raydump"), at("aside.raydump")).unwrap();
    fs::rename(at("second.raydump"), at("first.raydump")).unwrap();
    fs::rename(at("third.raydump"), at("second.raydump")).unwrap();
    edit_records(&at("first.raydump"), |record| {
        if let Record::Header(header) = record
            && let Source::Replayed { name, .. } = &mut header.source
        {
            *name = "second.raydump".to_owned();
        }
    });
    for recording in ["first", "second"] {
        Program::Inspector.run(folder.path(), &format!("info {recording}.raydump")).succeeded();
        Program::Inspector.run(folder.path(), &format!("plot {recording}.raydump --out plots")).succeeded();
        for line in ["export --format csv --out csv", "shot --view order --out shot.png"] {
            let (command, rest) = line.split_once(' ').unwrap();
            let outcome =
                Program::Inspector.run(folder.path(), &format!("{command} {recording}.raydump {rest}"));
            assert!(outcome.code.is_some_and(|code| code <= 1), "{outcome:?}");
        }
        let line = format!("replay {recording}.raydump --out y --backend cpu");
        Program::Recorder.run(folder.path(), &line).failed_with(FAILED, &["same folder"]);
    }
}

/// Any occluder answers a shadow ray, and another kernel may find another one.
#[test]
fn what_another_kernel_finds_is_kept_where_it_differs() {
    let folder =
        recorded("builtin:atrium?triangles=4000", "--backend cpu --repeats 1 --methods two-point-real");
    let line = "replay first.raydump --backend cpu --trace bvh2";
    run(folder.path(), &format!("{line} --out other --methods two-point-real,two-point-adaptive"));
    verify(folder.path(), "other");
    run(folder.path(), &format!("{line} --out table --methods two-point-adaptive --table-bits 12"));
    verify(folder.path(), "table");
    let kept =
        |end: &str| arrays(&folder.path().join("other.raydump")).keys().any(|path| path.ends_with(end));
    assert!(kept("shadow/distances.npy") && !kept("closest/hits.npy") && !kept("rays.npy"));
    // Ended early, a replay does not take its source's tables for its own.
    for ended in ["/lengths.npy", "/final-lengths.npy"] {
        let path = copy(&folder.path().join("table.raydump"), "ended");
        edit_manifest(&path, |records| {
            records.retain(|record| match record {
                Record::Array(array) => !array.place.to_string().ends_with(ended),
                _ => true,
            });
            for record in records {
                if let Record::End(end) = record {
                    end.outcome = Outcome::Recovered;
                }
            }
        });
        for (array, _) in arrays(&path).into_iter().filter(|(array, _)| array.ends_with(ended)) {
            fs::remove_file(path.join(array)).unwrap();
        }
        verify(folder.path(), "ended");
        fs::remove_dir_all(path).unwrap();
    }
}

const SCRIPT: &str = "
import numpy as np
random = np.random.default_rng(7)
origin = random.uniform(-0.5, 0.5, (5000, 3))
direction = random.normal(size=(5000, 3))
np.save('rays.npy', np.hstack([origin, direction]).astype('<f4'))
limits = np.full((5000, 1), 0.01), np.full((5000, 1), 0.4)
np.save('shadow.npy', np.hstack([origin, limits[0], direction, limits[1]]).astype('<f4'))
many = random.uniform(-0.5, 0.5, (70_000, 6))
np.save('many.npy', many.astype('<f4'))
far = origin.copy()
far[:3] += 1000
np.save('far.npy', np.hstack([far, direction]).astype('<f4'))
np.save('fortran.npy', np.asfortranarray(np.hstack([origin, direction]).astype('<f4')))
direction[17] = 0
np.save('zero.npy', np.hstack([origin, direction]).astype('<f4'))
origin[18] = np.nan
np.save('nan.npy', np.hstack([origin, direction]).astype('<f4'))
np.save('double.npy', np.hstack([origin, direction]))
np.save('columns.npy', origin.astype('<f4'))
";

#[test]
fn rays_of_another_program() {
    let folder = tempdir().unwrap();
    finish(python().args(["-c", SCRIPT]).current_dir(folder.path())).succeeded();
    let import = "import --scene builtin:cornell --backend cpu --repeats 1";
    let recorded =
        [("rays", "closest", "closest"), ("shadow", "shadow", "shadow"), ("shadow", "closest", "near")];
    for (rays, ask, kind) in recorded {
        let line = format!("{import} --rays {rays}.npy --kind {ask} --out {kind}.raydump");
        let json = run(folder.path(), &line);
        assert_eq!(json["queues"][0]["rays"], 5000);
        assert_eq!(json["source"]["how"], "imported");
        verify(folder.path(), kind);
        run(
            folder.path(),
            &format!("replay {kind}.raydump --out {kind}-again.raydump --backend cpu --key-bits 16"),
        );
    }
    let line = format!("{import} --rays rays.npy --methods aila --size 100x50 --out picture.raydump");
    let options = &run(folder.path(), &line)["options"];
    assert_eq!([&options["width"], &options["height"]], [100, 50]);
    let line = format!("{import} --rays rays.npy --out bad.raydump --size");
    for (size, code, words) in [
        ("100x49", FAILED, ["5000 paths", "100x49"]),
        ("0x50", USAGE, ["WIDTHxHEIGHT", "640x360"]),
        ("100", USAGE, ["WIDTHxHEIGHT", "640x360"]),
    ] {
        Program::Recorder.run(folder.path(), &format!("{line} {size}")).failed_with(code, &words);
    }
    // More than a picture may be wide: imported rays need none.
    run(folder.path(), &format!("{import} --rays many.npy --out many.raydump --methods aila"));
    let json = run(folder.path(), "replay many.raydump --out many-again.raydump --backend cpu --key-bits 16");
    assert_eq!(json["queues"][0]["rays"], 70_000);
    let json = run(folder.path(), &format!("{import} --rays far.npy --out far.raydump --methods aila"));
    let notice = json["notices"][0].as_str().unwrap();
    assert!(notice.starts_with("3 of 5000 rays start far outside of the scene"), "{notice}");
    let line = "shot many.raydump --view order --size 320x240 --out order.png";
    Program::Inspector.run(folder.path(), line).succeeded();
    let line =
        "plot closest.raydump shadow.raydump --out figures --figure trace-speedup --figure capsule-area";
    Program::Inspector.run(folder.path(), line).succeeded();
    for (rays, words) in [
        ("zero", ["zero.npy", "ray 17"]),
        ("nan", ["nan.npy", "ray 17"]),
        ("double", ["double.npy", ".astype('<f4')"]),
        ("fortran", ["fortran.npy", "ascontiguousarray"]),
        ("columns", ["columns.npy", "(N, 6)"]),
        ("absent", ["absent.npy", "cannot read"]),
    ] {
        let line = format!("{import} --rays {rays}.npy --out bad.raydump");
        Program::Recorder.run(folder.path(), &line).failed_with(FAILED, &words);
        assert!(!folder.path().join("bad.raydump.partial").exists(), "{rays}");
    }
}

#[test]
fn benchmarks_are_read_by_figures() {
    let folder = tempdir().unwrap();
    let save = |name: &str, line: &str| {
        let outcome = Program::Recorder.run(folder.path(), line).succeeded();
        fs::write(folder.path().join(name), outcome.stdout).unwrap();
    };
    save("sort.json", "bench sort --log2-n 0,7,10 --key-bits 8,33 --repeats 2 --backend cpu --json");
    save("gpu.json", "bench sort --log2-n 10 --key-bits 32 --repeats 1 --backend gpu --json");
    let size = "--width 48 --height 27 --bounces 2 --repeats 2";
    save("trace.json", &format!("bench trace builtin:cornell {size} --backend cpu --json"));
    let trace: Value =
        serde_json::from_str(&fs::read_to_string(folder.path().join("trace.json")).unwrap()).unwrap();
    // Two bounces, two kinds, three kernels, two orders.
    assert_eq!(trace["rows"]["rows"].as_array().unwrap().len(), 24, "{trace}");
    Program::Inspector.run(folder.path(), "plot sort.json gpu.json trace.json --out figures").succeeded();
    for name in ["sort-throughput", "trace-rate"] {
        assert!(folder.path().join(format!("figures/{name}.svg")).exists(), "{name}");
    }
    let bad = Program::Recorder.run(folder.path(), "bench sort --key-bits 7");
    bad.failed_with(USAGE, &["key-bits"]);
    // More keys than a GPU counts.
    Program::Recorder.run(folder.path(), "bench sort --log2-n 30").failed_with(USAGE, &["log2-n", "29"]);
}
