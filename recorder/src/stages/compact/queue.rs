//! The modules of the kernels that move live candidates together: rays first, then their paths, since
//! a kernel has few bindings.

use crate::device::Module;
use crate::stages::shared::Span;

const MOVE_RAY: &str = "
fn move_item(index: u32, place: u32) {
    live_origins[place] = origins[index];
    live_directions[place] = directions[index];
}
";
const MOVE_PATH: &str = "
fn move_item(index: u32, place: u32) {
    live_states[place] = states[index];
    live_path_ids[place] = path_ids[index];
}
";

/// Bindings: directions of the candidates, places that the scan gave.
fn module(label: &str) -> Module {
    Module::new(label)
        .immediate::<Span>("span", "Span")
        .read("directions", "vec4<f32>")
        .read("places", "u32")
        .text(&Span::description().wgsl)
        .text(include_str!("live.wgsl"))
}

/// Further bindings: origins; live origins, live directions.
pub fn ray_module() -> Module {
    module("compact::rays")
        .read("origins", "vec4<f32>")
        .write("live_origins", "vec4<f32>")
        .write("live_directions", "vec4<f32>")
        .text(MOVE_RAY)
        .text(include_str!("queue.wgsl"))
}

/// Further bindings: states, path ids; live states, live path ids.
pub fn path_module() -> Module {
    module("compact::paths")
        .read("states", "vec4<u32>")
        .read("path_ids", "u32")
        .write("live_states", "vec4<u32>")
        .write("live_path_ids", "u32")
        .text(MOVE_PATH)
        .text(include_str!("queue.wgsl"))
}
