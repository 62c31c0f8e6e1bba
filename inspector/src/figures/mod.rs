//! Figures: what they show and how they are saved.
//!
//! - [`model`]: a figure as data
//! - [`catalogue`]: every figure that recordings and benchmark results can give

pub mod catalogue;
pub mod model;
