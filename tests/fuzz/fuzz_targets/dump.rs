//! A whole dump: edits of the sample's manifest and files, then everything that reads dumps.
//! First inputs: `formats/tests/corpus/dump`.
#![no_main]

#[path = "../../../formats/tests/hostile/mod.rs"]
mod hostile;

#[global_allocator]
static ALLOCATOR: cap::Cap<std::alloc::System> = cap::Cap::new(std::alloc::System, 512 << 20);

libfuzzer_sys::fuzz_target!(
    // A handful of rays takes less time than another thread takes to wake up.
    init: rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global().unwrap(),
    |bytes: &[u8]| hostile::dump(bytes)
);
