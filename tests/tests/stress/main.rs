//! Every kernel of every backend on what breaks tracers, held against the oracle.
//!
//! `cargo test -p tests --test stress -- --nocapture` prints a line per case and kernel: how many rays
//! escaped a closed surface, and what the oracle says of the answers. Own kernels must answer every ray
//! right; of `ray-query`, whose traversal is the driver's, the count is shown.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod closed;
mod numbers;
mod odd_rays;
mod odd_triangles;
mod runner;
mod secondary;
mod shapes;
mod spawned;
