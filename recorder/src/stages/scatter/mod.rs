//! Scatter: brings what gathered rays found home to canonical places.

pub mod cpu;
pub mod gpu;
