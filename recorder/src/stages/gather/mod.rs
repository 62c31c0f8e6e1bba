//! Gather: copies rays, or whole paths, into a sorted order, so that neighbours in the order are neighbours in
//! memory.

pub mod cpu;
pub mod gpu;
