//! What a recording keeps of light: colours of triangles, and what paths carry.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::path::Path;

use formats::manifest::{Place, QueueArray, QueueId, SceneArray};
use formats::ray::{Hit, Kind};
use formats::reader::{Dump, Loaded};
use tempfile::tempdir;
use tests::programs::Program;
use tests::recordings::verify;
use tests::scene_files::masked;

const OPTIONS: &str = "--width 48 --height 32 --passes 1 --repeats 1 --methods unsorted";

fn record(folder: &Path, scene: &str, name: &str, options: &str) -> Dump {
    let line = format!("record {scene} --out {name}.raydump {OPTIONS} {options}");
    Program::Recorder.run(folder, &line).succeeded();
    verify(folder, name);
    Dump::open(&folder.join(format!("{name}.raydump"))).unwrap()
}

/// An array of the closest rays of each bounce.
fn bounces<T: formats::npy::Element>(dump: &Dump, array: QueueArray) -> Vec<Loaded<T>> {
    let closest = dump.manifest().queues.iter().map(|queue| queue.id).filter(|id| id.kind == Kind::Closest);
    closest.map(|id: QueueId| dump.array(&Place::Queue(id, array)).unwrap()).collect()
}

/// In a box whose walls are all matt, a path carries the product of the walls that it met: bit for bit, since
/// directions are drawn as the walls reflect.
#[test]
fn paths_carry_the_product_of_the_surfaces_that_they_met() {
    let folder = tempdir().unwrap();
    let keep = "--bounces 5 --keep rays,hits,throughput";
    let record =
        |backend| record(folder.path(), "builtin:cornell", backend, &format!("{keep} --backend {backend}"));
    let [threads, gpu] = ["cpu", "gpu"].map(record);
    let scene = scenes::load("builtin:cornell").unwrap();
    for dump in [&threads, &gpu] {
        let paths: Vec<Loaded<u32>> = bounces(dump, QueueArray::PathIds);
        let hits: Vec<Loaded<Hit>> = bounces(dump, QueueArray::Hits);
        let carried: Vec<Loaded<[f32; 3]>> = bounces(dump, QueueArray::Throughput);
        assert_eq!(carried.len(), 5);
        assert!(carried[0].iter().all(|&carried| carried == [1.0; 3]) && carried[0].len() == 48 * 32);
        for bounce in 1..carried.len() {
            assert!(carried[bounce].len() > 100, "bounce {bounce} has {} rays", carried[bounce].len());
            for (path, &found) in paths[bounce].iter().zip(carried[bounce].iter()) {
                let before = paths[bounce - 1].binary_search(path).unwrap();
                let triangle = hits[bounce - 1][before].triangle as usize;
                let material = &scene.materials[scene.triangle_materials[triangle] as usize];
                let lit = carried[bounce - 1][before];
                let expected = [0, 1, 2].map(|channel| lit[channel] * material.base_color[channel]);
                assert_eq!(found, expected, "path {path} at bounce {bounce}");
            }
        }
    }
    let [threads, gpu] = [&threads, &gpu].map(|dump| bounces::<[f32; 3]>(dump, QueueArray::Throughput));
    assert!(threads.iter().zip(&gpu).all(|(threads, gpu)| **threads == **gpu), "threads and GPU differ");
}

#[test]
fn what_paths_carry_is_kept_when_it_is_asked_for() {
    let folder = tempdir().unwrap();
    let dump = record(folder.path(), "builtin:cornell", "plain", "--bounces 2 --backend cpu");
    let place = Place::Queue(dump.manifest().queues[0].id, QueueArray::Throughput);
    let reason = dump.array::<[f32; 3]>(&place).unwrap_err().to_string();
    let remedy = "recorded without throughput: `--keep rays,";
    assert!(reason.contains(remedy) && reason.ends_with(",throughput`"), "{reason}");
    let rays = place.to_string().replace("throughput", "rays");
    for what in ["throughput", "image"] {
        let line =
            format!("import --scene builtin:cornell --rays plain.raydump/{rays} --out a --keep {what}");
        let asked = format!("--keep {what}");
        Program::Recorder.run(folder.path(), &line).failed_with(2, &[&asked, "another tracer"]);
    }
}

/// The front triangle's texture has one colour, and holes of it; the other one is white.
#[test]
fn triangles_have_the_colour_of_their_texture() {
    let folder = tempdir().unwrap();
    std::fs::write(folder.path().join("masked.glb"), masked()).unwrap();
    let dump = record(folder.path(), "masked.glb", "masked", "--bounces 1 --backend cpu");
    let colours = Place::Scene(SceneArray::Colours);
    assert_eq!(*dump.array::<[u8; 3]>(&colours).unwrap(), [[200, 180, 160], [255; 3]]);
    // A replay has those of its source.
    Program::Recorder
        .run(folder.path(), "replay masked.raydump --out again.raydump --methods aila")
        .succeeded();
    let again = Dump::open(&folder.path().join("again.raydump")).unwrap();
    assert!(again.record(&colours).is_none() && again.has(&colours));
}
