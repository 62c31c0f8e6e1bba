//! The stages of a ray reordering path tracer, one folder each.
//!
//! Every stage has what it does in `mod.rs`, the GPU's code in WGSL beside it and the same on
//! threads in Rust.

pub mod accumulate;
pub mod compact;
pub mod compare;
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
/// all methods at 32 and 64 bits, every trace kernel, both ways to sort. For tests that look at all
/// of them.
pub fn all_shader_sources() -> Vec<(String, String)> {
    let modules = crate::gpu::kernels::every_module();
    let numbered = modules
        .iter()
        .enumerate()
        .map(|(number, module)| (format!("{} #{number}", module.label()), module.wgsl()));
    let mut sources: Vec<_> = numbered.collect();
    sources.extend(sort::gpu::sources());
    sources.push(("compact::places".to_owned(), compact::gpu::wgsl()));
    sources.push(("self_check".to_owned(), crate::gpu::self_check::WGSL.to_owned()));
    sources
}
