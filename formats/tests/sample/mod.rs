//! A small dump that is right in every respect, made without a tracer: brute force in f64.
#![allow(clippy::unwrap_used, reason = "this is test code, although not in test functions")]
#![allow(dead_code, unused_imports, reason = "every test file compiles it anew and uses its own share")]

mod edit;

use std::path::{Path, PathBuf};

use formats::auto::{sample, sampled_area};
use formats::key::method::AUTO;
use formats::key::{Encoder, Facts, LightSite, Method, Termination};
use formats::length_table::LengthTable;
use formats::manifest::check::KEEP_WORDS;
use formats::manifest::{
    Adapter, Backend, CacheRecord, CalibrationRecord, CameraPose, Candidate, Check, Choice, DecisionRecord,
    DisturbedRecord, End, Features, Header, ImageDigest, MethodArray, MethodRecord, Mismatches, Options,
    Outcome, Place, QueueArray, QueueId, QueueRecord, Record, SceneArray, SceneSummary, Source, Stage,
    TimingRecord, Way, WayRecord,
};
use formats::npy::{Dtype, MaterialMask};
use formats::ray::{Hit, Kind, Ray, Work};
use formats::unit_space::UnitSpace;
use formats::writer::{DumpWriter, WriteError};
use sha2::{Digest, Sha256};

pub(crate) use edit::{
    edit_manifest, edit_parts, edit_records, empty_replay, frames, part, records, set_version, thinned,
    write_manifest,
};

pub(crate) const WIDTH: u32 = 16;
pub(crate) const HEIGHT: u32 = 12;
pub(crate) const PASSES: u32 = 2;
pub(crate) const BOUNCES: u32 = 2;

/// A box of 4 × 2 × 3 without its ceiling, with a board across it.
pub(crate) fn positions() -> Vec<[f32; 3]> {
    let corner = |i: u32| [(i & 1) as f32 * 4.0, (i >> 1 & 1) as f32 * 2.0, (i >> 2) as f32 * 3.0];
    let mut positions: Vec<_> = (0..8).map(corner).collect();
    positions.extend([[1.0, 0.25, 0.5], [3.0, 0.25, 1.0], [1.5, 1.5, 2.5]]);
    positions
}

pub(crate) const TRIANGLES: [[u32; 3]; 11] = [
    [0, 1, 5],
    [0, 5, 4],
    [0, 2, 3],
    [0, 3, 1],
    [4, 5, 7],
    [4, 7, 6],
    [0, 4, 6],
    [0, 6, 2],
    [1, 3, 7],
    [1, 7, 5],
    [8, 9, 10],
];

fn unit() -> UnitSpace {
    UnitSpace::from_bounds([0.0; 3], [4.0, 2.0, 3.0])
}

fn lights() -> Vec<LightSite> {
    vec![
        LightSite::Placed { centre: unit().point([2.0, 1.75, 1.5]) },
        LightSite::directional([0.0, -1.0, 0.0]),
        LightSite::Environment,
    ]
}

/// Numbers in [0, 1) that look random and are always the same.
fn random(seed: u64) -> f64 {
    let mut z = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(0x5eed);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
}

fn direction(seed: u64) -> [f32; 3] {
    let z = random(seed * 2) * 2.0 - 1.0;
    let angle = random(seed * 2 + 1) * std::f64::consts::TAU;
    let radius = (1.0 - z * z).sqrt();
    [(radius * angle.cos()) as f32, (radius * angle.sin()) as f32, z as f32]
}

