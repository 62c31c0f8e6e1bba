//! What the window shows, without a window: recordings, what of them is selected, and their numbers.
//!
//! - [`selection`]: the one selection that all panels share
//! - [`recording`]: an open recording
//! - [`queue`], [`order`]: the rays of a queue, and one order of them, as they are mapped
//! - [`image_plane`]: where on the picture a ray's path starts; [`path`]: its rays in all bounces;
//!   [`visits`]: the boxes that it enters
//! - [`history`]: selections to go back to
//! - [`groups`]: capsules, direction spread and lane utilisation of each group of an order
//! - [`numbers`]: what the numbers of an order's rays are read from; [`colour_by`]: what colours stand for
//! - [`key`]: a key field by field; [`jumps`]: the longest jumps of an order;
//!   [`neighbours`]: means over rays that end near each other
//! - [`filter`]: which rays are shown
//! - [`rows`]: the rays that pass, sorted by any of their numbers; [`estimates`]: the length table against
//!   the lengths that were traced
//! - [`what_if`]: another order of the recorded rays, made here
//! - [`coherences`]: how coherent the orders of a queue are, found in the background
//! - [`background`]: work on another thread; [`absent`]: why something is not shown; [`derived`], `asked`: what panels ask for that takes such work
//! - `ranking`: all orders of a queue, the one that gains most first
//! - [`comparison`], [`differences`]: two orders ray by ray; two recordings as a table of what differs
//! - [`context`]: all of it together, as panels see it

pub mod absent;
mod asked;
pub mod background;
pub mod coherences;
pub mod colour_by;
pub mod comparison;
pub mod context;
pub mod derived;
pub mod differences;
pub mod estimates;
pub mod filter;
pub mod groups;
pub mod history;
pub mod image_plane;
pub mod jumps;
pub mod key;
pub mod neighbours;
pub mod numbers;
pub mod order;
pub mod path;
pub mod queue;
mod ranking;
pub mod recording;
pub mod rows;
pub mod selection;
pub mod visits;
pub mod what_if;

pub use absent::Absent;
pub use context::Context;
pub use order::Order;
pub use queue::Queue;
pub use recording::Recording;
pub use selection::Selection;
