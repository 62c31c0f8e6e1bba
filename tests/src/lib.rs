//! What the whole-system tests share: where the sources are, the built programs, what they leave behind.
//!
//! - [`sources`]: the project's own files, for the tests that read them
//! - [`programs`]: `recorder` and `inspector` as a user runs them
//! - [`full_disk`]: the recorder where there is no room
//! - [`drivers`]: other Vulkan drivers, and the validation layer
//! - [`recordings`]: the arrays of a recording, byte by byte
//! - [`crafted`]: recordings that somebody changed, with right checksums
//! - [`slurm`]: a cluster on this machine
//! - [`studies`]: small studies, and what was made of them
//! - [`scene_files`]: small GLB files, sound and broken
//! - [`shapes`]: closed surfaces

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

pub mod crafted;
pub mod drivers;
pub mod full_disk;
pub mod programs;
pub mod recordings;
pub mod scene_files;
pub mod shapes;
#[cfg(target_os = "linux")]
pub mod slurm;
pub mod sources;
pub mod studies;
