//! The text of a sidecar.
//! First inputs: `scenes/tests/corpus/sidecar`.
#![no_main]

#[path = "../../../scenes/tests/hostile/mod.rs"]
mod hostile;

#[global_allocator]
static ALLOCATOR: cap::Cap<std::alloc::System> = cap::Cap::new(std::alloc::System, 64 << 20);

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| hostile::sidecar(bytes));
