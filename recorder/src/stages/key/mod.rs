//! Key: from each ray to the number that it is sorted by, as the methods compared by Meister et al. (2020) make it: Morton
//! codes of origins, directions and estimated ends.
//!
//! The bits come from a layout (`formats::key::layout`); threads run `formats::key::Encoder`, the
//! GPU a kernel that [`wgsl`] generates from the same layout.

pub mod cpu;
pub mod gpu;
pub mod wgsl;
