//! The stages of the GPU against those on threads, each given the other's inputs: bit for bit.
//!
//! Rays, results and length tables are read back from the GPU; threads make keys, permutations and
//! tables of the same inputs. Needs a device whose self-check finds the arithmetic of rays and keys exact.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::sync::Arc;

use formats::key::{Encoder, Facts, Termination};
use formats::length_table::{LengthCell, LengthTable};
use formats::manifest::QueueId;
use formats::ray::{Kind, Ray, Work};
use formats::unit_space::UnitSpace;
use recorder::backends::gpu::GpuBackend;
use recorder::backends::{Array, Backend, Queue, RecordedRays, Table, collected};
use recorder::cli::parse_record;
use recorder::device::{AdapterRequest, Gpu};
use recorder::machine::GpuDevice;
use recorder::options::RecordOptions;
use recorder::recording;
use recorder::stages::random::Random;
use recorder::stages::setup::Setup;
use recorder::stages::trace::cpu::CpuTracer;
use recorder::stages::trace::hits::Hits;
use recorder::stages::trace::{Order, Precision, TraceKernel};
use recorder::wavefront;
use scenes::Scene;
use scenes::bvh::{Bvh, BvhKind};

/// Every built-in method, and layouts of one's own that no row has.
const METHODS: [&str; 8] = [
    "--methods",
    "all,paraboloid,hilbert-origin,hilbert-two-point,two-point-xor,grid-spherical,tiled-octahedron",
    "--method",
    "learnt-curve=u*3 hilbert(ez oy pu dx)*7 v @adaptive",
    "--method",
    "traced-xor=ox*5 ((oy oz)*6 ^ hilbert(theta phi ex)*4) ez*9 @real",
    "--method",
    "tiles-of-lengths=ox*3 tile(7x10) (ex ey)*9 @adaptive",
];

fn options(scene: &str, extra: &[&str]) -> RecordOptions {
    let words = [scene, "--out", "unused", "--width", "96", "--height", "64", "--bounces", "4"];
    parse_record(words.iter().chain(extra).map(|&word| word.into())).unwrap()
}

/// An array of the GPU.
fn read<T: bytemuck::Pod>(gpu: &mut GpuBackend, array: Array<'_, GpuBackend>) -> Vec<T> {
    collected(gpu, array).unwrap()
}

/// What threads find, as a recording holds it.
fn traced(tracer: &CpuTracer, kind: Kind, rays: &[Ray]) -> Vec<u8> {
    let hits = Hits::new(kind, rays.len());
    tracer.trace(rays, Order::Stored, &hits);
    hits.bytes(0..rays.len())
}

/// The kernel that both backends have.
fn kernel(options: &RecordOptions) -> TraceKernel {
    options.device.trace.unwrap_or(TraceKernel::Cwbvh)
}

/// As every run opens it.
fn open() -> Gpu {
    let gpu = Gpu::open(&AdapterRequest::Any)
        .unwrap_or_else(|error| panic!("GPU tests need an adapter; tests/run installs one: {error}"));
    GpuDevice::checked(gpu).unwrap().gpu
}

struct Machine {
    scene: Scene,
    setup: Arc<Setup>,
    bvh: Bvh,
    gpu: GpuBackend,
}

fn machine(options: &RecordOptions) -> Machine {
    let scene = scenes::load(&options.scene).unwrap();
    let setup = Arc::new(recording::setup(&scene, &scene.cameras[0], options).unwrap());
    let kind = kernel(options).bvh_kind().unwrap();
    let bvh = scenes::bvh::build(&scene, kind).unwrap();
    let gpu = GpuBackend::new(open(), &scene, Some(&bvh), Arc::clone(&setup), kernel(options)).unwrap();
    Machine { scene, setup, bvh, gpu }
}

/// A queue and its results on the CPU's side.
struct Copied {
    rays: Vec<Ray>,
    lights: Vec<u32>,
    paths: Vec<u32>,
    lengths: Vec<f32>,
}

fn copy(
    gpu: &mut GpuBackend,
    setup: &Setup,
    rays: &<GpuBackend as Backend>::Rays,
    hits: &<GpuBackend as Backend>::Hits,
) -> Copied {
    let kind = rays.id().kind;
    let copied: Vec<Ray> = read(gpu, Array::Rays(rays));
    let found = Hits::from_bytes(kind, &read(gpu, Array::Hits(hits)));
    assert_eq!((copied.len(), found.len()), (rays.len(), rays.len()));
    let lengths = (0..found.len()).map(|index| found.length(&setup.unit, &copied[index], index)).collect();
    let lights = match kind {
        Kind::Closest => vec![0; copied.len()],
        Kind::Shadow => read(gpu, Array::Lights(rays)),
    };
    Copied { rays: copied, lights, paths: read(gpu, Array::PathIds(rays)), lengths }
}

