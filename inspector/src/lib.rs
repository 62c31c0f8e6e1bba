//! Looks at Rayscope recordings: what is in them, whether it is right, and what can be saved.
//!
//! - [`cli`]: the command line; `arguments`: words that several commands take
//! - [`analysis`]: whole recordings by the numbers of `formats::metrics`
//! - [`filter`]: which rays of an order meet a condition that is typed
//! - [`figures`]: figures as data, and the catalogue of them; [`colour_map`]: from numbers to colours
//! - `info`, `verify`, `recover`: the commands that need no window and no GPU
//! - `method_table`: analyses as text
//! - `plot`, `report`, `export`: the commands that make files: [`figures`], one page, rays for other programs
//! - [`model`]: what the window shows, without a window; [`render`]: what it draws in space
//! - [`panels`], [`app`]: the window; `shot`: the same without a screen; [`theme`]: its colours
//! - [`session`], [`recent`]: what a window shows, to come back to and to repeat
//! - `shown`: names that files give, fit to be shown; `output`: all that is printed, tables, names and sizes as text; `png_file`: pictures

#![deny(clippy::print_stdout, clippy::print_stderr)]

pub mod analysis;
pub mod app;
mod arguments;
pub mod cli;
pub mod colour_map;
mod export;
pub mod figures;
pub mod filter;
mod info;
mod inputs;
mod method_table;
pub mod model;
mod output;
pub mod panels;
mod plot;
mod png_file;
pub mod recent;
mod recover;
pub mod render;
pub mod report;
pub mod session;
mod shot;
mod shown;
pub mod theme;
mod verify;
