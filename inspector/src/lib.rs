//! Looks at Rayscope recordings: what is in them, whether it is right, and what can be saved.
//!
//! - [`cli`]: the command line
//! - [`analysis`]: whole recordings by the numbers of `formats::metrics`
//! - [`figures`]: figures as data, and the catalogue of them
//! - `info`, `verify`, `recover`: the commands that need no window and no GPU
//! - `method_table`: analyses as text
//! - `output`: tables, sizes and JSON on standard output

pub mod analysis;
pub mod cli;
pub mod figures;
mod info;
mod method_table;
mod output;
mod recover;
mod verify;
