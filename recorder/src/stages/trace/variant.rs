//! The modules that trace, composed per hierarchy, kind of ray, order and alpha masks.

use formats::intersect::{GAMMA_8, RECIPROCAL_LIMIT};
use formats::ray::{Hit, Kind};
use scenes::bvh::{BVH2_STACK, CWBVH_STACK};

use super::{LeafForm, Order, Precision, TraceKernel, TriangleTest};
use crate::device::Module;
use crate::stages::shared::MaskedTriangle;
use crate::stages::wgsl::wgsl_constants;

/// What a trace kernel is specialised on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TraceVariant {
    /// What walks which hierarchy.
    pub kernel: TraceKernel,
    /// Kind of rays.
    pub kind: Kind,
    /// Their order.
    pub order: Order<()>,
    /// What leaves hold.
    pub leaves: LeafForm,
    /// Whether the scene has alpha masks.
    pub masks: bool,
    /// Writes counters instead of results.
    pub count_work: bool,
    /// How triangles and boxes are tested.
    pub precision: Precision,
}

const NO_MASKS: &str = "
fn is_hole(triangle: u32, u: f32, v: f32) -> bool {
    return false;
}
";
const CLOSEST_RESULT: &str = "
fn write_result(place: u32, query: ptr<function, Query>) {
    let is_hit = (*query).best_triangle != NO_TRIANGLE;
    let t = select(0x7f800000u, bitcast<u32>((*query).best_t), is_hit);
    results[place] = vec4(t, (*query).best_triangle, bitcast<u32>((*query).best_u), bitcast<u32>((*query).best_v));
}
";
const SHADOW_RESULT: &str = "
var<private> infinity_bits: u32 = 0x7f800000u;

fn write_result(place: u32, query: ptr<function, Query>) {
    results[place] = select(bitcast<f32>(infinity_bits), (*query).best_t, (*query).best_triangle != NO_TRIANGLE);
}
";
const WORK_RESULT: &str = "
fn write_result(place: u32, query: ptr<function, Query>) {
    results[place] = (*query).work;
}
";

impl TraceVariant {
    /// The module. Bindings: origins, directions; the permutation where there is one;
    /// results; leaves (or scene triangles), positions where those do not hold them; the masks where there are any; the nodes or the driver's hierarchy.
    pub fn module(&self) -> Module {
        let place = match self.order {
            Order::Stored => "index",
            Order::Indirect(()) => "permutation[index]",
        };
        let places = format!("fn place_of(index: u32) -> u32 {{ return {place}; }}");
        let mut module = Module::new(&format!("trace::{}_{}", self.kernel.name(), self.kind))
            .items::<[f32; 4]>("origins")
            .items::<[f32; 4]>("directions");
        if self.order != Order::Stored {
            module = module.items::<u32>("permutation");
        }
        module = match (self.count_work, self.kind) {
            (true, _) => module.items_mut::<[u32; 2]>("results").text(WORK_RESULT),
            (false, Kind::Closest) => module.items_mut::<[u32; 4]>("results").text(CLOSEST_RESULT),
            (false, Kind::Shadow) => module.items_mut::<f32>("results").text(SHADOW_RESULT),
        };
        module = self.leaves.declare(module);
        module = if self.masks {
            let masked = MaskedTriangle::description();
            let loader = masked.wgsl_loader("load_mask", "masks");
            module.table::<u32>("masks").text(&masked.wgsl).text(&loader).text(include_str!("mask.wgsl"))
        } else {
            module.text(NO_MASKS)
        };
        module = match self.kernel.bvh_kind() {
            None => module.driver_hierarchy("hierarchy"),
            Some(_) => module.table::<[u32; 4]>("nodes"),
        };
        module
            .text(&self.constants())
            .text(&places)
            .text(include_str!("../vector.wgsl"))
            .text(match self.precision.triangles {
                TriangleTest::Watertight => include_str!("triangle.wgsl"),
                TriangleTest::MoellerTrumbore => include_str!("moeller_trumbore.wgsl"),
            })
            .text(include_str!("query.wgsl"))
            .text(self.kernel.wgsl().unwrap_or_default())
            .text(include_str!("kernel.wgsl"))
    }

    fn constants(&self) -> String {
        let floats = [
            ("PADDING", self.precision.boxes.padding()),
            ("RECIPROCAL_LIMIT", RECIPROCAL_LIMIT),
            ("RECIPROCAL_THRESHOLD", 1.0 / RECIPROCAL_LIMIT),
            ("F32_MAX", f32::MAX),
            ("GAMMA_8", GAMMA_8),
        ];
        let integers = [
            ("BVH2_STACK", BVH2_STACK as u32),
            ("CWBVH_STACK", CWBVH_STACK as u32),
            ("NO_TRIANGLE", Hit::NONE),
        ];
        let (any, count) = (self.kind == Kind::Shadow, self.count_work);
        wgsl_constants(&floats, &integers) + &format!("const ANY = {any};\nconst COUNT = {count};\n")
    }
}

#[cfg(test)]
mod tests {
    use clap::ValueEnum;

    use super::*;
    use crate::device::Rounding;

    #[test]
    fn alpha_masks_are_in_the_module_if_and_only_if_the_scene_has_them() {
        let (kind, order, leaves, count_work) = (Kind::Closest, Order::Stored, LeafForm::Gathered, false);
        for &kernel in TraceKernel::value_variants().iter().filter(|kernel| kernel.is_for_gpus()) {
            for masks in [false, true] {
                let precision = Precision::default();
                let variant = TraceVariant { kernel, kind, order, leaves, masks, count_work, precision };
                let text = variant.module().wgsl(Rounding::UNKNOWN);
                for mark in ["masks:", "load_mask", "MaskedTriangle"] {
                    assert_eq!(text.contains(mark), masks, "{mark} by {}", kernel.name());
                }
            }
        }
    }
}
