//! The module of the compare kernel.

use formats::ray::Kind;

use crate::device::Module;

/// All of a hit is compared.
const SAME_HIT: &str = "
fn differs(index: u32) -> bool {
    return any(results[index] != others[index]);
}
";
/// Shadow rays only say whether the light is seen.
const SAME_OCCLUSION: &str = "
fn differs(index: u32) -> bool {
    return (bitcast<u32>(results[index]) == 0x7f800000u) != (bitcast<u32>(others[index]) == 0x7f800000u);
}
";

/// Bindings: results, others; counter.
pub fn module(kind: Kind) -> Module {
    let module = Module::new(&format!("compare::{kind}"));
    let module = match kind {
        Kind::Closest => module.items::<[u32; 4]>("results").items::<[u32; 4]>("others").text(SAME_HIT),
        Kind::Shadow => module.items::<f32>("results").items::<f32>("others").text(SAME_OCCLUSION),
    };
    module.counters("counter").text(include_str!("kernel.wgsl"))
}
