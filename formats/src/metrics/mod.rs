//! What recordings are judged by.

pub mod speedup;
