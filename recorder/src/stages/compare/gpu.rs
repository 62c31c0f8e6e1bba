//! The module of the compare kernel.

use formats::ray::Kind;

use crate::device::Module;
use crate::stages::shared::Span;

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
    let (element, differs) = match kind {
        Kind::Closest => ("vec4<u32>", SAME_HIT),
        Kind::Shadow => ("f32", SAME_OCCLUSION),
    };
    Module::new(&format!("compare::{kind}"))
        .immediate::<Span>("span", "Span")
        .read("results", element)
        .read("others", element)
        .write("counter", "atomic<u32>")
        .text(&Span::description().wgsl)
        .text(differs)
        .text(include_str!("kernel.wgsl"))
}
