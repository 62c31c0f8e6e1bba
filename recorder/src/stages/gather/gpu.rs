//! The modules of the gather kernels: rays first, then what their paths carry, since a kernel has few bindings.

use crate::device::Module;

const GATHER_PATH: &str = "
fn run_item(place: u32) {
    let index = order[place];
    gathered_path_ids[place] = path_ids[index];
    gathered_states[place] = states[index];
}
";

/// Bindings: order, origins, directions; gathered origins, gathered directions.
pub fn ray_module() -> Module {
    Module::new("gather::rays")
        .items::<u32>("order")
        .items::<[f32; 4]>("origins")
        .items::<[f32; 4]>("directions")
        .items_mut::<[f32; 4]>("gathered_origins")
        .items_mut::<[f32; 4]>("gathered_directions")
        .text(include_str!("kernel.wgsl"))
}

/// Bindings: order, path ids, states; gathered path ids, gathered states.
pub fn path_module() -> Module {
    Module::new("gather::paths")
        .items::<u32>("order")
        .items::<u32>("path_ids")
        .items::<[u32; 4]>("states")
        .items_mut::<u32>("gathered_path_ids")
        .items_mut::<[u32; 4]>("gathered_states")
        .text(GATHER_PATH)
}
