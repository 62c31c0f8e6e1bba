//! What is timed on threads neither allocates nor touches memory for the first time.
#![allow(clippy::unwrap_used, reason = "this is test code, although not in test functions")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use recorder::backends::cpu::CpuBackend;
use recorder::backends::{Backend, Queue, Table};
use recorder::cli::parse_record;
use recorder::recording;
use recorder::stages::setup::MethodPlan;
use recorder::stages::trace::Order;
use recorder::stages::trace::cpu::CpuTracer;
use scenes::bvh::BvhKind;

/// The system's allocator, which counts what it is asked for by any thread.
struct Counting;

static ALLOCATIONS: AtomicU64 = AtomicU64::new(0);

// SAFETY: everything is handed to the system's allocator as it comes.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Relaxed);
        // SAFETY: the caller's promises are those that the system's allocator asks for.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        // SAFETY: as above.
        unsafe { System.dealloc(memory, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Runs a verb; after the second time it must be as steady as its timed section.
fn watched<T>(backend: &mut CpuBackend, time: u32, verb: &str, run: impl FnOnce(&mut CpuBackend) -> T) -> T {
    let before = ALLOCATIONS.load(Relaxed);
    let value = run(backend);
    let allocations = ALLOCATIONS.load(Relaxed) - before;
    if time >= 2 {
        assert_eq!(allocations, 0, "allocations of {verb}, run {time}");
        assert_eq!(backend.sample().page_faults, 0, "page faults of {verb}, run {time}");
    }
    value
}

#[test]
fn no_timed_section_allocates_or_touches_memory_first() {
    for key_bits in ["32", "64"] {
        let words = [
            "builtin:atrium",
            "--out",
            "unused",
            "--width",
            "320",
            "--height",
            "180",
            "--key-bits",
            key_bits,
        ];
        let options = parse_record(words.into_iter().map(Into::into)).unwrap();
        let scene = scenes::load(&options.scene).unwrap();
        let bvh = scenes::bvh::build(&scene, BvhKind::Cwbvh).unwrap();
        let setup = Arc::new(recording::setup(&scene, &scene.cameras[0], &options).unwrap());
        let mut backend = CpuBackend::new(Arc::clone(&setup), Arc::new(CpuTracer::new(&scene, &bvh)));
        let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
        pool.install(|| (0..4).for_each(|time| pass(&mut backend, &setup.methods, time)));
    }
}

/// The verbs of a pass with two bounces, each as often as [`watched`] needs it: the same rays every time.
fn pass(backend: &mut CpuBackend, methods: &[MethodPlan], time: u32) {
    let mut rays = watched(backend, time, "generate", |backend| backend.generate(0).unwrap());
    for _ in 0..2 {
        let hits = watched(backend, time, "trace", |backend| backend.trace(&rays, Order::Stored).unwrap());
        orders(backend, methods, (&rays, &hits), time);
        let shaded = watched(backend, time, "shade", |backend| backend.shade(&rays, &hits).unwrap());
        let shadow = &shaded.shadow;
        assert!(!shadow.is_empty());
        let occlusion = watched(backend, time, "trace of shadow rays", |backend| {
            backend.trace(shadow, Order::Stored).unwrap()
        });
        orders(backend, methods, (shadow, &occlusion), time);
        watched(backend, time, "add_light", |backend| backend.add_light(shadow, &occlusion).unwrap());
        rays = shaded.next;
    }
}

type Queued<'a> = (&'a <CpuBackend as Backend>::Rays, &'a <CpuBackend as Backend>::Hits);

fn orders(backend: &mut CpuBackend, methods: &[MethodPlan], (rays, hits): Queued<'_>, time: u32) {
    for (number, method) in methods.iter().enumerate().filter(|(_, method)| method.applies_to(rays.id().kind))
    {
        let name = |verb: &str| format!("{verb} for {}", method.name);
        let keys = watched(backend, time, &name("key"), |backend| backend.key(rays, hits, number).unwrap());
        let order = watched(backend, time, &name("sort"), |backend| backend.sort(&keys).unwrap());
        let gathered =
            watched(backend, time, &name("gather"), |backend| backend.gather(rays, &order).unwrap());
        let found = watched(backend, time, &name("trace"), |backend| {
            backend.trace(&gathered, Order::Stored).unwrap()
        });
        let home =
            watched(backend, time, &name("scatter"), |backend| backend.scatter(&found, &order).unwrap());
        assert_eq!(backend.differences(hits, &home).unwrap(), 0, "{}", name("home"));
        let found = watched(backend, time, &name("trace through indices"), |backend| {
            backend.trace(rays, Order::Indirect(&order)).unwrap()
        });
        assert_eq!(backend.differences(hits, &found).unwrap(), 0, "{}", name("indices"));
    }
    watched(backend, time, "accumulate", |backend| {
        backend.accumulate(rays, hits, Table::Scratch).unwrap();
    });
}
