//! `verify` accepts what is right and finds each thing that is wrong.
#![allow(clippy::unwrap_used, reason = "this is test code, also outside test functions")]

mod sample;

use std::fs;
use std::path::Path;

use formats::length_table::LengthCell;
use formats::manifest::{ArrayRecord, MethodArray, Place, QueueArray, QueueId, Record, SceneArray, Source};
use formats::npy;
use formats::ray::{Hit, Kind, Ray};
use formats::reader::Dump;
use formats::verify::{Check, Report, verify};
use sample::part;

const CLOSEST: QueueId = QueueId { pass: 1, bounce: 1, kind: Kind::Closest };
const SHADOW: QueueId = QueueId { pass: 1, bounce: 0, kind: Kind::Shadow };

fn queue(array: QueueArray) -> Place {
    Place::Queue(CLOSEST, array)
}

fn shadow(array: QueueArray) -> Place {
    Place::Queue(SHADOW, array)
}

fn method(name: &str, array: MethodArray) -> Place {
    Place::Method(SHADOW, name.to_owned(), array)
}

fn check(path: &Path) -> Report {
    verify(&Dump::open(path).unwrap())
}

/// What the check of this name found.
fn of_check<'a>(report: &'a Report, name: &str) -> &'a Check {
    report.checks.iter().find(|check| check.name == name).unwrap()
}

/// Its problems as one text; empty if there are none.
fn problems(report: &Report, name: &str) -> String {
    of_check(report, name).problems.first.join("\n")
}

/// Changes the data of an array and its checksum, so that only its meaning is wrong.
fn edit_array<T: bytemuck::Pod>(path: &Path, place: &Place, edit: impl FnOnce(&mut [T])) {
    let file = path.join(place.to_string());
    let bytes = fs::read(&file).unwrap();
    let data_offset = npy::parse_header(&bytes).unwrap().data_offset;
    let mut values: Vec<T> = bytemuck::pod_collect_to_vec(&bytes[data_offset..]);
    edit(&mut values);
    let data: &[u8] = bytemuck::cast_slice(&values);
    fs::write(&file, [&bytes[..data_offset], data].concat()).unwrap();
    sample::edit_records(path, |record| match record {
        Record::Array(array) if array.place == *place => array.crc32c = crc32c::crc32c(data),
        _ => {}
    });
}

/// The sample after `edit`, and whether the check `name` then finds `part`.
fn assert_found(name: &str, part: &str, edit: impl FnOnce(&Path)) {
    let (_folder, path) = sample::in_memory();
    edit(&path);
    let report = check(&path);
    assert!(!report.is_ok(), "{name}: expected {part}");
    let found = problems(&report, name);
    assert!(found.contains(part), "{name} found {found:?}, expected {part}");
}

#[test]
fn a_right_dump_is_right_and_everything_was_looked_at() {
    let folder = tempfile::tempdir().unwrap();
    let report = check(&sample::write(folder.path()));
    assert!(report.is_ok(), "{report:#?}");
    for check in &report.checks {
        assert!(check.checked > 0, "{}", check.name);
        // The hierarchy is of another kernel than the sample's.
        assert_eq!(check.not_checked.len(), usize::from(check.name == "work"), "{check:?}");
        assert_eq!(check.differences.count, 0, "{check:?}");
    }
    let checked = |name| of_check(&report, name).checked;
    // 4 queues of each kind, each with its table, and two last states.
    assert_eq!(checked("length tables"), 10);
    assert!(checked("keys") > 2000 && checked("permutations") > 2000 && checked("hits") > 600);
}

#[test]
fn damaged_files_are_found() {
    let flip = |path: &Path| {
        let file = path.join(queue(QueueArray::Work).to_string());
        let mut bytes = fs::read(&file).unwrap();
        *bytes.last_mut().unwrap() ^= 1;
        fs::write(&file, bytes).unwrap();
    };
    assert_found("files", "work.npy: the checksum of the data is", flip);
    assert_found("files", "no record names this file", |path| {
        fs::write(path.join("pass-001/x.npy"), b"").unwrap()
    });
    assert_found("files", "rays.npy", |path| {
        fs::remove_file(path.join(queue(QueueArray::Rays).to_string())).unwrap();
    });
}

