//! What is timed is nothing but the work: on threads no section allocates or touches memory first, on a GPU none
//! makes a buffer, a bind group or anything else.
#![allow(clippy::unwrap_used, reason = "this is test code, although not in test functions")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};
use std::sync::{Arc, Mutex, PoisonError};

use recorder::backends::cpu::CpuBackend;
use recorder::backends::gpu::GpuBackend;
use recorder::backends::{Backend, Queue, Table};
use recorder::cli::parse_record;
use recorder::device::{AdapterRequest, Gpu};
use recorder::recording;
use recorder::stages::setup::{MethodPlan, Setup};
use recorder::stages::trace::cpu::CpuTracer;
use recorder::stages::trace::{Order, TraceKernel};
use scenes::Scene;
use scenes::bvh::{Bvh, BvhKind};

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

/// What wgpu is asked for, as it logs it: between the submission of work and the wait for it nothing may be made.
struct Calls {
    is_timed: AtomicBool,
    /// Sections so far, timed or only read back.
    sections: AtomicU64,
    /// Calls inside sections that make something or encode it.
    made: AtomicU64,
}

static CALLS: Calls =
    Calls { is_timed: AtomicBool::new(false), sections: AtomicU64::new(0), made: AtomicU64::new(0) };

impl log::Log for Calls {
    fn enabled(&self, _: &log::Metadata<'_>) -> bool {
        true
    }

    fn log(&self, record: &log::Record<'_>) {
        if !record.target().starts_with("wgpu_core") {
            return;
        }
        let call = record.args().to_string();
        if call == "Queue::submit" {
            self.is_timed.store(true, Relaxed);
            self.sections.fetch_add(1, Relaxed);
        } else if call.starts_with("Device::poll") || call.starts_with("Buffer::map_async") {
            self.is_timed.store(false, Relaxed);
        } else if (call.contains("::create_") || call.contains("::write_")) && self.is_timed.load(Relaxed) {
            println!("while timed: {call}");
            self.made.fetch_add(1, Relaxed);
        }
    }

    fn flush(&self) {}
}

/// Both tests count what the whole process does.
static TURN: Mutex<()> = Mutex::new(());

/// The verbs of a backend, watched.
struct Watched<B> {
    backend: B,
    run: u32,
    /// Begins to count.
    begin: fn(),
    /// What was counted since: two numbers that must be 0.
    counted: fn(&B) -> [u64; 2],
    /// Counts of each verb: the fewest of all runs but the first two, since the system may take pages back at
    /// any time, while a section that allocates or makes something does so in every run.
    fewest: BTreeMap<String, [u64; 2]>,
}

impl<B: Backend> Watched<B> {
    /// Runs a verb; on threads its preparation must be as steady as its timed section.
    fn verb<T>(&mut self, verb: &str, work: impl FnOnce(&mut B) -> T) -> T {
        (self.begin)();
        let value = work(&mut self.backend);
        let counts = (self.counted)(&self.backend);
        if self.run >= 2 {
            let least = self.fewest.entry(verb.to_owned()).or_insert([u64::MAX; 2]);
            *least = [least[0].min(counts[0]), least[1].min(counts[1])];
        }
        value
    }

    /// Passes, each with the same rays, and then what all of them did.
    fn check(mut self, methods: &[MethodPlan], runs: u32, what: &str) {
        for run in 0..runs {
            self.run = run;
            self.pass(methods);
        }
        assert!(self.fewest.len() > 9 * 6, "{:?}", self.fewest);
        for (verb, least) in self.fewest {
            assert_eq!(least, [0, 0], "{what} of {verb}");
        }
    }

    /// The verbs of a pass with two bounces.
    fn pass(&mut self, methods: &[MethodPlan]) {
        let mut rays = self.verb("generate", |backend| backend.generate(0).unwrap());
        for _ in 0..2 {
            let hits = self.verb("trace", |backend| backend.trace(&rays, Order::Stored).unwrap());
            self.orders(methods, &rays, &hits);
            let shaded = self.verb("shade", |backend| backend.shade(&rays, &hits).unwrap());
            let shadow = &shaded.shadow;
            assert!(!shadow.is_empty());
            let occlusion =
                self.verb("trace of shadow rays", |backend| backend.trace(shadow, Order::Stored).unwrap());
            self.orders(methods, shadow, &occlusion);
            self.verb("add_light", |backend| backend.add_light(shadow, &occlusion).unwrap());
            rays = shaded.next;
        }
    }

