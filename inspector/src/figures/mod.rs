//! Figures: from numbers to files that a paper can take as they are.
//!
//! - [`model`]: a figure as data
//! - [`catalogue`]: which figures there are
//! - [`style`]: widths, sizes, colours, markers and dashes; [`method_style`]: which a method has
//! - [`draw`]: the drawing, each panel a chart of plotters: `svg` is its backend, `axis` its coordinates with
//!   our ticks, `series` what it shows, of `mark`s. Ours are `layout` (the room for words), `tick_labels`
//!   (broken, slanted, upright), `legend`, `line_names` (the same beside lines) and `text` (widths)
//! - [`raster`]: PNG and PDF from the SVG
//! - [`csv`], [`pgfplots`]: the numbers, the same figure in LaTeX
//! - [`files`]: all of them in a folder, with the words

pub(crate) mod axis;
pub mod catalogue;
pub mod csv;
pub mod draw;
pub mod files;
#[cfg(test)]
mod gallery;
mod layout;
mod legend;
mod line_names;
mod mark;
pub mod method_style;
pub mod model;
pub mod pgfplots;
pub mod raster;
mod series;
pub mod style;
pub(crate) mod svg;
mod text;
mod tick_labels;

use std::path::PathBuf;

/// Why a figure cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum FigureError {
    /// It was drawn, but a file format refused it.
    #[error("a figure cannot be converted: {0}")]
    Render(String),
    /// A file or folder cannot be written.
    #[error("cannot write {}: {cause}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What the system said.
        cause: std::io::Error,
    },
}
