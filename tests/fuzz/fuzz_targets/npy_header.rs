//! The header of an NPY file, as it is and behind NumPy's magic bytes.
//! First inputs: `formats/tests/corpus/npy_header`.
#![no_main]

#[path = "../../../formats/tests/hostile/mod.rs"]
mod hostile;

#[global_allocator]
static ALLOCATOR: cap::Cap<std::alloc::System> = cap::Cap::new(std::alloc::System, 64 << 20);

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| hostile::npy_header(bytes));