/// What is damaged, or in a source that is not there, was kept all the same.
#[test]
fn why_something_was_not_checked_is_said() {
    let not_checked = |path: &Path, name: &str| of_check(&check(path), name).not_checked.clone();
    let (_folder, path) = sample::in_memory();
    let rays = path.join(queue(QueueArray::Rays).to_string());
    fs::OpenOptions::new().write(true).open(rays).unwrap().set_len(2000).unwrap();
    for (name, what) in [("rays", "rays"), ("keys", "the rays"), ("length tables", "its traced lengths")] {
        let said = not_checked(&path, name);
        let damaged = format!("{what} were damaged");
        assert!(!said.is_empty() && said.iter().all(|line| line.contains(&damaged)), "{name}: {said:?}");
    }
    let (_folder, path) = sample::in_memory();
    sample::edit_manifest(&path, |records| {
        let Some(Record::Header(header)) = records.first_mut() else { panic!("no header") };
        header.source = Source::Replayed { name: "gone.raydump".into(), manifest_sha256: [7; 32] };
        records.retain(|record| !matches!(record, Record::Array(ArrayRecord { place: Place::Scene(_), .. })));
    });
    assert_eq!(not_checked(&path, "scene"), ["the scene was in the source, which is missing"]);
}

#[test]
fn wrong_orders_are_found() {
    let permutation = method("two-point-adaptive", MethodArray::Permutation);
    assert_found("permutations", "smaller than the one before", |path| {
        edit_array::<u32>(path, &permutation, |order| order.reverse());
    });
    assert_found("permutations", "at an earlier one", |path| {
        edit_array::<u32>(path, &permutation, |order| order[1] = order[0]);
    });
    assert_found("permutations", "only", |path| {
        edit_array::<u32>(path, &permutation, |order| order[5] = 70_000);
    });
    // 16-bit keys of camera rays, which all start at one point, tie.
    let camera = QueueId { bounce: 0, ..CLOSEST };
    let aila = |array| Place::Method(camera, "aila".into(), array);
    assert_found("permutations", "breaks a tie", |path| {
        let keys = Dump::open(path).unwrap().array::<u32>(&aila(MethodArray::Keys)).unwrap().to_vec();
        edit_array::<u32>(path, &aila(MethodArray::Permutation), |order| {
            let tie =
                (1..order.len()).find(|&i| keys[order[i] as usize] == keys[order[i - 1] as usize]).unwrap();
            order.swap(tie - 1, tie);
        });
    });
}

#[test]
fn wrong_keys_of_every_method_are_found() {
    for name in ["aila", "two-point-adaptive", "mine"] {
        assert_found("keys", &format!("{name}/keys.npy: ray 3 has key"), |path| {
            edit_array::<u32>(path, &method(name, MethodArray::Keys), |keys| keys[3] ^= 1);
        });
    }
    for name in ["two-point", "two-point-real", "light-octahedron"] {
        assert_found("keys", &format!("{name}/keys.npy: ray 3 has key"), |path| {
            edit_array::<u64>(path, &method(name, MethodArray::Keys), |keys| keys[3] ^= 1);
        });
    }
}

#[test]
fn differing_keys_are_counted_where_arithmetic_is_not_ieee() {
    let (_folder, path) = sample::in_memory();
    edit_array::<u64>(&path, &method("two-point", MethodArray::Keys), |keys| {
        keys.iter_mut().for_each(|key| *key ^= 1)
    });
    sample::edit_parts(&path, part::header, |header| header.ieee_arithmetic = false);
    let report = check(&path);
    let keys = of_check(&report, "keys");
    assert_eq!(keys.problems.count, 0);
    assert!(keys.differences.count > 50 && keys.differences.first.len() == 5, "{keys:?}");
}

#[test]
fn wrong_hits_are_found() {
    let first_hit = |hits: &[Hit]| hits.iter().position(|hit| hit.is_hit() && hit.t > 0.5).unwrap();
    let edit = |change: fn(&mut Hit)| {
        move |path: &Path| {
            edit_array::<Hit>(path, &queue(QueueArray::Hits), |hits| change(&mut hits[first_hit(hits)]));
        }
    };
    assert_found("hits", "away from the triangle's point", edit(|hit| hit.t *= 1.01));
    assert_found(
        "hits",
        "away from the triangle's point",
        edit(|hit| hit.triangle = (hit.triangle + 5) % 11),
    );
    assert_found("hits", "does not exist", edit(|hit| hit.triangle = 11));
    assert_found("hits", "barycentric", edit(|hit| hit.u += 1.0));
    assert_found("hits", "outside its t_min", edit(|hit| hit.t = -hit.t));
    assert_found("hits", "misses", edit(|hit| hit.triangle = Hit::NONE));
    assert_found("distances", "is stopped at", |path| {
        edit_array::<f32>(path, &shadow(QueueArray::Distances), |distances| distances[0] = -1.0);
    });
}

