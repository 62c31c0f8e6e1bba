//! Prefix sums, and with them the compaction of queues: what lives moves together, in order.
//!
//! - [`gpu`]: exclusive prefix sum over the flags of live rays, and their number
//! - [`queue`]: the kernels that move a queue's live rays to the places that the sums give

pub mod cpu;
pub mod gpu;
pub mod queue;

/// `exclusive_sum(value, thread)`: the sum of the values of a workgroup's threads before this one.
///
/// Needs `SCAN_THREADS`, the threads of the workgroup, a power of two, and leaves the total in
/// `scan_sums[SCAN_THREADS - 1u]`. All threads must call it together; between two calls, and before
/// `scan_sums` is written in any other way, a barrier is needed.
pub const WORKGROUP_SCAN_WGSL: &str = include_str!("workgroup_scan.wgsl");
