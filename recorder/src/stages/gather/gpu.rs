//! The module of the gather kernel.

use crate::device::Module;

/// Bindings: order, origins, directions; gathered origins, gathered directions.
pub fn module() -> Module {
    Module::new("gather::main")
        .items::<u32>("order")
        .items::<[f32; 4]>("origins")
        .items::<[f32; 4]>("directions")
        .items_mut::<[f32; 4]>("gathered_origins")
        .items_mut::<[f32; 4]>("gathered_directions")
        .text(include_str!("kernel.wgsl"))
}
