//! Looks at Rayscope recordings: what is in them, whether it is right, and what can be saved.
//!
//! - [`cli`]: the command line
//! - [`analysis`]: whole recordings by the numbers of `formats::metrics`
//! - [`figures`]: figures as data, and the catalogue of them
//! - `info`, `verify`, `recover`: the commands that need no window and no GPU
//! - `method_table`: analyses as text
//! - `plot`, `report`, `export`: the commands that make files: [`figures`], one page, rays for other programs
//! - `output`: tables, sizes and JSON on standard output

pub mod analysis;
pub mod cli;
mod export;
pub mod figures;
mod info;
mod inputs;
mod method_table;
mod output;
mod plot;
mod recover;
pub mod report;
mod verify;