/// Möller–Trumbore in f64, every triangle, the nearest.
fn nearest(ray: &Ray) -> Hit {
    let at = |i: u32| positions()[i as usize].map(f64::from);
    let sub = |a: [f64; 3], b: [f64; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let cross = |a: [f64; 3], b: [f64; 3]| {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    };
    let (origin, direction) = (ray.origin.map(f64::from), ray.direction.map(f64::from));
    let mut best = Hit::MISS;
    for (index, corners) in TRIANGLES.iter().enumerate() {
        let [a, b, c] = corners.map(at);
        let (e1, e2) = (sub(b, a), sub(c, a));
        let p = cross(direction, e2);
        let determinant = dot(e1, p);
        let s = sub(origin, a);
        let u = dot(s, p) / determinant;
        let q = cross(s, e1);
        let v = dot(direction, q) / determinant;
        let t = dot(e2, q) / determinant;
        let is_inside = u >= 0.0 && v >= 0.0 && u + v <= 1.0;
        if is_inside && t > f64::from(ray.t_min) && t < f64::from(ray.t_max) && t < f64::from(best.t) {
            best = Hit { t: t as f32, triangle: index as u32, u: u as f32, v: v as f32 };
        }
    }
    best
}

/// A queue with everything that a dump keeps of it.
struct Queue {
    id: QueueId,
    path_ids: Vec<u32>,
    rays: Vec<Ray>,
    hits: Vec<Hit>,
    distances: Vec<f32>,
    lights: Vec<u32>,
}

impl Queue {
    fn empty(id: QueueId) -> Self {
        let (path_ids, lights) = (Vec::new(), Vec::new());
        Self { id, path_ids, rays: Vec::new(), hits: Vec::new(), distances: Vec::new(), lights }
    }

    fn traced_length(&self, ray: usize) -> f32 {
        match self.id.kind {
            Kind::Closest => unit().closest_length(&self.rays[ray], &self.hits[ray]),
            Kind::Shadow => unit().shadow_length(&self.rays[ray], self.distances[ray]),
        }
    }
}

fn closest_queue(pass: u32, bounce: u32, paths: Vec<(u32, [f32; 3])>) -> Queue {
    let seed = |path: u32| u64::from(path) * 100 + u64::from(bounce * 10 + pass);
    let rays: Vec<Ray> = paths
        .iter()
        .map(|&(path, origin)| Ray {
            origin,
            t_min: 1e-4,
            direction: direction(seed(path)),
            t_max: f32::INFINITY,
        })
        .collect();
    let hits = rays.iter().map(nearest).collect();
    let path_ids = paths.into_iter().map(|(path, _)| path).collect();
    let id = QueueId { pass, bounce, kind: Kind::Closest };
    Queue { path_ids, rays, hits, ..Queue::empty(id) }
}

/// Where the hits of a queue are, a little before the surface.
fn hit_points(queue: &Queue) -> Vec<(u32, [f32; 3])> {
    let hits = queue.rays.iter().zip(&queue.hits).zip(&queue.path_ids).filter(|((_, hit), _)| hit.is_hit());
    let before = |ray: &Ray, hit: &Hit| [0, 1, 2].map(|k| ray.origin[k] + hit.t * 0.999 * ray.direction[k]);
    hits.map(|((ray, hit), &path)| (path, before(ray, hit))).collect()
}

fn shadow_queue(pass: u32, bounce: u32, points: &[(u32, [f32; 3])]) -> Queue {
    let mut queue = Queue::empty(QueueId { pass, bounce, kind: Kind::Shadow });
    for &(path, origin) in points {
        let light = (path + pass + bounce) % 3;
        let (direction, t_max) = match light {
            0 => {
                let to = [2.0 - origin[0], 1.75 - origin[1], 1.5 - origin[2]];
                let length = (to[0] * to[0] + to[1] * to[1] + to[2] * to[2]).sqrt();
                (to.map(|along| along / length), length)
            }
            1 => ([0.0, 1.0, 0.0], f32::INFINITY),
            _ => (direction(u64::from(path) * 7 + 3), f32::INFINITY),
        };
        let ray = Ray { origin, t_min: 1e-4, direction, t_max };
        queue.distances.push(nearest(&ray).t);
        queue.rays.push(ray);
        queue.path_ids.push(path);
        queue.lights.push(light);
    }
    queue
}

pub(crate) fn header() -> Header {
    let names = [
        "unsorted",
        "aila",
        "two-point",
        "two-point-adaptive",
        "two-point-real",
        "light-octahedron",
        "mine",
        "auto",
    ];
    Header {
        program_version: "0.1.0".into(),
        options: Options {
            width: WIDTH,
            height: HEIGHT,
            bounces: BOUNCES,
            passes: PASSES,
            repeats: 7,
            seed: 7,
            camera: "middle".into(),
            methods: names.map(str::to_owned).to_vec(),
            key_bits: 32,
            two_point_length: 0.25,
            table_bits: 12,
            table_method: "aila".into(),
            table_layout: "(ox oy oz)*3 (ox oy oz dx dy dz)*9 ox".into(),
            trace_kernel: "bvh2".into(),
            threads: 1,
            keep: KEEP_WORDS.map(str::to_owned).to_vec(),
            keep_passes: "all".into(),
            russian_roulette: false,
        },
        scene: SceneSummary {
            name: "open box".into(),
            content_hash: [7; 32],
            bounds_min: [0.0; 3],
            bounds_max: [4.0, 2.0, 3.0],
            triangles: TRIANGLES.len() as u64,
            vertices: positions().len() as u64,
        },
        camera: CameraPose {
            eye: [2.0, 1.0, 0.25],
            forward: [0.0, 0.0, 1.0],
            right: [-1.0, 0.0, 0.0],
            up: [0.0, 1.0, 0.0],
            yfov_radians: 1.0,
        },
        lights: lights(),
        backend: Backend::Cpu,
        adapter: Adapter {
            name: "a processor".into(),
            driver: String::new(),
            device_type: "cpu".into(),
            backend: "threads".into(),
        },
        limits: vec![("max_storage_buffer_binding_size".into(), 1 << 27)],
        self_check: vec![Check { name: "division".into(), outcome: "passed".into(), detail: "IEEE".into() }],
        ieee_arithmetic: true,
        features: Features { used: vec!["sphere lights".into()], skipped: vec!["alpha masks".into()] },
        time_source: "monotonic clock".into(),
        notices: vec!["there is no camera in the file; one was made".into()],
        source: Source::Traced,
    }
}

fn write_scene(writer: &mut DumpWriter) -> Result<(), WriteError> {
    let positions = positions();
    let (vertices, triangles) = (positions.len() as u64, TRIANGLES.len() as u64);
    let scene = Place::Scene;
    writer.whole_array(&scene(SceneArray::Positions), &[vertices, 3], &positions)?;
    writer.whole_array(&scene(SceneArray::Triangles), &[triangles, 3], &TRIANGLES)?;
    let materials: Vec<u32> = (0..TRIANGLES.len() as u32).map(|i| i / 10).collect();
    writer.whole_array(&scene(SceneArray::Materials), &[triangles], &materials)?;
    let colours: Vec<[u8; 3]> = (0..TRIANGLES.len() as u8).map(|i| [40 + 8 * i, 200 - 8 * i, 90]).collect();
    writer.whole_array(&scene(SceneArray::Colours), &[triangles, 3], &colours)?;
    let uvs: Vec<[f32; 2]> = positions.iter().map(|p| [p[0], p[1]]).collect();
    writer.whole_array(&scene(SceneArray::Uvs), &[vertices, 2], &uvs)?;
    let none = MaterialMask { texture: MaterialMask::NO_TEXTURE, cutoff: 0.0 };
    let masks = [none, MaterialMask { texture: 0, cutoff: 0.5 }];
    writer.whole_array(&scene(SceneArray::Masks), &[2], &masks)?;
    writer.whole_array(&scene(SceneArray::Mask(0)), &[2, 3], &[255u8, 255, 255, 255, 255, 255])?;
    write_hierarchy(writer, &positions)
}

/// One node above leaves of up to eight triangles.
fn write_hierarchy(writer: &mut DumpWriter, positions: &[[f32; 3]]) -> Result<(), WriteError> {
    const NONE: [[f32; 3]; 2] = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
    let (mut boxes, mut children): ([[[f32; 3]; 2]; 8], [u32; 8]) = ([NONE; 8], [0; 8]);
    for (slot, triangles) in TRIANGLES.chunks(8).enumerate() {
        children[slot] = ((triangles.len() as u32) << 28) + 8 * slot as u32;
        for corner in triangles.iter().flatten().map(|&vertex| positions[vertex as usize]) {
            for axis in 0..3 {
                boxes[slot][0][axis] = boxes[slot][0][axis].min(corner[axis] - 0.01);
                boxes[slot][1][axis] = boxes[slot][1][axis].max(corner[axis] + 0.01);
            }
        }
    }
    let slots: Vec<u32> = (0..TRIANGLES.len() as u32).collect();
    writer.whole_array(&Place::Scene(SceneArray::NodeBoxes), &[1, 8, 6], boxes.as_flattened())?;
    writer.whole_array(&Place::Scene(SceneArray::NodeChildren), &[1, 8], &[children])?;
    writer.whole_array(&Place::Scene(SceneArray::LeafTriangles), &[slots.len() as u64], &slots)
}

fn write_queue(writer: &mut DumpWriter, queue: &Queue) -> Result<(), WriteError> {
    let place = |array| Place::Queue(queue.id, array);
    let rays = queue.rays.len() as u64;
    writer.whole_array(&place(QueueArray::Rays), &[rays], &queue.rays)?;
    writer.whole_array(&place(QueueArray::PathIds), &[rays], &queue.path_ids)?;
    match queue.id.kind {
        Kind::Closest => {
            writer.whole_array(&place(QueueArray::Hits), &[rays], &queue.hits)?;
            // White walls reflect all, red ones lose half of the rest.
            let carried = vec![[1.0, 0.5f32.powi(queue.id.bounce as i32), 1.0]; queue.rays.len()];
            writer.whole_array(&place(QueueArray::Throughput), &[rays, 3], &carried)?;
        }
        Kind::Shadow => {
            writer.whole_array(&place(QueueArray::Distances), &[rays], &queue.distances)?;
            writer.whole_array(&place(QueueArray::Lights), &[rays], &queue.lights)?;
        }
    }
    let work_of = |ray: u32| Work { nodes: 1 + ray * ray % 7, triangles: TRIANGLES.len() as u32 };
    let work: Vec<Work> = (0..queue.rays.len() as u32).map(work_of).collect();
    writer.whole_array(&place(QueueArray::Work), &[rays], &work)
}

fn cell_of(cells: &Encoder, ray: &Ray) -> u32 {
    cells.encode(ray, Facts::default()) as u32
}

fn write_method(
    writer: &mut DumpWriter,
    queue: &Queue,
    method: &Method,
    key_bits: u32,
    table: &LengthTable,
) -> Result<(), WriteError> {
    let layout = method.layout.expand(header().extent()).unwrap();
    let encoder = Encoder::new(&layout, key_bits, unit(), &lights());
    let cells = header().cell_encoder().unwrap();
    let keys: Vec<u64> = (0..queue.rays.len())
        .map(|i| {
            let ray = &queue.rays[i];
            let length = match method.termination {
                Termination::Unused => 0.0,
                Termination::Fixed => 0.25,
                Termination::Adaptive => table.mean(cell_of(&cells, ray)),
                Termination::Real => queue.traced_length(i),
            };
            let light = queue.lights.get(i).copied().unwrap_or(0);
            encoder.encode(ray, Facts { length, light, path: queue.path_ids[i] })
        })
        .collect();
    write_order(writer, queue.id, &method.name, key_bits, &keys)
}

/// Writes the keys of a queue's rays, and the order by them.
pub(crate) fn write_order(
    writer: &mut DumpWriter,
    queue: QueueId,
    method: &str,
    key_bits: u32,
    keys: &[u64],
) -> Result<(), WriteError> {
    let place = |array| Place::Method(queue, method.to_owned(), array);
    let shape = [keys.len() as u64];
    if key_bits > 32 {
        writer.whole_array(&place(MethodArray::Keys), &shape, keys)?;
    } else {
        let narrow: Vec<u32> = keys.iter().map(|&key| key as u32).collect();
        writer.whole_array(&place(MethodArray::Keys), &shape, &narrow)?;
    }
    // Streamed in odd pieces, as readbacks come.
    let mut array = writer.array(&place(MethodArray::Permutation), Dtype::U4, &shape)?;
    for piece in bytemuck::cast_slice::<u32, u8>(&sorted(keys)).chunks(100) {
        array.write(piece)?;
    }
    array.finish()
}

/// The stable order by these keys.
fn sorted(keys: &[u64]) -> Vec<u32> {
    let mut permutation: Vec<u32> = (0..keys.len() as u32).collect();
    permutation.sort_by_key(|&ray| keys[ray as usize]);
    permutation
}

/// The times of a stage.
pub(crate) fn timing(queue: QueueId, method: &str, stage: Stage, samples_ns: Vec<u64>) -> Record {
    let (QueueId { pass, bounce, kind }, method) = (queue, method.to_owned());
    Record::Timing(TimingRecord { pass, bounce, kind: Some(kind), method, stage, samples_ns })
}

/// The sample's methods with their key bits: narrow, wide, one of a user.
fn methods() -> Vec<(Method, u32)> {
    let builtin = |name| Method::builtin(name).unwrap();
    vec![
        (builtin("aila"), 16),
        (builtin("two-point"), 64),
        (builtin("two-point-adaptive"), 32),
        (builtin("two-point-real"), 33),
        (builtin("light-octahedron"), 64),
        (Method::from_user("mine=(u v)*3 (ox oy oz ex ey ez)*5").unwrap(), 32),
    ]
}

/// Times of a queue and method: made up, but such that some methods pay off and some do not.
fn write_timings(writer: &mut DumpWriter, id: QueueId, method: &str, number: u64) -> Result<(), WriteError> {
    let around = |ns: u64| vec![ns + 20, ns - 10, ns, ns + 5, ns - 5, ns + 10, ns - 20];
    let trace = 10_000 + 3_000 * u64::from(id.bounce) - 700 * number;
    let mut stages = vec![(Stage::Trace, around(trace))];
    if method != "unsorted" {
        stages.push((Stage::Key, vec![500, 700, 600, 550, 650, 580, 620]));
        stages.push((Stage::Sort, around(1_000 + 100 * number)));
        stages.push((Stage::Gather, around(900)));
        stages.push((Stage::Scatter, around(100)));
        stages.push((Stage::TraceIndirect, around(trace + 500 * (number % 3))));
    }
    if method == "two-point-adaptive" {
        stages.push((Stage::Accumulate, around(250)));
    }
    for (stage, samples_ns) in stages {
        writer.record(&timing(id, method, stage, samples_ns))?;
    }
    if method == "unsorted" {
        let (method, stage, samples) = (method.to_owned(), Stage::Trace, vec![1]);
        writer.record(&Record::Disturbed(DisturbedRecord { queue: id, method, stage, samples }))?;
    }
    Ok(())
}

/// The last queue of closest hits, measured in the order of every method that they have; `auto` gives it that of
/// the first.
pub(crate) const QUEUE: QueueId = QueueId { pass: PASSES - 1, bounce: 1, kind: Kind::Closest };

fn write_auto(writer: &mut DumpWriter, queue: &Queue) -> Result<(), WriteError> {
    let (method, key_bits) = methods().remove(0);
    let encoder =
        Encoder::new(&method.layout.expand(header().extent()).unwrap(), key_bits, unit(), &lights());
    let keys: Vec<u64> = queue.rays.iter().map(|ray| encoder.encode(ray, Facts::default())).collect();
    let place = Place::Method(queue.id, AUTO.to_owned(), MethodArray::Permutation);
    writer.whole_array(&place, &[keys.len() as u64], &sorted(&keys))?;
    let sampled: Vec<Ray> = sample(queue.rays.len()).flat_map(|range| &queue.rays[range]).copied().collect();
    let (rays, area) = (queue.rays.len() as u64, sampled_area(&unit(), &sampled));
    let choice = Choice { method: method.name, key_bits, way: Way::Indices };
    let candidates = vec![Candidate { choice: choice.clone(), net: 1.25, net_low: 1.2 }];
    let QueueId { bounce, kind, .. } = queue.id;
    // Of another bounce, so that the sample says which queue it is most like.
    let calibrated = CalibrationRecord { bounce: bounce + 1, kind, rays, area, candidates };
    writer.record(&Record::Calibration(calibrated))?;
    writer.record(&Record::Decision(DecisionRecord { queue: queue.id, area, choice: Some(choice) }))?;
    for (stage, ns) in
        [(Stage::Decide, 10), (Stage::Key, 400), (Stage::Sort, 500), (Stage::TraceIndirect, 11_000)]
    {
        writer.record(&timing(queue.id, AUTO, stage, vec![ns; 7]))?;
    }
    Ok(())
}

fn write_measured(
    writer: &mut DumpWriter,
    queue: &Queue,
    table: &LengthTable,
    is_last: bool,
) -> Result<(), WriteError> {
    let place = |array| Place::Queue(queue.id, array);
    let before = table.touched();
    writer.whole_array(&place(QueueArray::Lengths), &[before.len() as u64], &before)?;
    write_queue(writer, queue)?;
    let mut measured = Vec::new();
    if queue.id.pass + 1 == PASSES {
        measured.push("unsorted".to_owned());
        write_timings(writer, queue.id, "unsorted", 0)?;
        for (method, key_bits) in methods().iter().filter(|(method, _)| method.applies_to(queue.id.kind)) {
            write_method(writer, queue, method, *key_bits, table)?;
            write_timings(writer, queue.id, &method.name, measured.len() as u64)?;
            measured.push(method.name.clone());
        }
    }
    if queue.id == QUEUE {
        write_auto(writer, queue)?;
        measured.push(AUTO.to_owned());
    }
    let cells = header().cell_encoder().unwrap();
    for (i, ray) in queue.rays.iter().enumerate() {
        table.add(cell_of(&cells, ray), queue.traced_length(i));
    }
    if is_last {
        let after = table.touched();
        writer.whole_array(&place(QueueArray::FinalLengths), &[after.len() as u64], &after)?;
    }
    for method in &measured {
        let model = |hits| CacheRecord {
            queue: queue.id,
            method: method.clone(),
            groups: 1,
            rays: queue.rays.len().min(64) as u64,
            line_bytes: 128,
            l1_bytes: 128 << 10,
            l2_bytes: 6 << 20,
            accesses: 1000,
            l1_hits: hits,
            l2_hits: 7,
        };
        writer.record(&Record::Cache(model(if method == "unsorted" { 500 } else { 700 })))?;
    }
    let mismatches = measured.iter().map(|method| Mismatches { method: method.clone(), rays: 0 }).collect();
    writer.record(&Record::Queue(QueueRecord {
        id: queue.id,
        rays: queue.rays.len() as u64,
        methods: measured,
        mismatches,
    }))
}

/// Everything but the end.
pub(crate) fn write_all(writer: &mut DumpWriter) -> Result<End, WriteError> {
    write_scene(writer)?;
    for (method, key_bits) in methods() {
        let layout = method.layout.expand(header().extent()).unwrap();
        writer.record(&Record::Method(MethodRecord {
            name: method.name.clone(),
            text: method.layout.text().to_owned(),
            layout: layout.names(),
            termination: method.termination,
            key_bits,
            base: method.name.clone(),
            two_point_length: header().options.two_point_length,
        }))?;
        if method.name == "aila" {
            writer.record(&Record::Way(WayRecord { method: method.name, way: Way::Indices }))?;
        }
    }
    let tables = [LengthTable::new(12), LengthTable::new(12)];
    for pass in 0..PASSES {
        let eye = (0..WIDTH * HEIGHT).map(|path| (path, header().camera.eye)).collect();
        let mut rays = closest_queue(pass, 0, eye);
        for bounce in 0..BOUNCES {
            let is_last = pass + 1 == PASSES && bounce + 1 == BOUNCES;
            write_measured(writer, &rays, &tables[0], is_last)?;
            let points = hit_points(&rays);
            write_measured(writer, &shadow_queue(pass, bounce, &points), &tables[1], is_last)?;
            rays = closest_queue(pass, bounce + 1, points);
        }
    }
    let image: Vec<f32> = (0..WIDTH * HEIGHT * 3).map(|i| random(u64::from(i)) as f32).collect();
    writer.whole_array(&Place::Image, &[u64::from(HEIGHT), u64::from(WIDTH), 3], &image)?;
    let sha256 = Sha256::digest(bytemuck::cast_slice::<f32, u8>(&image)).into();
    let digest = ImageDigest { width: WIDTH, height: HEIGHT, sha256 };
    Ok(End { outcome: Outcome::Complete, image: Some(digest), wall_ns: 1_500_000_000 })
}

/// A folder in memory where the system has one: syncing thousands of recordings to a disk takes minutes.
pub(crate) fn folder_in_memory() -> tempfile::TempDir {
    tempfile::tempdir_in("/dev/shm").or_else(|_| tempfile::tempdir()).unwrap()
}

/// `sample.raydump` in a folder of its own, in memory.
pub(crate) fn in_memory() -> (tempfile::TempDir, PathBuf) {
    let folder = folder_in_memory();
    let path = write(folder.path());
    (folder, path)
}

/// Writes `sample.raydump` into a folder.
pub(crate) fn write(folder: &Path) -> PathBuf {
    let mut writer = DumpWriter::create(&folder.join("sample"), header(), false).unwrap();
    let end = write_all(&mut writer).unwrap();
    writer.finish(end).unwrap()
}
