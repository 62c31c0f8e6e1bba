//! The stages of a ray reordering path tracer, one folder each.
//!
//! Every stage has what it does in `mod.rs`, the GPU's code in WGSL beside it and the same on
//! threads in Rust.

pub mod accumulate;
pub mod compact;
pub mod compare;
pub mod eight;
pub mod gather;
pub mod generate;
pub mod key;
pub mod random;
pub mod scatter;
pub mod setup;
pub mod shade;
pub mod shared;
pub mod sort;
pub mod trace;
pub mod vector;
pub mod wgsl;

pub use shared::{SharedStruct, shared_structs};
