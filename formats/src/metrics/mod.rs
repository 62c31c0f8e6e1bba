//! What recordings are judged by (docs/keys.md, "Coherence of an order").
//!
//! - [`order`]: which ray is at each place, and by which key
//! - [`capsule`], [`spread`], [`lanes`]: how coherent rays are; [`group`]: all of it of one group
//! - [`quantity`]: the numbers that a ray or its group has, by name: one entry each
//! - [`estimator`]: how far estimated ray lengths are from traced ones
//! - [`samples`]: the times of a recording; [`speedup`], [`bandwidth`], [`frame`], [`queue_times`]: what they say;
//!   [`views`]: means over many recordings; [`noise`]: what disturbed them
//! - [`correlation`]: how two numbers go together; [`growth`]: how costs grow

pub mod bandwidth;
pub mod capsule;
pub mod correlation;
pub mod estimator;
pub mod frame;
pub mod group;
pub mod growth;
pub mod lanes;
pub mod noise;
pub mod order;
pub mod quantity;
pub mod queue_times;
pub mod samples;
pub mod speedup;
pub mod spread;
pub mod views;

/// Rays of a group, as recordings are analysed unless told otherwise.
pub const GROUP_RAYS: usize = 64;