#[test]
fn wrong_rays_paths_and_lights_are_found() {
    assert_found("rays", "no unit vector", |path| {
        edit_array::<Ray>(path, &queue(QueueArray::Rays), |rays| rays[7].direction[0] += 0.5);
    });
    assert_found("path indices", "ascending", |path| {
        edit_array::<u32>(path, &queue(QueueArray::PathIds), |ids| ids.swap(3, 4));
    });
    assert_found("path indices", "below 192", |path| {
        edit_array::<u32>(path, &queue(QueueArray::PathIds), |ids| *ids.last_mut().unwrap() = 192);
    });
    assert_found("lights", "light 3 of 3", |path| {
        edit_array::<u32>(path, &shadow(QueueArray::Lights), |lights| lights[2] = 3);
    });
    assert_found("keys", "its light does not exist", |path| {
        edit_array::<u32>(path, &shadow(QueueArray::Lights), |lights| lights[2] = 3);
    });
}

#[test]
fn wrong_tables_are_found() {
    let add = |path: &Path, place: &Place| {
        edit_array::<LengthCell>(path, place, |cells| cells[0].sum += 1);
    };
    assert_found("length tables", "final-lengths.npy: not the table before", |path| {
        add(path, &queue(QueueArray::FinalLengths));
    });
    assert_found("length tables", "bounce-01/closest/lengths.npy: not the table before", |path| {
        add(path, &queue(QueueArray::Lengths));
    });
    assert_found("length tables", "out of order", |path| {
        edit_array::<LengthCell>(path, &queue(QueueArray::Lengths), |cells| cells.swap(0, 1));
    });
    // A hit that moves changes the sums as well.
    assert_found("length tables", "final-lengths.npy", |path| {
        edit_array::<Ray>(path, &queue(QueueArray::Rays), |rays| rays[0].origin[0] += 0.5);
    });
}

#[test]
fn wrong_scenes_and_pictures_are_found() {
    assert_found("scene", "has corners", |path| {
        edit_array::<u32>(path, &Place::Scene(SceneArray::Triangles), |indices| indices[4] = 99);
    });
    assert_found("scene", "leaves the scene's box", |path| {
        edit_array::<f32>(path, &Place::Scene(SceneArray::Positions), |values| values[0] = f32::NAN);
    });
    assert_found("scene", "material 2 of 2", |path| {
        edit_array::<u32>(path, &Place::Scene(SceneArray::Materials), |materials| materials[0] = 2);
    });
    assert_found("throughput", "ray 3 carries [1.0, -0.5, 1.0]", |path| {
        edit_array::<[f32; 3]>(path, &queue(QueueArray::Throughput), |carried| carried[3][1] = -0.5);
    });
    assert_found("throughput", "expected finite", |path| {
        edit_array::<[f32; 3]>(path, &queue(QueueArray::Throughput), |carried| carried[0][2] = f32::NAN);
    });
    assert_found("throughput", "1, 1, 1 of a camera ray", |path| {
        let camera = Place::Queue(QueueId { bounce: 0, ..CLOSEST }, QueueArray::Throughput);
        edit_array::<[f32; 3]>(path, &camera, |carried| carried[0] = [0.5; 3]);
    });
    assert_found("image", "SHA-256", |path| {
        edit_array::<f32>(path, &Place::Image, |values| values[0] += 0.5);
    });
}

/// Recordings of before have no colours, and are complete.
#[test]
fn a_scene_lacks_colours_since_version_8() {
    let (_folder, path) = sample::in_memory();
    let colours = Place::Scene(SceneArray::Colours);
    fs::remove_file(path.join(colours.to_string())).unwrap();
    sample::edit_manifest(&path, |records| {
        records.retain(|record| !matches!(record, Record::Array(array) if array.place == colours));
    });
    for (version, expected) in [(8, "there is no scene/colours.npy"), (7, "")] {
        sample::set_version(&path, version);
        assert_eq!(problems(&check(&path), "kept").split(", but").next(), Some(expected));
    }
}
