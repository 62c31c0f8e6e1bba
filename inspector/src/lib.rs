//! Looks at Rayscope recordings: what is in them, whether it is right, and what can be saved.
//!
//! - [`cli`]: the command line
//! - `info`, `verify`, `recover`: the commands that need no window and no GPU
//! - `plot`, `report`, `export`: the commands that make files: [`figures`], one page, rays for other programs
//! - `output`: tables, sizes and JSON on standard output

pub mod cli;
pub mod figures;
mod info;
mod output;
mod recover;
mod verify;
