//! What the window shows, without a window: recordings, what of them is selected, and their numbers.
//!
//! - [`selection`]: the one selection that all panels share
//! - [`recording`]: an open recording
//! - [`queue`], [`order`]: the rays of a queue, and one order of them, as they are mapped
//! - [`path`]: the rays of paths in all bounces
//! - [`history`]: selections to go back to
//! - [`groups`]: capsules, direction spread and lane utilisation of each group of an order
//! - [`numbers`]: what the numbers of an order's rays are read from; [`colour_by`]: what colours stand for
//! - [`key`]: a key field by field
//! - [`rows`]: the rays that pass, sorted by any of their numbers
//! - [`what_if`]: another order of the recorded rays, made here
//! - [`coherences`]: how coherent the orders of a queue are, found in the background
//! - [`background`]: work on another thread; [`absent`]: why something is not shown; [`derived`], `asked`: what panels ask for that takes such work
//! - `ranking`: all orders of a queue, the one that gains most first
//! - [`context`]: all of it together, as panels see it

pub mod absent;
mod asked;
pub mod background;
pub mod coherences;
pub mod colour_by;
pub mod context;
pub mod derived;
pub mod groups;
pub mod history;
pub mod key;
pub mod numbers;
pub mod order;
pub mod path;
pub mod queue;
mod ranking;
pub mod recording;
pub mod rows;
pub mod selection;
pub mod what_if;

pub use absent::Absent;
pub use context::Context;
pub use order::Order;
pub use queue::Queue;
pub use recording::Recording;
pub use selection::Selection;
