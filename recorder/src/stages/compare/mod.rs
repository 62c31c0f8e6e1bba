//! Compare: counts the results that differ from those of canonical order. A ray's result depends on that ray
//! alone, so there should be none.

pub mod cpu;
pub mod gpu;
