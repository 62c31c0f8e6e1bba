//! Numbers from Rust to WGSL.

use crate::device::kernel::constants_wgsl;

/// A float that WGSL reads back bit for bit.
///
/// # Panics
/// If it is infinite or not a number, which WGSL has no literals for: what comes from outside is checked
/// before a kernel is written.
pub fn wgsl_f32(value: f32) -> String {
    assert!(value.is_finite(), "WGSL has no literal for {value}");
    format!("{value:?}f")
}

/// One constant each.
pub fn wgsl_constants(floats: &[(&str, f32)], integers: &[(&str, u32)]) -> String {
    let floats = floats.iter().map(|(name, value)| format!("const {name} = {};\n", wgsl_f32(*value)));
    floats.collect::<String>() + &constants_wgsl(integers)
}

/// A constant array of floats.
pub fn wgsl_f32_array(name: &str, values: &[f32]) -> String {
    let list: Vec<_> = values.iter().map(|&value| wgsl_f32(value)).collect();
    format!("const {name} = array<f32, {}>({});\n", values.len(), list.join(", "))
}
