//! What kernels are told: types that WGSL has too, and the items of a dispatch.

use bytemuck::{NoUninit, Pod, Zeroable};

/// A type with a WGSL counterpart of the same bytes.
pub trait WgslType {
    /// Its name in WGSL.
    const NAME: &'static str;
}

macro_rules! wgsl_type {
    ($($rust:ty = $wgsl:literal),* $(,)?) => {
        $(impl WgslType for $rust { const NAME: &'static str = $wgsl; })*
    };
}

wgsl_type!(
    u32 = "u32",
    f32 = "f32",
    [u32; 2] = "vec2<u32>",
    [f32; 2] = "vec2<f32>",
    [f32; 3] = "vec3<f32>",
    [f32; 4] = "vec4<f32>",
    [u32; 4] = "vec4<u32>",
    Chunk = "Chunk",
);

/// Which items a dispatch is for.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct Chunk {
    /// The first item.
    pub first: u32,
    /// How many there are.
    pub count: u32,
}

impl Chunk {
    /// Cuts `0..items` into chunks of at most `largest`; none if there are no items.
    pub(super) fn split(items: u32, largest: u32) -> impl Iterator<Item = Chunk> {
        (0..items.div_ceil(largest)).map(move |index| {
            let first = index * largest;
            Chunk { first, count: largest.min(items - first) }
        })
    }
}

/// What a kernel is told: a struct of the same bytes in WGSL, with a chunk in its fields `first` and `count`.
pub trait Parameters: WgslType + NoUninit {
    /// The same for these items.
    fn of(self, chunk: Chunk) -> Self;
}

impl Parameters for Chunk {
    fn of(self, chunk: Chunk) -> Self {
        chunk
    }
}

/// Parameters of kernels that are told their items alone.
pub const ITEMS: Chunk = Chunk { first: 0, count: 0 };