/// Compares every method's keys and permutation on one queue; returns how many keys were compared.
fn compare_orders(
    gpu: &mut GpuBackend,
    setup: &Setup,
    rays: &<GpuBackend as Backend>::Rays,
    hits: &<GpuBackend as Backend>::Hits,
    table: &LengthTable,
) -> usize {
    let copied = copy(gpu, setup, rays, hits);
    let cells = Encoder::new(&setup.table_layout, setup.table_bits, setup.unit, &[]);
    let mut compared = 0;
    for (number, method) in
        setup.methods.iter().enumerate().filter(|(_, method)| method.applies_to(rays.id().kind))
    {
        let encoder = Encoder::new(&method.layout, method.key_bits, setup.unit, &setup.light_sites);
        let expected: Vec<u64> = (0..copied.rays.len())
            .map(|index| {
                let ray = &copied.rays[index];
                let length = match method.termination {
                    Termination::Adaptive => table.mean(cells.encode(ray, Facts::default()) as u32),
                    Termination::Real => copied.lengths[index],
                    Termination::Unused | Termination::Fixed => method.two_point_length,
                };
                let (light, path) = (copied.lights[index], copied.paths[index]);
                encoder.encode(ray, Facts { length, light, path })
            })
            .collect();
        let keys = gpu.key(rays, Some(hits), number).unwrap();
        let found: Vec<u64> = if method.key_bits <= 32 {
            read::<u32>(gpu, Array::Keys(&keys)).into_iter().map(u64::from).collect()
        } else {
            read(gpu, Array::Keys(&keys))
        };
        let place = format!("{} at {} bits, {}", method.name, method.key_bits, rays.id());
        let wrong = found.iter().zip(&expected).position(|(found, expected)| found != expected);
        assert_eq!(wrong, None, "first wrong key of {place}");
        let order = gpu.sort(&keys).unwrap();
        let found: Vec<u32> = read(gpu, Array::Permutation(&order));
        let mut expected_order: Vec<u32> = (0..expected.len() as u32).collect();
        expected_order.sort_by_key(|&index| expected[index as usize]);
        assert_eq!(found, expected_order, "permutation of {place}");
        compared += expected.len();
    }
    compared
}

fn add_lengths(setup: &Setup, table: &LengthTable, copied: &Copied) {
    let cells = Encoder::new(&setup.table_layout, setup.table_bits, setup.unit, &[]);
    for (ray, &length) in copied.rays.iter().zip(&copied.lengths) {
        table.add(cells.encode(ray, Facts::default()) as u32, length);
    }
}

/// Two passes over all queues, comparing keys, permutations and tables on the way.
fn compare_run(options: &RecordOptions) -> usize {
    let Machine { setup, mut gpu, .. } = machine(options);
    let tables = [LengthTable::new(setup.table_bits), LengthTable::new(setup.table_bits)];
    let mut compared = 0;
    for pass in 0..2 {
        let mut rays = gpu.generate(pass).unwrap();
        for _ in 0..setup.bounces {
            let hits = gpu.trace(&rays, Order::Stored).unwrap();
            let mut queues = vec![(rays, hits)];
            let shaded = gpu.shade(&queues[0].0, &queues[0].1).unwrap();
            let occlusion = gpu.trace(&shaded.shadow, Order::Stored).unwrap();
            queues.push((shaded.shadow, occlusion));
            for (rays, hits) in &queues {
                let table = &tables[rays.id().kind as usize];
                compared += compare_orders(&mut gpu, &setup, rays, hits, table);
                let copied = copy(&mut gpu, &setup, rays, hits);
                add_lengths(&setup, table, &copied);
                gpu.accumulate(rays, hits, Table::Learnt).unwrap();
                assert_eq!(
                    read::<LengthCell>(&mut gpu, Array::Lengths(rays.id().kind)),
                    table.touched(),
                    "table after {}",
                    rays.id()
                );
            }
            rays = shaded.next;
        }
    }
    compared
}

#[test]
fn keys_permutations_and_tables_are_equal_at_16_bits() {
    let extra = [METHODS.as_slice(), &["--key-bits", "16"]].concat();
    assert!(compare_run(&options("builtin:cornell", &extra)) > 300_000);
}

#[test]
fn keys_permutations_and_tables_are_equal_at_32_bits() {
    let extra = ["--key-bits", "32", "--table-bits", "12", "--method", "mine=(ox oy oz)*4 (u v ex ey ez)*10"];
    assert!(compare_run(&options("builtin:atrium?triangles=20000", &extra)) > 300_000);
}

#[test]
fn keys_permutations_and_tables_are_equal_at_64_bits() {
    let table = ["--table-method", "hilbert-origin", "--two-point-length", "0.4", "--key-bits", "64"];
    let extra = [METHODS.as_slice(), &table].concat();
    assert!(compare_run(&options("builtin:terrain?triangles=20000", &extra)) > 100_000);
}

