//! A wavefront path tracer that records what reordering does to its rays.
//!
//! [`wavefront`] is the loop, [`stages`] the verbs in it. [`backend`] is what the loop needs from a
//! device; [`cpu`] and [`gpu`] are the two that exist. [`measure`] times methods on a queue,
//! [`capture`] carries arrays to the dump, [`observer`] ties both to the loop, [`recording`] is a
//! whole run, [`replay`] one over rays that were recorded before, [`bench`] measures single stages.

pub mod backend;
pub mod bench;
pub mod cache_model;
pub mod capture;
pub mod cli;
mod comparison;
pub mod cpu;
pub mod device;
pub mod gpu;
mod interrupt;
pub mod measure;
pub mod observer;
pub mod options;
pub mod oracle;
pub mod progress;
pub mod recording;
pub mod replay;
pub mod report;
pub mod stages;
pub mod wavefront;
