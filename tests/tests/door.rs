//! The door to the kernels: recordings whose checksums are right and whose values are not, replayed.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::fs;
use std::path::Path;

use formats::length_table::LengthCell;
use formats::manifest::{Header, Record};
use formats::npy::{self, Dtype, MaterialMask};
use formats::ray::{Hit, Ray};
use tempfile::{TempDir, tempdir};
use tests::crafted::{copy, edit_array, edit_records};
use tests::programs::Program;
use tests::recordings::{record, verify};

const QUEUE: &str = "pass-001/bounce-01";

/// What somebody did to a recording, and words of the refusal.
type Case = (&'static str, &'static [&'static str], Box<dyn Fn(&Path)>);

fn rays(kind: &'static str, edit: fn(&mut Vec<Ray>)) -> Box<dyn Fn(&Path)> {
    Box::new(move |path| edit_array(path, &format!("{QUEUE}/{kind}/rays.npy"), edit))
}

fn numbers(array: &'static str, edit: fn(&mut Vec<u32>)) -> Box<dyn Fn(&Path)> {
    Box::new(move |path| edit_array(path, &format!("{QUEUE}/{array}.npy"), edit))
}

fn cells(edit: fn(&mut Vec<LengthCell>)) -> Box<dyn Fn(&Path)> {
    Box::new(move |path| edit_array(path, &format!("{QUEUE}/closest/lengths.npy"), edit))
}

fn header(edit: fn(&mut Header)) -> Box<dyn Fn(&Path)> {
    Box::new(move |path| {
        edit_records(path, |record| {
            if let Record::Header(header) = record {
                edit(header);
            }
        });
    })
}

fn queue_count(change: fn(u64) -> u64) -> Box<dyn Fn(&Path)> {
    Box::new(move |path| {
        edit_records(path, |record| {
            if let Record::Queue(queue) = record {
                queue.rays = change(queue.rays);
            }
        });
    })
}

fn positions(path: &Path) {
    let array = "scene/positions.npy";
    edit_array(path, array, |positions: &mut Vec<[f32; 3]>| positions[1][2] = f32::NAN);
}

fn arrays() -> Vec<Case> {
    vec![
        (
            "origin",
            &["closest/rays.npy", "ray 3", "origin"],
            rays("closest", |rays| rays[3].origin[1] = f32::NAN),
        ),
        ("direction", &["ray 4", "unit vector"], rays("shadow", |rays| rays[4].direction = [0.0; 3])),
        ("t-min", &["ray 5", "t_min"], rays("closest", |rays| rays[5].t_min = f32::INFINITY)),
        ("t-max", &["ray 6", "below its t_min"], rays("shadow", |rays| rays[6].t_max = -1.0)),
        ("fewer-rays", &["shadow/rays.npy", "entries"], rays("shadow", |rays| rays.truncate(rays.len() - 1))),
        ("more-rays", &["closest/rays.npy", "entries"], rays("closest", |rays| rays.push(rays[0]))),
        ("pixels", &["path_ids.npy", "entry 0"], numbers("closest/path_ids", |ids| ids[0] = u32::MAX)),
        ("order", &["path_ids.npy", "ascending"], numbers("closest/path_ids", |ids| ids.swap(1, 2))),
        (
            "fewer-ids",
            &["path_ids.npy", "entries"],
            numbers("shadow/path_ids", |ids| ids.truncate(ids.len() - 1)),
        ),
        ("light", &["lights.npy", "ray 0", "light 1 of 1"], numbers("shadow/lights", |lights| lights[0] = 1)),
        ("far-light", &["light 4294967295"], numbers("shadow/lights", |lights| lights[7] = u32::MAX)),
        (
            "fewer-lights",
            &["lights.npy", "entries"],
            numbers("shadow/lights", |lights| lights.truncate(lights.len() - 1)),
        ),
        (
            "fewer-hits",
            &["hits.npy", "entries"],
            Box::new(|path| {
                edit_array(path, &format!("{QUEUE}/closest/hits.npy"), |hits: &mut Vec<Hit>| {
                    hits.truncate(hits.len() - 1)
                });
            }),
        ),
        (
            "more-distances",
            &["distances.npy", "entries"],
            Box::new(|path| {
                let array = format!("{QUEUE}/shadow/distances.npy");
                edit_array(path, &array, |distances: &mut Vec<f32>| distances.push(1.0));
            }),
        ),
        ("full-cell", &["lengths.npy", "cannot be added"], cells(|cells| cells[0].count = u32::MAX)),
        ("cell", &["lengths.npy", "cell 4000000000"], cells(|cells| cells[0].cell = 4_000_000_000)),
        ("fewer-counted", &["entries, but the queue has"], queue_count(|rays| rays - 1)),
        ("huge-count", &["entries, but the queue has"], queue_count(|_| u64::MAX)),
        (
            "corner",
            &["vertex"],
            Box::new(|path| {
                let array = "scene/triangles.npy";
                edit_array(path, array, |triangles: &mut Vec<[u32; 3]>| triangles[2][1] = u32::MAX);
            }),
        ),
        ("position", &["positions.npy", "vertex 1"], Box::new(positions)),
    ]
}

fn headers() -> Vec<Case> {
    vec![
        ("width", &["0 ×"], header(|header| header.options.width = 0)),
        ("pixels", &["path_ids.npy"], header(|header| header.options.height = 1)),
        ("bounces", &["bounces"], header(|header| header.options.bounces = 0)),
        ("fewer-bounces", &["2 passes and 1 bounce"], header(|header| header.options.bounces = 1)),
        ("fewer-passes", &["1 pass and 3 bounces"], header(|header| header.options.passes = 1)),
        ("passes", &["passes"], header(|header| header.options.passes = u32::MAX)),
        ("repeats", &["repeats"], header(|header| header.options.repeats = 0)),
        ("key-bits", &["bits"], header(|header| header.options.key_bits = 65)),
        ("table-bits", &["bits"], header(|header| header.options.table_bits = 40)),
        ("layout", &["table"], header(|header| header.options.table_layout = "(ex ey ez)*7".into())),
        ("length", &["length"], header(|header| header.options.two_point_length = f32::NAN)),
        ("kernel", &["kernel"], header(|header| header.options.trace_kernel = "magic".into())),
        ("bounds", &["box"], header(|header| header.scene.bounds_min[1] = f32::NAN)),
        ("no-light", &["lights.npy", "of 0"], header(|header| header.lights.clear())),
        ("camera", &["camera"], header(|header| header.camera.eye[0] = f32::INFINITY)),
    ]
}

fn cutoffs(cutoff: f32) -> Box<dyn Fn(&Path)> {
    Box::new(move |path| {
        edit_array(path, "scene/masks.npy", |masks: &mut Vec<MaterialMask>| {
            masks.iter_mut().for_each(|mask| mask.cutoff = cutoff);
        });
    })
}

fn orders() -> Vec<Case> {
    let edited = |array: &str, edit: fn(&mut Vec<u32>)| -> Box<dyn Fn(&Path)> {
        let array = format!("pass-000/bounce-01/closest/mine/{array}.npy");
        Box::new(move |path| edit_array(path, &array, edit))
    };
    let words: [&'static [&'static str]; 2] =
        [&["mine/permutation.npy has", "but the queue has"], &["mine/keys.npy has", "but the queue has"]];
    vec![
        ("fewer-places", words[0], edited("permutation", |places| _ = places.remove(0))),
        ("more-places", words[0], edited("permutation", |places| places.push(places.len() as u32))),
        ("more-keys", words[1], edited("keys", |keys| keys.push(0))),
    ]
}

fn masks() -> Vec<Case> {
    vec![
        ("no-cutoff", &["masks.npy", "material 0 is NaN"], cutoffs(f32::NAN)),
        ("low-cutoff", &["masks.npy", "-0.5"], cutoffs(-0.5)),
        ("high-cutoff", &["masks.npy", "1.01"], cutoffs(1.01)),
        (
            "no-materials",
            &["has a material", "there are 0"],
            Box::new(|path| edit_array(path, "scene/masks.npy", Vec::<MaterialMask>::clear)),
        ),
        (
            "no-texels",
            &["mask-000.npy", "no texels"],
            Box::new(|path| edit_array(path, "scene/mask-000.npy", Vec::<u8>::clear)),
        ),
    ]
}

/// The queues of a recording by themselves, with an order, and what was imported of them as `right`.
fn imported() -> TempDir {
    let folder = recorded("builtin:cornell");
    let (source, queue) =
        (folder.path().join(format!("right.raydump/{QUEUE}/closest/rays.npy")), "queues/bounce-01/closest");
    let order = folder.path().join(queue).join("mine");
    fs::create_dir_all(&order).unwrap();
    fs::copy(&source, folder.path().join(queue).join("rays.npy")).unwrap();
    let [rays] = npy::parse_header(&fs::read(source).unwrap()).unwrap().shape[..] else {
        panic!("rays are a list")
    };
    let reversed: Vec<u32> = (0..rays as u32).rev().collect();
    for array in ["permutation.npy", "keys.npy"] {
        let npy = [&npy::header(Dtype::U4, &[rays]), bytemuck::cast_slice(&reversed)].concat();
        fs::write(order.join(array), npy).unwrap();
    }
    let line = "import --scene builtin:cornell --backend cpu --repeats 1 --methods aila --queues queues --out right --force";
    Program::Recorder.run(folder.path(), line).succeeded();
    folder
}

fn recorded(scene: &str) -> TempDir {
    let folder = tempdir().unwrap();
    record(folder.path(), "right", scene, "--backend cpu --repeats 1 --methods aila");
    folder
}

fn is_refused(folder: &TempDir, cases: &[Case], backends: &[&str]) {
    for (name, words, edit) in cases {
        let path = copy(&folder.path().join("right.raydump"), name);
        edit(&path);
        for backend in backends {
            let line = format!("replay {name}.raydump --out out --backend {backend}");
            let outcome = Program::Recorder.run(folder.path(), &line);
            println!("{name}: {}", outcome.stderr);
            outcome.failed_with(1, words);
            for left in ["out.raydump", "out.raydump.partial"] {
                assert!(!folder.path().join(left).exists(), "{name} left {left}");
            }
        }
        let outcome = Program::Inspector.run(folder.path(), &format!("verify {name}.raydump"));
        outcome.failed_with(1, &["wrong"]);
        fs::remove_dir_all(path).unwrap();
    }
}

#[test]
fn arrays_are_checked_before_any_kernel_runs() {
    is_refused(&recorded("builtin:cornell"), &arrays(), &["cpu", "gpu"]);
}

#[test]
fn headers_are_checked_and_the_command_line_is_not_blamed() {
    is_refused(&recorded("builtin:cornell"), &headers(), &["cpu"]);
}

#[test]
fn orders_of_other_tracers_are_those_of_their_queue() {
    is_refused(&imported(), &orders(), &["cpu", "gpu"]);
}

#[test]
fn masks_are_checked() {
    is_refused(&recorded("builtin:atrium"), &masks(), &["cpu"]);
}

/// A replay finds what is behind a hole; `verify` says that no ray can have been stopped there.
#[test]
fn hits_in_holes_are_found() {
    let folder = recorded("builtin:atrium");
    let path = copy(&folder.path().join("right.raydump"), "holes");
    edit_array(&path, "scene/mask-000.npy", |alphas: &mut Vec<u8>| alphas.fill(0));
    verify(folder.path(), "right");
    let outcome = Program::Inspector.run(folder.path(), "verify holes.raydump");
    assert!(outcome.code == Some(1) && outcome.stdout.contains("mask has a hole"), "{}", outcome.stdout);
}

/// What a replay reads of its source is held against the source's checksums, before and after it is made.
#[test]
fn a_source_that_was_changed_is_named() {
    let folder = recorded("builtin:cornell");
    let replay = "replay right.raydump --backend cpu --repeats 1";
    Program::Recorder.run(folder.path(), &format!("{replay} --out before")).succeeded();
    for array in ["rays", "hits", "path_ids", "lengths"] {
        let file = folder.path().join(format!("right.raydump/{QUEUE}/closest/{array}.npy"));
        let right = fs::read(&file).unwrap();
        let mut wrong = right.clone();
        wrong[200] ^= 0x40;
        fs::write(&file, wrong).unwrap();
        let words = [&format!("{array}.npy")[..], "checksum"];
        Program::Recorder.run(folder.path(), &format!("{replay} --out after")).failed_with(1, &words);
        assert!(!folder.path().join("after.raydump.partial").exists());
        let verified = Program::Inspector.run(folder.path(), "verify before.raydump");
        assert!(verified.code == Some(1) && verified.stdout.contains("its source"), "{}", verified.stdout);
        fs::write(&file, right).unwrap();
    }
    verify(folder.path(), "before");
}

/// A view of rays or surfaces that cannot be drawn does not pass for one of none.
#[test]
fn a_picture_of_what_cannot_be_drawn_is_a_failure() {
    let folder = recorded("builtin:cornell");
    let shot = "--view rays --bounce 0 --kind closest --method aila --set mesh=solid --size 320x240 --out picture.png";
    let draw = |name: &str| Program::Inspector.run(folder.path(), &format!("shot {name}.raydump {shot}"));
    draw("right").succeeded();
    let path = copy(&folder.path().join("right.raydump"), "rays");
    edit_array(&path, "pass-001/bounce-00/closest/rays.npy", |rays: &mut Vec<Ray>| {
        rays[3].origin[1] = f32::NAN;
    });
    draw("rays").failed_with(1, &["rays.npy", "ray 3"]);
    let path = copy(&folder.path().join("right.raydump"), "mesh");
    positions(&path);
    draw("mesh").failed_with(1, &["positions.npy", "vertex 1"]);
}
