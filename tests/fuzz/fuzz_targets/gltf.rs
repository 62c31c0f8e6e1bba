//! A `.glb` or `.gltf` file from its first byte to a scene that is complete.
//! First inputs: `scenes/tests/corpus/gltf`.
#![no_main]

#[path = "../../../scenes/tests/hostile/mod.rs"]
mod hostile;

#[global_allocator]
static ALLOCATOR: cap::Cap<std::alloc::System> = cap::Cap::new(std::alloc::System, 1024 << 20);

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| hostile::gltf(bytes));