/// Results and work of every queue, GPU against threads, on a scene with alpha masks.
fn compare_tracing(options: &RecordOptions) {
    let Machine { scene, setup, bvh, mut gpu } = machine(options);
    let tracer = CpuTracer::new(&scene, &bvh);
    let mut rays = gpu.generate(0).unwrap();
    for bounce in 0..setup.bounces {
        let hits = gpu.trace(&rays, Order::Stored).unwrap();
        let copied = copy(&mut gpu, &setup, &rays, &hits);
        let found: Vec<u8> = read(&mut gpu, Array::Hits(&hits));
        let expected = traced(&tracer, Kind::Closest, &copied.rays);
        let wrong = found.chunks(16).zip(expected.chunks(16)).position(|(found, expected)| found != expected);
        assert_eq!(wrong, None, "first wrong hit of bounce {bounce}");
        let work: Vec<Work> = read(&mut gpu, Array::Work(&rays));
        assert_eq!(work, tracer.work(&copied.rays, Kind::Closest), "work of bounce {bounce}");
        let shaded = gpu.shade(&rays, &hits).unwrap();
        let occlusion = gpu.trace(&shaded.shadow, Order::Stored).unwrap();
        let shadow = copy(&mut gpu, &setup, &shaded.shadow, &occlusion);
        let found: Vec<u8> = read(&mut gpu, Array::Hits(&occlusion));
        assert_eq!(found, traced(&tracer, Kind::Shadow, &shadow.rays), "distances of bounce {bounce}");
        rays = shaded.next;
    }
}

#[test]
fn traced_results_and_work_are_equal_with_cwbvh() {
    compare_tracing(&options("builtin:city?triangles=60000", &["--trace", "cwbvh"]));
}

#[test]
fn traced_results_and_work_are_equal_with_bvh2() {
    compare_tracing(&options("builtin:atrium?triangles=20000", &["--trace", "bvh2"]));
}

/// The tests that precision is measured against are the same on both backends, too.
#[test]
fn every_precision_finds_the_same_on_both_backends() {
    for trace in [TraceKernel::Cwbvh, TraceKernel::Bvh2] {
        let options = options("builtin:atrium?triangles=20000", &["--trace", trace.name()]);
        let Machine { scene, setup, bvh, .. } = machine(&options);
        for precision in Precision::ALL {
            let setup = Arc::new(Setup { precision, ..Setup::clone(&setup) });
            let mut gpu = GpuBackend::new(open(), &scene, Some(&bvh), setup, trace).unwrap();
            let rays = gpu.generate(0).unwrap();
            let hits = gpu.trace(&rays, Order::Stored).unwrap();
            let found: Vec<u8> = read(&mut gpu, Array::Hits(&hits));
            let rays: Vec<Ray> = read(&mut gpu, Array::Rays(&rays));
            let tracer = CpuTracer::new(&scene, &bvh).with_precision(precision);
            let expected = traced(&tracer, Kind::Closest, &rays);
            let differing = found.chunks(16).zip(expected.chunks(16)).filter(|(a, b)| a != b).count();
            assert_eq!(differing, 0, "{precision:?} by {trace:?}");
        }
    }
}

/// Rays that no tracer makes but a file may hold: origins outside of the box and on its faces, zeros of
/// both signs, NaN and infinity, all at one place.
fn odd_rays(unit_min: [f32; 3], unit_max: [f32; 3]) -> Vec<Ray> {
    let mut random = Random::new([77, 0], 0, 0, 0);
    let mut ray = |number: usize| {
        let axis_value = |axis: usize, draw: f32| {
            let (min, max) = (unit_min[axis], unit_max[axis]);
            let odd = [
                min,
                max,
                min.next_down(),
                max.next_up(),
                min - 1.0,
                max + 1e30,
                0.0,
                -0.0,
                f32::NAN,
                f32::INFINITY,
                f32::NEG_INFINITY,
                1e-45,
            ];
            if number.is_multiple_of(3) {
                min + draw * (max - min)
            } else {
                odd[(draw * odd.len() as f32) as usize]
            }
        };
        let origin = [0, 1, 2].map(|axis| axis_value(axis, random.draw()));
        let [x, y, z] = [0; 3].map(|_| 2.0 * random.draw() - 1.0);
        let length = (x * x + y * y + z * z).sqrt();
        let t_max = if number.is_multiple_of(2) { f32::INFINITY } else { 2.0 * random.draw() };
        let same = [0.5 * (unit_min[0] + unit_max[0]), unit_min[1], unit_max[2]];
        let origin = if number.is_multiple_of(5) { same } else { origin };
        Ray { origin, t_min: 0.0, direction: [x / length, y / length, z / length], t_max }
    };
    (0..6000).map(&mut ray).collect()
}

