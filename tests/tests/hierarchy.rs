//! The way of a ray through a kept hierarchy is the one that the tracer goes, node by node.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::path::Path;

use formats::hierarchy::{CHILDREN, Hierarchy, Traversal, Visit};
use formats::manifest::{Place, SceneArray};
use formats::ray::{Kind, Ray, Work};
use formats::reader::{Dump, Loaded};
use formats::traced::{Results, Traced};
use formats::verify::verify;
use glam::DVec3;
use recorder::stages::trace::TraceKernel;
use recorder::stages::trace::cpu::CpuTracer;
use tempfile::tempdir;
use tests::crafted::edit_array;
use tests::programs::Program;

/// Triangles that the tracer tests at once.
const BLOCK: u32 = 4;

/// Something that is read: a node or a block of triangles, by its index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Read {
    Node(u64),
    Block(u64),
}

/// The reads of a tracer, whose blocks lie behind all nodes.
fn reads_of_tracer(tracer: &CpuTracer, ray: &Ray, kind: Kind) -> Vec<Read> {
    const BLOCKS_START: u64 = 1 << 40;
    let read = |(address, bytes): (u64, u32)| match address.checked_sub(BLOCKS_START) {
        None => Read::Node(address / u64::from(bytes)),
        Some(address) => Read::Block(address / u64::from(bytes)),
    };
    tracer.trail(ray, kind).reads.into_iter().map(read).collect()
}

/// Where the blocks of each leaf start, by its place among all children: they lie in the order of the nodes.
fn blocks_of_leaves(dump: &Dump) -> Vec<u64> {
    let children: Loaded<u32> = dump.array(&Place::Scene(SceneArray::NodeChildren)).unwrap();
    let count = |child: &u32| u64::from((child >> 28).div_ceil(BLOCK));
    let starts = children.iter().scan(0, |next, child| Some(std::mem::replace(next, *next + count(child))));
    starts.collect()
}

/// The same of a traversal.
fn reads_of(traversal: &Traversal, blocks: &[u64]) -> Vec<Read> {
    let reads = |visit: &Visit| match visit.node {
        Some(node) => vec![Read::Node(node as u64)],
        None => {
            let first = blocks[visit.place.unwrap()];
            (first..first + u64::from(visit.triangles.div_ceil(BLOCK))).map(Read::Block).collect()
        }
    };
    traversal.visits.iter().flat_map(reads).collect()
}

fn record(folder: &Path, scene: &str) -> Dump {
    let command = format!(
        "record {scene} --out a.raydump --backend cpu --width 48 --height 32 --bounces 2 --passes 1 --repeats 1 \
         --methods unsorted --keep rays,hits,lengths,scene,work,hierarchy"
    );
    Program::Recorder.run(folder, &command).succeeded();
    Dump::open(&folder.join("a.raydump")).unwrap()
}

/// A recording of a scene with its hierarchy, the tracer that goes through it, and where its blocks start.
fn walked(folder: &Path, scene: &str) -> (Dump, Hierarchy, CpuTracer, Vec<u64>) {
    let dump = record(folder, scene);
    let scene = scenes::load(scene).unwrap();
    let (bvh, _) = TraceKernel::Wide.hierarchy(&scene).unwrap().unwrap();
    let (hierarchy, blocks) = (Hierarchy::open(&dump).unwrap(), blocks_of_leaves(&dump));
    (dump, hierarchy, CpuTracer::new(&scene, &bvh), blocks)
}

#[test]
fn ways_through_the_hierarchy_are_the_trails_of_the_tracer() {
    // With holes, whose hits do not count, and without.
    for name in ["builtin:atrium", "builtin:cornell"] {
        let folder = tempdir().unwrap();
        let (dump, hierarchy, tracer, blocks) = walked(folder.path(), name);
        let mut compared = 0;
        for queue in &dump.manifest().queues {
            let traced = Traced::open(&dump, queue.id).unwrap();
            for (index, ray) in traced.rays().iter().enumerate() {
                let traversal = hierarchy.traversal(ray, queue.id.kind);
                let trail = reads_of_tracer(&tracer, ray, queue.id.kind);
                assert_eq!(reads_of(&traversal, &blocks), trail, "{name}, {}, ray {index}", queue.id);
                match traced.results() {
                    Results::Hits(hits) => assert_eq!(traversal.hit, hits[index]),
                    Results::Distances(distances) => assert_eq!(traversal.hit.t, distances[index]),
                }
                let [low, high] = hierarchy.bounds(traversal.visits.last().and_then(|visit| visit.place));
                assert!((0..3).all(|axis| low[axis] < high[axis]));
                compared += trail.len();
            }
        }
        assert!(compared > 5_000, "{name}: {compared} reads");
    }
}

/// Where a ray starts on a plane of a box that it looks into, it enters at zero, which may be written with a minus.
#[test]
fn ways_from_planes_of_boxes_are_those_of_the_tracer() {
    let name = "builtin:atrium";
    let folder = tempdir().unwrap();
    let (dump, hierarchy, tracer, blocks) = walked(folder.path(), name);
    let queue = dump.manifest().queues.iter().find(|queue| queue.id.bounce == 1).unwrap().id;
    let traced = Traced::open(&dump, queue).unwrap();
    for ray in traced.rays().iter().step_by(7) {
        for visit in hierarchy.traversal(ray, queue.kind).visits {
            let [low, high] = hierarchy.bounds(visit.place);
            for axis in 0..3 {
                let mut moved = Ray { t_min: 0.0, ..*ray };
                moved.origin[axis] = if ray.direction[axis] < 0.0 { high[axis] } else { low[axis] };
                let trail = reads_of_tracer(&tracer, &moved, queue.kind);
                assert_eq!(reads_of(&hierarchy.traversal(&moved, queue.kind), &blocks), trail, "{moved:?}");
            }
        }
    }
}

/// A ray that leaves a box about as much before it enters it as far planes are padded by: the last bit decides.
#[test]
fn ways_past_edges_of_boxes_are_those_of_the_tracer() {
    let name = "builtin:cornell";
    let folder = tempdir().unwrap();
    let (_dump, hierarchy, tracer, blocks) = walked(folder.path(), name);
    let boxes: Vec<_> = (0..CHILDREN).map(|place| hierarchy.bounds(Some(place))).collect();
    let boxes: Vec<_> = boxes.into_iter().filter(|[low, _]| low[0].is_finite()).collect();
    let mut random = fastrand::Rng::with_seed(2);
    for _ in 0..1_000 {
        let [low, high] = boxes[random.usize(..boxes.len())].map(|corner| DVec3::from(corner.map(f64::from)));
        let first = random.usize(..3);
        let [enters, leaves, within] = [first, (first + 1) % 3, (first + 2) % 3];
        let mut along = DVec3::from([0; 3].map(|_| random.f64() - 0.5)).normalize();
        along[enters] = along[enters].abs();
        along[leaves] = along[leaves].abs();
        let t = 0.5 + random.f64();
        let late = (-19f64).exp2() + (random.f64() - 0.5) * (-22f64).exp2();
        let mut origin = high - t * along;
        origin[enters] = low[enters] - (1.0 + late) * t * along[enters];
        origin[within] -= random.f64() * (high - low)[within];
        let (origin, direction) = (origin.as_vec3().into(), along.as_vec3().into());
        let ray = Ray { origin, t_min: 0.0, direction, t_max: f32::INFINITY };
        for kind in Kind::ALL {
            let trail = reads_of_tracer(&tracer, &ray, kind);
            assert_eq!(reads_of(&hierarchy.traversal(&ray, kind), &blocks), trail, "{ray:?}");
        }
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
