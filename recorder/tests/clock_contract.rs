//! What is timed on threads neither allocates nor touches memory for the first time.
#![allow(clippy::unwrap_used, reason = "this is test code, although not in test functions")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::collections::BTreeMap;
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

/// Allocations and page faults of each verb: the fewest of all runs but the first two, since the system may take
/// pages back at any time, while a section that allocates does so in every run.
type Fewest = BTreeMap<String, [u64; 2]>;

/// Runs a verb, whose preparation must be as steady as its timed section.
fn watched<T>(
    backend: &mut CpuBackend,
    (run, fewest): (u32, &mut Fewest),
    verb: &str,
    work: impl FnOnce(&mut CpuBackend) -> T,
) -> T {
    let before = ALLOCATIONS.load(Relaxed);
    let value = work(backend);
    let allocations = ALLOCATIONS.load(Relaxed) - before;
    if run >= 2 {
        let least = fewest.entry(verb.to_owned()).or_insert([u64::MAX; 2]);
        *least = [least[0].min(allocations), least[1].min(backend.sample().page_faults)];
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
        let mut fewest = Fewest::new();
        pool.install(|| (0..5).for_each(|run| pass(&mut backend, &setup.methods, (run, &mut fewest))));
        assert!(fewest.len() > 9 * 6, "{fewest:?}");
        for (verb, least) in fewest {
            assert_eq!(least, [0, 0], "allocations and page faults of {verb}");
        }
    }
}

/// The verbs of a pass with two bounces, each as often as [`watched`] needs it: the same rays every time.
fn pass(backend: &mut CpuBackend, methods: &[MethodPlan], (run, fewest): (u32, &mut Fewest)) {
    let mut rays = watched(backend, (run, &mut *fewest), "generate", |backend| backend.generate(0).unwrap());
    for _ in 0..2 {
        let hits = watched(backend, (run, &mut *fewest), "trace", |backend| {
            backend.trace(&rays, Order::Stored).unwrap()
        });
        orders(backend, methods, (&rays, &hits), (run, fewest));
        let shaded =
            watched(backend, (run, &mut *fewest), "shade", |backend| backend.shade(&rays, &hits).unwrap());
        let shadow = &shaded.shadow;
        assert!(!shadow.is_empty());
        let occlusion = watched(backend, (run, &mut *fewest), "trace of shadow rays", |backend| {
            backend.trace(shadow, Order::Stored).unwrap()
        });
        orders(backend, methods, (shadow, &occlusion), (run, fewest));
        watched(backend, (run, &mut *fewest), "add_light", |backend| {
            backend.add_light(shadow, &occlusion).unwrap()
        });
        rays = shaded.next;
    }
}

type Queued<'a> = (&'a <CpuBackend as Backend>::Rays, &'a <CpuBackend as Backend>::Hits);

fn orders(
    backend: &mut CpuBackend,
    methods: &[MethodPlan],
    (rays, hits): Queued<'_>,
    (run, fewest): (u32, &mut Fewest),
) {
    for (number, method) in methods.iter().enumerate().filter(|(_, method)| method.applies_to(rays.id().kind))
    {
        let name = |verb: &str| format!("{verb} of {} rays for {}", rays.id().kind, method.name);
        let keys = watched(backend, (run, &mut *fewest), &name("key"), |backend| {
            backend.key(rays, hits, number).unwrap()
        });
        let order =
            watched(backend, (run, &mut *fewest), &name("sort"), |backend| backend.sort(&keys).unwrap());
        let gathered = watched(backend, (run, &mut *fewest), &name("gather"), |backend| {
            backend.gather(rays, &order).unwrap()
        });
        let found = watched(backend, (run, &mut *fewest), &name("trace"), |backend| {
            backend.trace(&gathered, Order::Stored).unwrap()
        });
        let home = watched(backend, (run, &mut *fewest), &name("scatter"), |backend| {
            backend.scatter(&found, &order).unwrap()
        });
        assert_eq!(backend.differences(hits, &home).unwrap(), 0, "{}", name("home"));
        let found = watched(backend, (run, &mut *fewest), &name("trace through indices"), |backend| {
            backend.trace(rays, Order::Indirect(&order)).unwrap()
        });
        assert_eq!(backend.differences(hits, &found).unwrap(), 0, "{}", name("indices"));
    }
    watched(backend, (run, &mut *fewest), "accumulate", |backend| {
        backend.accumulate(rays, hits, Table::Scratch).unwrap();
    });
}
