//! The modules of the kernels that move live candidates together: rays first, then their paths, since
//! a kernel has few bindings.

use crate::device::Module;

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
    Module::new(label).items::<[f32; 4]>("directions").items::<u32>("places").text(include_str!("live.wgsl"))
}

/// Further bindings: origins; live origins, live directions.
pub fn ray_module() -> Module {
    module("compact::rays")
        .items::<[f32; 4]>("origins")
        .table_mut::<[f32; 4]>("live_origins")
        .table_mut::<[f32; 4]>("live_directions")
        .text(MOVE_RAY)
        .text(include_str!("queue.wgsl"))
}

/// Further bindings: states, path ids; live states, live path ids.
pub fn path_module() -> Module {
    module("compact::paths")
        .items::<[u32; 4]>("states")
        .items::<u32>("path_ids")
        .table_mut::<[u32; 4]>("live_states")
        .table_mut::<u32>("live_path_ids")
        .text(MOVE_PATH)
        .text(include_str!("queue.wgsl"))
}
