//! The module of a method's key kernel.

use formats::key::{Coordinate, LightSite, Termination};
use formats::ray::{Hit, Kind};

use super::wgsl::{constants, encode_function, length_expression};
use crate::device::Module;
use crate::stages::setup::{MethodPlan, Setup};
use crate::stages::shared::LightSiteData;

/// Shape of a light with a place, in `LightSiteData`.
pub const SITE_PLACED: u32 = 0;
/// Shape of parallel light.
pub const SITE_DIRECTIONAL: u32 = 1;
/// Shape of light from everywhere.
pub const SITE_ENVIRONMENT: u32 = 2;

/// A light's site as the kernel reads it.
pub fn site_data(site: &LightSite) -> LightSiteData {
    match *site {
        LightSite::Placed { centre } => {
            LightSiteData { place: centre, shape: SITE_PLACED, ..LightSiteData::default() }
        }
        LightSite::Directional { direction, tangent, bitangent } => LightSiteData {
            place: direction,
            shape: SITE_DIRECTIONAL,
            tangent,
            bitangent,
            ..LightSiteData::default()
        },
        LightSite::Environment => LightSiteData { shape: SITE_ENVIRONMENT, ..LightSiteData::default() },
    }
}

/// What a method's key kernel binds beside the rays and the keys.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KeyInputs {
    /// The length table: sums, counts.
    pub table: bool,
    /// Hits, or distances of shadow rays.
    pub results: bool,
    /// States of shadow rays, which hold the light, and the sites of the lights.
    pub lights: bool,
    /// Path ids.
    pub paths: bool,
}

impl KeyInputs {
    /// Of a method for a kind of ray.
    pub fn of(method: &MethodPlan) -> Self {
        Self {
            table: method.termination == Termination::Adaptive,
            results: method.termination == Termination::Real,
            lights: method.layout.uses(Coordinate::needs_light),
            paths: method.layout.uses(Coordinate::needs_path),
        }
    }
}

/// Adds the binding and the function of traced lengths.
pub fn traced_length(module: Module, kind: Kind) -> Module {
    let none = crate::device::kernel::constants_wgsl(&[("NO_TRIANGLE", Hit::NONE)]);
    match kind {
        Kind::Closest => {
            module.items::<[u32; 4]>("hits").text(&none).text(include_str!("closest_length.wgsl"))
        }
        Kind::Shadow => module.items::<f32>("distances").text(include_str!("shadow_length.wgsl")),
    }
}

/// Bindings: origins, directions, then those of [`KeyInputs`] in their order, then low words of
/// the keys and, for more than 32 bits, high words.
pub fn module(setup: &Setup, method: &MethodPlan, kind: Kind) -> Module {
    let inputs = KeyInputs::of(method);
    let mut module = Module::new(&format!("key::{}", method.name))
        .items::<[f32; 4]>("origins")
        .items::<[f32; 4]>("directions");
    if inputs.table {
        module = module.table::<[u32; 2]>("sums").table::<u32>("counts");
    }
    if inputs.results {
        module = traced_length(module, kind);
    }
    if inputs.lights {
        module = module
            .items::<[u32; 4]>("states")
            .table::<LightSiteData>("light_sites")
            .text(&LightSiteData::description().wgsl);
    }
    if inputs.paths {
        module = module.items::<u32>("path_ids");
    }
    module = module.items_mut::<u32>("keys_low");
    if method.key_bits > 32 {
        module = module.items_mut::<u32>("keys_high");
    }
    let sites = [
        ("SITE_PLACED", SITE_PLACED),
        ("SITE_DIRECTIONAL", SITE_DIRECTIONAL),
        ("SITE_ENVIRONMENT", SITE_ENVIRONMENT),
    ];
    module = module
        .text(&constants(&setup.unit))
        .text(&crate::device::kernel::constants_wgsl(&sites))
        .text(include_str!("kernel.wgsl"))
        .text(&encode_function("encode", &method.layout, method.key_bits, &setup.light_sites));
    if inputs.table {
        module = module
            .text(include_str!("lengths.wgsl"))
            .text(&encode_function("table_cell", &setup.table_layout, setup.table_bits, &[]))
            .text(TABLE_LENGTH);
    }
    module.text(&main_function(method, inputs))
}

const TABLE_LENGTH: &str = "
fn table_length(ray: UnitRay) -> f32 {
    let cell = table_cell(ray, Facts()).x;
    return mean_length(sums[cell].x, sums[cell].y, counts[cell]);
}
";

fn main_function(method: &MethodPlan, inputs: KeyInputs) -> String {
    let length = length_expression(method.termination, method.two_point_length);
    let light = if inputs.lights { "states[index].w" } else { "0u" };
    let path = if inputs.paths { "path_ids[index]" } else { "0u" };
    let high = if method.key_bits > 32 { "    keys_high[index] = key.y;\n" } else { "" };
    format!(
        "fn run_item(index: u32) {{
    let ray = unit_ray(origins[index].xyz, directions[index].xyz, directions[index].w);
    let key = encode(ray, Facts({length}, {light}, {path}));
    keys_low[index] = key.x;
{high}}}
"
    )
}
