//! The module of the generate kernel.

use crate::device::Module;
use crate::stages::random;
use crate::stages::shared::GenerateParams;

/// Bindings: origins, directions, path ids, states.
pub fn module() -> Module {
    Module::new("generate::main")
        .immediate::<GenerateParams>("params", "GenerateParams")
        .write("origins", "vec4<f32>")
        .write("directions", "vec4<f32>")
        .write("path_ids", "u32")
        .write("states", "vec4<u32>")
        .text(&GenerateParams::description().wgsl)
        .text(&random::wgsl())
        .text(include_str!("../vector.wgsl"))
        .text(include_str!("kernel.wgsl"))
}
