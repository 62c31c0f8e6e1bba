//! Looks at Rayscope recordings: what is in them, whether it is right, and what can be saved.
//!
//! - [`cli`]: the command line
//! - [`analysis`]: whole recordings by the numbers of `formats::metrics`
//! - `info`, `verify`, `recover`: the commands that need no window and no GPU
//! - `method_table`: analyses as text
//! - `output`: tables, sizes and JSON on standard output

pub mod analysis;
pub mod cli;
mod info;
mod method_table;
mod output;
mod recover;
mod verify;
