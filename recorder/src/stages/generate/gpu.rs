//! The module of the generate kernel.

use crate::device::Module;
use crate::stages::random;
use crate::stages::shared::GenerateParams;

/// Bindings: origins, directions, path ids, states.
pub fn module() -> Module {
    Module::with_parameters::<GenerateParams>("generate::main", "params")
        .items_mut::<[f32; 4]>("origins")
        .items_mut::<[f32; 4]>("directions")
        .items_mut::<u32>("path_ids")
        .items_mut::<[u32; 4]>("states")
        .text(&GenerateParams::description().wgsl)
        .text(&random::wgsl())
        .text(include_str!("../vector.wgsl"))
        .text(include_str!("kernel.wgsl"))
}
