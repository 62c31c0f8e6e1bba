//! Accumulate: adds each ray's traced length to its cell of the length table, from which the ends of later rays are
//! estimated (the adaptive two-point method of Meister et al. 2020).

pub mod cpu;
pub mod gpu;
