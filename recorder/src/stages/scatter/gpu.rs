//! The module of the scatter kernel.

use formats::ray::Kind;

use crate::device::Module;

/// Bindings: order, results; results at canonical places.
pub fn module(kind: Kind) -> Module {
    let module = Module::new(&format!("scatter::{kind}")).items::<u32>("order");
    let module = match kind {
        Kind::Closest => module.items::<[u32; 4]>("results").items_mut::<[u32; 4]>("home"),
        Kind::Shadow => module.items::<f32>("results").items_mut::<f32>("home"),
    };
    module.text(include_str!("kernel.wgsl"))
}
