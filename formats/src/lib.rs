//! What a dump is: its values, its bytes and their meaning. No GPU, no window, no scene loading.
//!
//! - [`ray`], [`unit_space`]: the values that everything else is made of
//! - [`key`]: layouts as data, from ray to key and back
//! - [`length_table`], [`permutation`], [`metrics`]: what is derived from rays and keys
//! - [`auto`]: which order a queue gets
//! - [`npy`], [`manifest`], [`folder`], [`writer`], [`reader`], [`verify`], [`recover`]: the files
//! - [`traced`], [`stored_table`]: what a dump's rays came to, and what was expected of them
//! - [`intersect`], [`holes`], [`hierarchy`]: how a ray meets boxes and triangles, and its way through a scene
//! - [`queue_check`]: whether recorded rays can be traced
//! - [`bench_result`]: what benchmarks print and figures read
//! - [`study`]: the folder of many recordings made from one plan
//! - [`summary`]: a dump in one object, for people and programs
//! - [`files`], [`text`]: whole files read and replaced with care; names from files on a terminal
//! - [`pages`], [`prefetch`]: memory that is read in no order, on huge pages and asked for ahead

mod array_file;
pub mod auto;
pub mod bench_result;
pub mod files;
pub mod folder;
pub mod hierarchy;
pub mod holes;
pub mod intersect;
pub mod key;
pub mod length_table;
pub mod manifest;
pub mod metrics;
pub mod npy;
pub mod pages;
pub mod permutation;
pub mod prefetch;
pub mod queue_check;
pub mod ray;
mod read_error;
pub mod reader;
pub mod recover;
pub mod stored_table;
pub mod study;
pub mod summary;
pub mod text;
pub mod traced;
pub mod unit_space;
pub mod verify;
pub mod writer;
