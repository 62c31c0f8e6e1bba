//! Gather: copies rays into a sorted order, so that neighbours in the order are neighbours in memory.

pub mod cpu;
pub mod gpu;
