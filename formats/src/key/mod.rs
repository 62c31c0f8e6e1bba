//! Sorting keys: what goes into them, in which order, and how to read them back.
//!
//! - [`layout`]: a key's bits as data; [`layout_text`]: the words for them that users type, read by `layout_parser`
//! - [`method`]: the paper's methods and those beyond it, each a layout and a length estimate
//! - [`coordinates`], [`angle`], [`termination`]: the numbers that the bits are taken from
//! - [`hilbert`]: from coordinates to the place along a curve, and back
//! - [`facts`], [`extent`]: what is known of a ray beside itself, and how much a layout has to number
//! - [`encode`], [`decode`]: from ray to key and back to fields; `block` and `spread` are the parts of the encoder

pub mod angle;
mod block;
pub mod coordinates;
pub mod decode;
pub mod encode;
pub mod extent;
pub mod facts;
pub mod hilbert;
pub mod layout;
mod layout_parser;
pub mod layout_text;
pub mod light_site;
pub mod method;
mod spread;
pub mod termination;

pub use encode::{Encoder, Word};
pub use extent::{Extent, Tiles};
pub use facts::{Facts, NO_FACTS};
pub use layout::{Bit, Coordinate, Layout, Source};
pub use layout_text::{LayoutError, LayoutText};
pub use light_site::LightSite;
pub use method::{Method, MethodError, Termination};

/// Widest key; layouts describe this many bits, keys are prefixes of them.
pub const LAYOUT_BITS: u32 = 64;
/// Narrowest key.
pub const KEY_BITS_MIN: u32 = 8;
/// Bits to which every coordinate but the indices of lights and tiles is quantised before a layout takes its share.
pub const COORDINATE_BITS: u32 = 22;
