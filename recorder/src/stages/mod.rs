//! The stages of a ray reordering path tracer, one folder each.
//!
//! Every stage has what it does in `mod.rs`, the GPU's code in WGSL beside it and the same on
//! threads in Rust.

pub mod accumulate;
pub mod compact;
pub mod gather;
pub mod generate;
pub mod key;
pub mod random;
pub mod shade;
pub mod shared;
pub mod sort;
pub mod trace;
pub mod vector;

pub use shared::{SharedStruct, shared_structs};

/// Label and WGSL of every module that a run can compile: scenes with all features and with none,
/// all methods at 32 and 64 bits, every trace kernel. For tests that look at all of them.
pub fn all_shader_sources() -> Vec<(String, String)> {
    crate::gpu::kernels::every_module()
        .iter()
        .map(|module| (module.label().to_owned(), module.wgsl()))
        .collect()
}
