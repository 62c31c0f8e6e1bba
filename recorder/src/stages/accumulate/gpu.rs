//! The module of the accumulate kernel.

use formats::key::Layout;
use formats::ray::Kind;
use formats::unit_space::UnitSpace;

use crate::device::Module;
use crate::stages::key::gpu::traced_length;
use crate::stages::key::wgsl::{constants, encode_function};

/// Bindings: origins, directions, hits or distances; sums, counts.
pub fn module(kind: Kind, unit: &UnitSpace, table_layout: &Layout, table_bits: u32) -> Module {
    let module = Module::new(&format!("accumulate::{kind}"))
        .items::<[f32; 4]>("origins")
        .items::<[f32; 4]>("directions");
    traced_length(module, kind)
        .counters("sums")
        .counters("counts")
        .text(&constants(unit))
        .text(include_str!("../key/kernel.wgsl"))
        .text(include_str!("../key/lengths.wgsl"))
        .text(&encode_function("table_cell", table_layout, table_bits, &[]))
        .text(include_str!("kernel.wgsl"))
}
