//! A wavefront path tracer that records what reordering does to its rays.
//!
//! Rooms, lowest first; each knows those before it alone. [`clock`] takes times, [`device`] is the GPU itself, [`stages`] what runs
//! on it and on threads, [`machine`] opens and checks what a run needs, [`backends`] offer the stages as verbs.
//! [`wavefront`] is the loop over them, [`measure`] times methods on a queue, [`capture`] carries arrays to the
//! dump, [`observer`] ties both to the loop. [`recording`] is a whole run, [`replay`] one over rays that were
//! recorded before, [`bench`] measures single stages, [`study`] makes many recordings, [`cli`] is what is typed. [`oracle`] stands apart: the
//! exact answers.

pub mod auto;
pub mod backends;
pub mod bench;
pub mod cache_model;
pub mod calibrate;
pub mod capture;
pub mod cli;
pub mod clock;
mod comparison;
pub mod device;
pub mod foreign;
mod interrupt;
pub mod machine;
pub mod measure;
pub mod observer;
pub mod options;
pub mod oracle;
mod output;
pub mod progress;
pub mod recording;
pub mod replay;
pub mod report;
pub mod stages;
pub mod study;
pub mod wavefront;