fn upload(
    gpu: &mut GpuBackend,
    rays: &[Ray],
    lengths: Option<&[LengthCell]>,
) -> <GpuBackend as Backend>::Rays {
    let path_ids: Vec<u32> = (0..rays.len() as u32).collect();
    let id = QueueId { pass: 0, bounce: 1, kind: Kind::Closest };
    let queue = RecordedRays { id, rays, path_ids: &path_ids, lights: &[], lengths };
    gpu.upload(queue).unwrap()
}

#[test]
fn keys_of_odd_rays_are_equal_in_boxes_of_any_extent() {
    let boxes = [
        ([-1.0, -2.0, 0.5], [1.0, 3.0, 4.0]),
        ([-1.0, 2.0, 0.5], [1.0, 2.0, 4.0]),
        ([1.0, 2.0, 0.0], [1.0, 2.0, 4.0]),
        ([0.0; 3], [0.0; 3]),
    ];
    for (min, max) in boxes {
        let extra = [METHODS.as_slice(), &["--key-bits", "64"]].concat();
        let options = options("builtin:cornell", &extra);
        let scene = scenes::load(&options.scene).unwrap();
        let setup = recording::setup(&scene, &scene.cameras[0], &options).unwrap();
        let setup = Arc::new(Setup { unit: UnitSpace::from_bounds(min, max), ..setup });
        let bvh = scenes::bvh::build(&scene, BvhKind::Cwbvh).unwrap();
        let mut gpu =
            GpuBackend::new(open(), &scene, Some(&bvh), Arc::clone(&setup), TraceKernel::Cwbvh).unwrap();
        let rays = upload(&mut gpu, &odd_rays(min, max), None);
        let hits = gpu.trace(&rays, Order::Stored).unwrap();
        let table = LengthTable::new(setup.table_bits);
        assert!(compare_orders(&mut gpu, &setup, &rays, &hits, &table) > 30_000, "{min:?} to {max:?}");
    }
}

/// Every ray in one cell, none of which hits anything, on top of two billion that were there.
#[test]
fn tables_of_one_cell_and_of_misses_alone_are_equal() {
    let options = options("builtin:cornell", &[]);
    let Machine { setup, mut gpu, .. } = machine(&options);
    let away = Ray { origin: [1e6; 3], t_min: 0.0, direction: [1.0, 0.0, 0.0], t_max: f32::INFINITY };
    let rays = upload(&mut gpu, &[away; 6000], None);
    let hits = gpu.trace(&rays, Order::Stored).unwrap();
    let copied = copy(&mut gpu, &setup, &rays, &hits);
    let table = LengthTable::new(setup.table_bits);
    for _ in 0..3 {
        gpu.accumulate(&rays, &hits, Table::Learnt).unwrap();
        add_lengths(&setup, &table, &copied);
    }
    assert_eq!(table.touched().len(), 1, "all rays are in one cell");
    assert_eq!(read::<LengthCell>(&mut gpu, Array::Lengths(Kind::Closest)), table.touched());
    let mut cells = table.touched();
    let scale = (1u64 << 31) / u64::from(cells[0].count);
    // The first of the count and of the sum is what an untouched cell holds.
    let dummy = formats::length_table::DUMMY_SUM;
    cells[0].sum = dummy + (cells[0].sum - dummy) * scale;
    cells[0].count = 1 + (cells[0].count - 1) * scale as u32;
    let table = LengthTable::from_touched(setup.table_bits, &cells).unwrap();
    let rays = upload(&mut gpu, &[away; 6000], Some(&cells));
    gpu.accumulate(&rays, &hits, Table::Learnt).unwrap();
    add_lengths(&setup, &table, &copied);
    assert_eq!(read::<LengthCell>(&mut gpu, Array::Lengths(Kind::Closest)), table.touched());
}

#[test]
fn a_picture_begins_with_tables_that_nothing_was_added_to() {
    let Machine { mut gpu, .. } = machine(&options("builtin:cornell", &[]));
    let picture = |gpu: &mut GpuBackend| {
        gpu.restart().unwrap();
        let tables =
            |gpu: &mut GpuBackend| Kind::ALL.map(|kind| read::<LengthCell>(gpu, Array::Lengths(kind)));
        let before = tables(gpu);
        wavefront::run(gpu, 0..1, 2, &mut ()).unwrap();
        (before, tables(gpu), read::<[f32; 3]>(gpu, Array::Film))
    };
    let (first, second) = (picture(&mut gpu), picture(&mut gpu));
    assert!(first.0.iter().all(Vec::is_empty) && first.1.iter().all(|cells| cells.len() > 100));
    assert!(first == second, "the second picture is not the first one");
}
