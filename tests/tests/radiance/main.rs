//! Pictures whose radiance is known: from a formula, or from a path tracer over the oracle.
//!
//! Every pixel of a picture is one sample (a few passes of them), so the mean over the picture has a
//! confidence interval of its own; it must hold the known value within three standard errors, on every
//! backend, from a fixed seed. `cargo test -p tests --test radiance -- --nocapture` prints all of them.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod direct;
mod furnace;
mod path_tracer;
mod picture;
mod reference;
mod scene;
