//! What is drawn in space: vertex data made on the CPU, and the pipelines that draw it.
//!
//! - [`range`]: what the ends of a colour bar stand for
//! - [`detail`]: how many of how many
//! - [`geometry`]: the vertices of curves, rays, capsules and cells; [`surfaces`]: of the scene
//! - [`cell_box`]: where a cell of the length table lies
//! - [`camera`]: from where
//! - [`picture`]: all of a picture, as data
//! - [`gpu`]: pictures on a GPU, in egui's paint callbacks
//!
//! Everything lies in unit space.

pub mod camera;
pub mod cell_box;
pub mod detail;
pub mod geometry;
pub mod gpu;
pub mod picture;
pub mod range;
pub mod surfaces;
