//! What recordings are judged by (KEYS, "Coherence of an order").
//!
//! - [`capsule`], [`spread`], [`lanes`]: how coherent an order's groups of rays are
//! - [`estimator`]: how far estimated ray lengths are from traced ones
//! - [`speedup`], [`bandwidth`]: what times say
//! - [`correlation`]: how two numbers go together

pub mod bandwidth;
pub mod capsule;
pub mod correlation;
pub mod estimator;
pub mod lanes;
pub mod speedup;
pub mod spread;

/// Rays of a group, as recordings are analysed unless told otherwise.
pub const GROUP_RAYS: usize = 64;
