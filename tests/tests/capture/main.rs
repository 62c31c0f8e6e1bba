//! Queues and orders of other tracers, written by the files of `docs/capture`: imported, verified, drawn, refused.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::Command;

use formats::npy::{self, Dtype};
use serde_json::Value;
use tempfile::{TempDir, tempdir};
use tests::programs::{FAILED, Program, finish, python};
use tests::recordings::verify;
use tests::sources::root;

const IMPORT: &str = "import --scene builtin:cornell --backend cpu --repeats 1 --methods aila";

/// Compiles the small tracer, runs it over Cornell's box, and returns the folder with its `queues`.
fn traced() -> TempDir {
    let folder = tempdir().unwrap();
    let line = "record builtin:cornell --out scene --backend cpu --width 8 --height 8 --bounces 1 --passes 1 \
                --repeats 1 --methods unsorted --keep scene";
    Program::Recorder.run(folder.path(), line).succeeded();
    let source = root().join("tests/tests/capture/tracer.cpp");
    let mut compile = Command::new("c++");
    compile.args(["-std=c++11", "-O1", "-Wall", "-Wextra", "-Werror", "-o", "tracer", "-I"]);
    compile.arg(root().join("docs/capture")).arg(source);
    assert!(
        Command::new("c++").arg("--version").output().is_ok(),
        "there is no C++ compiler named c++; install one (Debian's g++)"
    );
    finish(compile.current_dir(folder.path())).succeeded();
    let mut trace = Command::new(folder.path().join("tracer"));
    finish(trace.args(["scene.raydump/scene", "queues"]).current_dir(folder.path())).succeeded();
    folder
}

fn import(folder: &Path, name: &str) -> Value {
    let line = format!("{IMPORT} --queues queues --out {name} --json");
    Program::Recorder.run(folder, &line).succeeded().json()
}

/// The check of this name in what `verify` said.
fn check<'a>(verified: &'a Value, name: &str) -> &'a Value {
    let checks = verified["checks"].as_array().unwrap();
    checks.iter().find(|check| check["name"] == name).unwrap_or_else(|| panic!("no check {name}: {verified}"))
}

#[test]
fn a_small_tracer_in_cpp_is_imported_verified_replayed_and_drawn() {
    let folder = traced();
    let folder = folder.path();
    let recorded = import(folder, "theirs");
    assert_eq!(recorded["queues"].as_array().unwrap().len(), 3, "{recorded}");
    let verified = Program::Inspector.run(folder, "verify theirs.raydump --json").succeeded().json();
    assert_eq!(check(&verified, "imported hits")["problems"]["count"], 0);
    // Three queues of aila's keys and of those that are claimed; of the others nobody says what they are.
    let rays: u64 =
        recorded["queues"].as_array().unwrap().iter().map(|queue| queue["rays"].as_u64().unwrap()).sum();
    // And of each of the nine arrays of keys how wide it is.
    assert_eq!(check(&verified, "keys")["checked"], 2 * rays + 9);
    assert_eq!(check(&verified, "keys")["not_checked"].as_array().unwrap().len(), 3);
    assert_eq!(check(&verified, "permutations")["checked"], 3 * rays);
    let info = Program::Inspector.run(folder, "info theirs.raydump").succeeded().stdout;
    let lacking = "No net speedup for morton, octants: another tracer made and sorted their keys";
    assert!(info.contains(lacking), "{info}");
    let info = Program::Inspector.run(folder, "info theirs.raydump --details").succeeded().stdout;
    assert!(info.contains("imported hits: passed") && info.contains("morton, octants"), "{info}");
    let json = Program::Inspector.run(folder, "info theirs.raydump --metrics --json").succeeded().json();
    for frame in json["metrics"]["recordings"][0]["frames"].as_array().unwrap() {
        let is_theirs = ["morton", "octants"].contains(&frame["method"].as_str().unwrap());
        let reason = frame["net_speedup"]["missing"].as_str();
        assert_eq!(is_theirs, reason.is_some_and(|reason| reason.contains("came with the rays")), "{frame}");
    }
    carried_along(folder, lacking);
    for line in [
        "plot theirs.raydump --out figures --figure trace-speedup --figure capsule-area",
        "report theirs.raydump --out report.html",
        "shot theirs.raydump --view order --size 320x240 --out order.png",
    ] {
        Program::Inspector.run(folder, line).succeeded();
    }
}

