//! The way of a ray through a kept hierarchy is the one that the tracer goes, node by node.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::path::Path;

use formats::hierarchy::{Hierarchy, Visit, Way};
use formats::ray::{Kind, Ray, Work};
use formats::reader::Dump;
use formats::traced::{Results, Traced};
use formats::verify::verify;
use recorder::stages::trace::TraceKernel;
use recorder::stages::trace::cpu::CpuTracer;
use tempfile::tempdir;
use tests::crafted::edit_array;
use tests::programs::Program;

/// Triangles that the tracer tests at once.
const BLOCK: u32 = 4;

/// The reads of a tracer: nodes by their index, then `None` for each block of triangles.
fn reads_of_tracer(tracer: &CpuTracer, ray: &Ray, kind: Kind) -> Vec<Option<u64>> {
    let is_node = |address: u64| address < 1 << 40;
    let reads = tracer.trail(ray, kind).reads;
    reads.iter().map(|&(address, bytes)| is_node(address).then(|| address / u64::from(bytes))).collect()
}

/// The same of a way.
fn reads_of_way(way: &Way) -> Vec<Option<u64>> {
    let reads = |visit: &Visit| match visit.node {
        Some(node) => vec![Some(node as u64)],
        None => vec![None; visit.triangles.div_ceil(BLOCK) as usize],
    };
    way.visits.iter().flat_map(reads).collect()
}

fn record(folder: &Path, scene: &str) -> Dump {
    let command = format!(
        "record {scene} --out a.raydump --backend cpu --width 48 --height 32 --bounces 2 --passes 1 --repeats 1 \
         --methods unsorted --keep rays,hits,lengths,scene,work,hierarchy"
    );
    Program::Recorder.run(folder, &command).succeeded();
    Dump::open(&folder.join("a.raydump")).unwrap()
}

#[test]
fn ways_through_the_hierarchy_are_the_trails_of_the_tracer() {
    // With holes, whose hits do not count, and without.
    for name in ["builtin:atrium", "builtin:cornell"] {
        let folder = tempdir().unwrap();
        let dump = record(folder.path(), name);
        let hierarchy = Hierarchy::open(&dump).unwrap();
        let scene = scenes::load(name).unwrap();
        let bvh = TraceKernel::Wide.hierarchy(&scene).unwrap().unwrap();
        let tracer = CpuTracer::new(&scene, &bvh);
        let mut shared = 0;
        for queue in &dump.manifest().queues {
            let traced = Traced::open(&dump, queue.id).unwrap();
            for (index, ray) in traced.rays().iter().enumerate() {
                let way = hierarchy.way(ray, queue.id.kind);
                let trail = reads_of_tracer(&tracer, ray, queue.id.kind);
                assert_eq!(reads_of_way(&way), trail, "{name}, {}, ray {index}", queue.id);
                match traced.results() {
                    Results::Hits(hits) => assert_eq!(way.hit, hits[index]),
                    Results::Distances(distances) => assert_eq!(way.hit.t, distances[index]),
                }
                let [low, high] = hierarchy.bounds(way.visits.last().and_then(|visit| visit.place));
                assert!((0..3).all(|axis| low[axis] < high[axis]));
                shared += trail.len();
            }
        }
        assert!(shared > 10_000, "{name}: {shared} reads");
    }
}

#[test]
fn work_that_is_not_that_of_the_way_is_found() {
    let folder = tempdir().unwrap();
    let dump = record(folder.path(), "builtin:cornell");
    let found = |dump: &Dump| {
        let report = verify(dump);
        let check = report.checks.iter().find(|check| check.name == "work").unwrap();
        (check.checked, check.problems.first.join("\n"))
    };
    let (checked, problems) = found(&dump);
    let rays: u64 = dump.manifest().queues.iter().map(|queue| queue.rays).sum();
    assert_eq!((checked, &*problems), (rays + 1, ""));
    let place = format!("{}/work.npy", dump.manifest().queues[1].id);
    edit_array(dump.root(), &place, |work: &mut Vec<Work>| work[7].nodes += 1);
    let (_, problems) = found(&Dump::open(dump.root()).unwrap());
    assert!(
        problems.contains("ray 7 has ") && problems.contains("its way through the hierarchy"),
        "{problems}"
    );

    // What is no tree is refused before anything walks it.
    for (array, text) in
        [("node_children", "child 0 of node 0 is 0x00000000"), ("leaf_triangles", "does not exist")]
    {
        let folder = tempdir().unwrap();
        let dump = record(folder.path(), "builtin:cornell");
        let value = if array == "node_children" { 0 } else { u32::MAX };
        edit_array(dump.root(), &format!("scene/{array}.npy"), |values: &mut Vec<u32>| values[0] = value);
        let (_, problems) = found(&Dump::open(dump.root()).unwrap());
        assert!(problems.contains(text), "{array}: {problems}");
    }
}
