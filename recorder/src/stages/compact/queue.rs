//! The module of the kernel that moves live candidates together.

use crate::gpu::Module;
use crate::stages::shared::Span;

/// Bindings: flags, places (exclusive prefix sum of the flags), origins, directions, states, path
/// ids; then the four live arrays in the same order.
pub fn module() -> Module {
    Module::new("compact::queue")
        .immediate::<Span>("span", "Span")
        .read("flags", "u32")
        .read("places", "u32")
        .read("origins", "vec4<f32>")
        .read("directions", "vec4<f32>")
        .read("states", "vec4<u32>")
        .read("path_ids", "u32")
        .write("live_origins", "vec4<f32>")
        .write("live_directions", "vec4<f32>")
        .write("live_states", "vec4<u32>")
        .write("live_path_ids", "u32")
        .text(&Span::description().wgsl)
        .text(include_str!("queue.wgsl"))
}
