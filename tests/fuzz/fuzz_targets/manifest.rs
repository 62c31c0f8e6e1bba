//! The bytes of a manifest, as they are and with every checksum made right.
//! First inputs: `formats/tests/corpus/manifest`.
#![no_main]

#[path = "../../../formats/tests/hostile/mod.rs"]
mod hostile;

#[global_allocator]
static ALLOCATOR: cap::Cap<std::alloc::System> = cap::Cap::new(std::alloc::System, 64 << 20);

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| hostile::manifest(bytes));