/// A replay, and one of that, has the orders of the import and measures them as they came.
fn carried_along(folder: &Path, lacking: &str) {
    for (source, name) in [("theirs", "again"), ("again", "once-more")] {
        let replay = format!("replay {source}.raydump --out {name} --backend cpu --repeats 1 --json");
        let json = Program::Recorder.run(folder, &replay).succeeded().json();
        assert_eq!(json["options"]["methods"], serde_json::json!(["unsorted", "aila", "morton", "octants"]));
        let stages = |method: &str| -> BTreeSet<String> {
            let timings = json["timings"].as_array().unwrap();
            let of_method = timings.iter().filter(|timing| timing["method"] == method);
            of_method.map(|timing| timing["stage"].as_str().unwrap().to_owned()).collect()
        };
        for method in ["morton", "octants"] {
            assert_eq!(
                stages(method),
                BTreeSet::from(["gather", "scatter", "trace", "trace_indirect"].map(str::to_owned))
            );
            let path = format!("pass-000/bounce-00/closest/{method}/permutation.npy");
            let read = |name: &str| fs::read(folder.join(format!("{name}.raydump")).join(&path)).unwrap();
            assert_eq!(read(name), read("theirs"), "{path}");
        }
        assert!(stages("aila").contains("key"), "{json}");
        verify(folder, name);
        let info = Program::Inspector.run(folder, &format!("info {name}.raydump")).succeeded().stdout;
        assert!(info.contains(lacking), "{info}");
    }
    let bare = format!("{IMPORT} --queues queues --out bare --keep rays,hits,lengths,scene");
    Program::Recorder.run(folder, &bare).succeeded();
    let replay = "replay bare.raydump --out bare-again --backend cpu --repeats 1";
    let said = Program::Recorder.run(folder, replay).succeeded().in_a_line();
    for order in ["morton", "octants"] {
        let left_out =
            format!("the order {order} of another tracer is left out: its permutations were not kept");
        assert!(said.contains(&left_out), "{said}");
    }
    let taken = "replay theirs.raydump --out taken --backend cpu --method morton=ox*8";
    Program::Recorder.run(folder, taken).failed_with(FAILED, &["order 'morton' of another tracer"]);
}

#[test]
fn tiles_are_refused_where_there_is_no_picture() {
    let folder = traced();
    let line = format!("{IMPORT},tiled-octahedron --queues queues --out tiles");
    Program::Recorder.run(folder.path(), &line).failed_with(FAILED, &["'tile' needs a picture", "one row"]);
}

#[test]
fn what_is_wrong_with_foreign_orders_and_hits_is_found() {
    let folder = traced();
    let folder = folder.path();
    let queue = folder.join("queues/bounce-00/closest");
    let edit = |name: &str, at: usize, value: u32| {
        let path = queue.join(name);
        let mut bytes = fs::read(&path).unwrap();
        let start = npy::parse_header(&bytes).unwrap().data_offset + 4 * at;
        bytes[start..start + 4].copy_from_slice(&value.to_le_bytes());
        fs::write(&path, bytes).unwrap();
    };
    // A key that is not of its layout, a ray that stands twice, and a triangle that was not hit.
    edit("morton/keys.npy", 5, 77);
    let second = {
        let bytes = fs::read(queue.join("octants/permutation.npy")).unwrap();
        let start = npy::parse_header(&bytes).unwrap().data_offset + 4;
        u32::from_le_bytes(bytes[start..start + 4].try_into().unwrap())
    };
    edit("octants/permutation.npy", 0, second);
    edit("hits.npy", 4 * 1000 + 1, 3_000_000);
    let line = format!("{IMPORT} --queues queues --out wrong");
    let said = Program::Recorder.run(folder, &line).succeeded().in_a_line();
    assert!(said.contains("imported hits: failed") && said.contains("kept and not measured"), "{said}");
    let outcome = Program::Inspector.run(folder, "verify wrong.raydump --json");
    assert_eq!(outcome.code, Some(FAILED), "{}", outcome.stdout);
    let verified = outcome.json();
    for (name, words) in [
        ("keys", "closest/morton/keys.npy: ray 5 has key 0x4d"),
        ("permutations", "closest/octants/permutation.npy: ray"),
        (
            "imported hits",
            "1 hit what is not there; the first wrong one that was judged is ray 1000 of bounce 0",
        ),
    ] {
        let found = check(&verified, name)["problems"].to_string();
        assert!(found.contains(words), "{name}: {found}");
    }
}

#[test]
fn the_python_file_writes_a_queue() {
    let folder = tempdir().unwrap();
    let script = "
import sys
sys.path.insert(0, sys.argv[1])
sys.dont_write_bytecode = True
import numpy as np
from rayscope_capture import Capture
random = np.random.default_rng(3)
origins = random.uniform(0.1, 0.4, (2000, 3)).astype('<f4')
directions = random.normal(size=(2000, 3))
capture = Capture('queues')
capture.rays(2, 'shadow', origins, directions, t_max=0.01)
capture.path_ids(2, 'shadow', np.arange(2000) * 3)
capture.lights(2, np.zeros(2000))
keys = (origins[:, 1] * 1000).astype('u4')
capture.order(2, 'shadow', 'height', np.argsort(keys, kind='stable'), keys)
";
    let mut write = python();
    let capture = root().join("docs/capture");
    finish(write.arg("-c").arg(script).arg(capture).current_dir(folder.path())).succeeded();
    let recorded = import(folder.path(), "python");
    assert_eq!(recorded["queues"][0]["rays"], 2000, "{recorded}");
    verify(folder.path(), "python");
    let line = "plot python.raydump --out figures --figure trace-speedup";
    Program::Inspector.run(folder.path(), line).succeeded();
}

