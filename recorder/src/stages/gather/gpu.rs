//! The module of the gather kernel.

use crate::device::Module;
use crate::stages::shared::Span;

/// Bindings: order, origins, directions; gathered origins, gathered directions.
pub fn module() -> Module {
    Module::new("gather::main")
        .immediate::<Span>("span", "Span")
        .read("order", "u32")
        .read("origins", "vec4<f32>")
        .read("directions", "vec4<f32>")
        .write("gathered_origins", "vec4<f32>")
        .write("gathered_directions", "vec4<f32>")
        .text(&Span::description().wgsl)
        .text(include_str!("kernel.wgsl"))
}
