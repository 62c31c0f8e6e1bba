//! The scene in space, with rays, the curve of their order, capsules and table cells: what panels show it with.
//!
//! - [`options`]: what is shown, and how
//! - [`layers`]: from a selection to vertices, made anew only when it changes; `places`: of which places
//! - [`meshes`]: surfaces, read once for all views
//! - `view`: a view, and the picture that comes of it
//! - `controls`: the row above the picture; `bars`: the slider and the colour bars below
//! - `input`: pointer and keys

mod bars;
mod controls;
mod input;
pub mod layers;
pub mod meshes;
pub mod options;
mod places;
mod view;

pub(super) use self::view::SpaceState;
pub use self::view::{SpaceView, ViewSetup, cut};
