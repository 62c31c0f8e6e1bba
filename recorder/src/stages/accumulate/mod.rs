//! Accumulate: adds each ray's traced length to its cell of the length table.

pub mod cpu;
pub mod gpu;