/// A file of as many rays, all the same.
fn rays(count: usize, x: f32) -> Vec<u8> {
    let mut bytes = npy::header(Dtype::F4, &[count as u64, 6]);
    let ray = [x, 0.2, 0.2, 0.0, 0.0, 1.0f32];
    (0..count).for_each(|_| bytes.extend_from_slice(bytemuck::cast_slice(&ray)));
    bytes
}

#[test]
fn what_rays_may_have_wrong_is_said() {
    let folder = tempdir().unwrap();
    for (queue, count) in [("bounce-00/closest", 5), ("bounce-00/shadow", 4), ("bounce-01/shadow", 3)] {
        let queue = folder.path().join("queues").join(queue);
        fs::create_dir_all(&queue).unwrap();
        fs::write(queue.join("rays.npy"), rays(count, 0.25)).unwrap();
    }
    let line = format!("{IMPORT} --queues queues --out odd");
    let said = Program::Recorder.run(folder.path(), &line).succeeded().in_a_line();
    for words in [
        "7 of 7 shadow rays have no end (t_max is infinite)",
        "bounce 0, shadow: fewer rays than before, of paths 0 to 3",
        "bounce 1, shadow: fewer rays than before, of paths 0 to 2",
        "rays start between (0.25000, 0.20000, 0.20000) and (0.25000, 0.20000, 0.20000); the scene lies between",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
}

#[test]
fn folders_that_cannot_be_taken_are_refused_with_a_sentence() {
    let folder = tempdir().unwrap();
    let words = |values: &[u32]| {
        let mut bytes = npy::header(Dtype::U4, &[values.len() as u64]);
        bytes.extend_from_slice(bytemuck::cast_slice(values));
        bytes
    };
    let text = |text: &str| text.as_bytes().to_vec();
    let queue = "bounce-01/closest";
    let order = "bounce-01/closest/mine/permutation.npy";
    for (name, bytes, expected) in [
        ("bounce-01/closest/rays.npy".to_owned(), None, "each queue has its rays in rays.npy"),
        (format!("{queue}/rays.npy"), Some(rays(3, f32::NAN)), "no number"),
        (format!("{queue}/path_ids.npy"), Some(words(&[0, 1])), "found <u4 [2], expected <u4 [3]"),
        (format!("{queue}/path_ids.npy"), Some(words(&[0, 2, 1])), "ascending indices"),
        (format!("{queue}/path_ids.npy"), Some(words(&[0, 2, u32::MAX])), "path index 4294967295"),
        (order.to_owned(), Some(words(&[0, 1])), "permutation.npy"),
        (format!("{queue}/mine/keys.npy"), Some(words(&[0, 1, 2, 3])), "keys.npy"),
        (format!("{queue}/Mine/permutation.npy"), Some(words(&[0, 1, 2])), "small letters"),
        (format!("{queue}/aila/permutation.npy"), Some(words(&[0, 1, 2])), "a method of ours"),
        ("orders.txt".to_owned(), Some(text("yours = ox @ 32")), "speaks of an order 'yours'"),
        ("orders.txt".to_owned(), Some(text("mine = (ox oq) @ 32")), "unknown coordinate 'oq'"),
        ("orders.txt".to_owned(), Some(text("mine ox 32")), "expected NAME = LAYOUT @ BITS"),
        ("orders.txt".to_owned(), Some(text("mine = ox @ 32")), "no keys.npy"),
        ("bounce-1/closest/rays.npy".to_owned(), Some(rays(3, 0.2)), "found 'bounce-1'"),
        ("bounce-00/camera/rays.npy".to_owned(), Some(rays(3, 0.2)), "expected closest and shadow"),
    ] {
        let queues = folder.path().join("queues");
        if queues.exists() {
            fs::remove_dir_all(&queues).unwrap();
        }
        let write = |name: &str, bytes: &[u8]| {
            let path = queues.join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, bytes).unwrap();
        };
        write("bounce-01/closest/rays.npy", &rays(3, 0.2));
        write(order, &words(&[2, 0, 1]));
        match bytes {
            Some(bytes) => write(&name, &bytes),
            None => fs::remove_file(queues.join(&name)).unwrap(),
        }
        let line = format!("{IMPORT} --queues queues --out bad");
        Program::Recorder.run(folder.path(), &line).failed_with(FAILED, &[expected]);
        assert!(!folder.path().join("bad.raydump.partial").exists(), "{name}");
    }
    for (line, word) in [
        ("--out bad", "--rays"),
        ("--queues queues --rays rays.npy --out bad", "--queues"),
        ("--queues queues --bounce 2 --out bad", "--queues"),
    ] {
        Program::Recorder.run(folder.path(), &format!("{IMPORT} {line}")).failed_with(2, &[word]);
    }
}