    fn orders(&mut self, methods: &[MethodPlan], rays: &B::Rays, hits: &B::Hits) {
        let kind = rays.id().kind;
        for (number, method) in methods.iter().enumerate().filter(|(_, method)| method.applies_to(kind)) {
            let name = |verb: &str| format!("{verb} of {kind} rays for {}", method.name);
            let keys = self.verb(&name("key"), |backend| backend.key(rays, Some(hits), number).unwrap());
            let order = self.verb(&name("sort"), |backend| backend.sort(&keys).unwrap());
            let gathered = self.verb(&name("gather"), |backend| backend.gather(rays, &order).unwrap());
            self.verb(&name("reorder"), |backend| backend.reorder(rays, &order).map(drop).unwrap());
            let found = self.verb(&name("trace"), |backend| backend.trace(&gathered, Order::Stored).unwrap());
            let home = self.verb(&name("scatter"), |backend| backend.scatter(&found, &order).unwrap());
            assert_eq!(self.backend.differences(hits, &home).unwrap(), 0, "{}", name("home"));
            let found = self.verb(&name("trace through indices"), |backend| {
                backend.trace(rays, Order::Indirect(&order)).unwrap()
            });
            assert_eq!(self.backend.differences(hits, &found).unwrap(), 0, "{}", name("indices"));
        }
        self.verb("accumulate", |backend| backend.accumulate(rays, hits, Table::Scratch).unwrap());
    }
}

fn prepared(size: [&str; 2], key_bits: &str) -> (Scene, Bvh, Arc<Setup>) {
    let [width, height] = size;
    let words = ["builtin:atrium", "--out", "unused", "--width", width, "--height", height];
    let words = words.into_iter().chain(["--key-bits", key_bits]);
    let options = parse_record(words.map(Into::into)).unwrap();
    let scene = scenes::load(&options.scene).unwrap();
    let bvh = scenes::bvh::build(&scene, BvhKind::Cwbvh).unwrap();
    let setup = Arc::new(recording::setup(&scene, &scene.cameras[0], &options).unwrap());
    (scene, bvh, setup)
}

#[test]
fn no_timed_section_allocates_or_touches_memory_first() {
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    for key_bits in ["32", "64"] {
        let (scene, bvh, setup) = prepared(["320", "180"], key_bits);
        let watched = Watched {
            backend: CpuBackend::new(Arc::clone(&setup), Arc::new(CpuTracer::new(&scene, &bvh))),
            run: 0,
            begin: || ALLOCATIONS.store(0, Relaxed),
            counted: |backend| [ALLOCATIONS.load(Relaxed), backend.sample().page_faults],
            fewest: BTreeMap::new(),
        };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
        pool.install(|| watched.check(&setup.methods, 5, "allocations and page faults"));
    }
}

#[test]
fn no_timed_section_of_a_gpu_makes_anything() {
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    log::set_logger(&CALLS).unwrap();
    log::set_max_level(log::LevelFilter::Trace);
    for key_bits in ["32", "64"] {
        let (scene, bvh, setup) = prepared(["48", "32"], key_bits);
        let gpu = Gpu::open(&AdapterRequest::Any)
            .unwrap_or_else(|error| panic!("GPU tests need an adapter; tests/run installs one: {error}"));
        let kernel = TraceKernel::Cwbvh;
        let watched = Watched {
            backend: GpuBackend::new(gpu, &scene, Some(&bvh), Arc::clone(&setup), kernel).unwrap(),
            run: 0,
            begin: || {
                CALLS.is_timed.store(false, Relaxed);
                CALLS.sections.store(0, Relaxed);
                CALLS.made.store(0, Relaxed);
            },
            counted: |_| [CALLS.made.load(Relaxed), u64::from(CALLS.sections.load(Relaxed) == 0)],
            fewest: BTreeMap::new(),
        };
        watched.check(&setup.methods, 3, "what was made while timed, and whether nothing was submitted");
    }
    log::set_max_level(log::LevelFilter::Off);
}
