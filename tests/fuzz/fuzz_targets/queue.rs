//! A header and a queue by it, as a replay meets them in a recording of somebody else's.
//! First inputs: `formats/tests/corpus/queue`.
#![no_main]

#[path = "../../../formats/tests/hostile/mod.rs"]
mod hostile;

#[global_allocator]
static ALLOCATOR: cap::Cap<std::alloc::System> = cap::Cap::new(std::alloc::System, 64 << 20);

libfuzzer_sys::fuzz_target!(
    // A handful of rays takes less time than another thread takes to wake up.
    init: rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global().unwrap(),
    |bytes: &[u8]| hostile::queue(bytes)
);
