//! A whole dump: edits of the sample's manifest and files, then everything that reads dumps.
//! First inputs: `formats/tests/corpus/dump`.
#![no_main]

#[path = "../../formats/tests/hostile/mod.rs"]
mod hostile;

#[global_allocator]
static ALLOCATOR: cap::Cap<std::alloc::System> = cap::Cap::new(std::alloc::System, 512 << 20);

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| hostile::dump(bytes));
