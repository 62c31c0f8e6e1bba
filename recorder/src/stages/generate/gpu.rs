//! The module of the generate kernel.

use crate::gpu::Module;
use crate::stages::key::wgsl::wgsl_f32_array;
use crate::stages::random::{COSINE, SINE};
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
        .text(&random_text())
        .text(include_str!("../vector.wgsl"))
        .text(include_str!("kernel.wgsl"))
}

/// Random numbers with their constants.
pub fn random_text() -> String {
    wgsl_f32_array("SINE", &SINE) + &wgsl_f32_array("COSINE", &COSINE) + include_str!("../random.wgsl")
}
