//! The text of a key layout, as users type it and manifests hold it.
//! First inputs: `formats/tests/corpus/layout`.
#![no_main]

#[path = "../../../formats/tests/hostile/mod.rs"]
mod hostile;

#[global_allocator]
static ALLOCATOR: cap::Cap<std::alloc::System> = cap::Cap::new(std::alloc::System, 64 << 20);

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| hostile::layout(bytes));
