//! The modules of shading, composed for what a scene uses.
//!
//! Three kernels, since one that does it all binds 21 buffers where WebGPU promises 8: the surface at
//! each hit, then what follows from it for the shadow ray and for the next ray. Surfaces are kept for
//! one dispatch alone, so that a binding of theirs does not grow with the picture.

use scenes::features::Features;

use super::bsdf::{DIELECTRIC_F0, MIRROR_ALPHA};
use super::emitters::{
    EMITTER_DIRECTIONAL, EMITTER_POINT, EMITTER_SKY, EMITTER_SPHERE, EMITTER_SPOT, EMITTER_TRIANGLE,
};
use super::light::{LIGHT_DRAWS, SHORT_OF_TRIANGLE};
use super::path::ROULETTE_FREE_BOUNCES;
use super::surface::{OFFSET_OF_POINT, OFFSET_OF_TRIANGLE};
use crate::device::Module;
use crate::stages::random;
use crate::stages::shared::{Emitter, MaterialData, PathState, ShadeParams, SurfaceData};
use crate::stages::wgsl::wgsl_constants;
use formats::ray::Hit;

/// A scene without vertex normals.
const FLAT_NORMALS: &str = "
fn shading_normal(triangle: vec4<u32>, u: f32, v: f32, geometric_normal: vec3<f32>, direction: vec3<f32>) -> vec3<f32> {
    return geometric_normal;
}
";
/// A scene without textures.
const NO_TEXTURES: &str = "
fn texture_factor(triangle: vec4<u32>, material: MaterialData, u: f32, v: f32) -> vec3<f32> {
    return vec3(1.0);
}
";

/// A scene whose surfaces are all diffuse.
const MATT: &str = "
fn bsdf_evaluate(surface: Bsdf, out_direction: vec3<f32>, incident: vec3<f32>) -> BsdfValue {
    return diffuse_evaluate(surface, out_direction, incident);
}

fn bsdf_sample(surface: Bsdf, out_direction: vec3<f32>, random: ptr<function, u32>) -> BsdfSample {
    let choice = random_next(random);
    let a = random_next(random);
    let b = random_next(random);
    return diffuse_sample(surface, out_direction, a, b);
}
";
/// A scene without emissive triangles.
const NO_EMISSION: &str = "
fn emitted_radiance(direction: vec3<f32>, state: PathState, surface: SurfaceData) -> vec3<f32> {
    return vec3(0.0);
}
";
/// A scene without a sky.
const NO_SKY: &str = "
fn missed_radiance(direction: vec3<f32>, state: PathState) -> vec3<f32> {
    return vec3(0.0);
}
";

/// `sample_emitter`: the shapes that a scene has, one after the other.
fn sample_emitter(features: &Features) -> String {
    let shapes = [
        (features.sphere_lights, "EMITTER_SPHERE", "sample_sphere(emitter, point, a, b)"),
        (features.punctual_lights, "EMITTER_POINT", "sample_point(emitter, point)"),
        (features.punctual_lights, "EMITTER_SPOT", "sample_point(emitter, point)"),
        (features.punctual_lights, "EMITTER_DIRECTIONAL", "sample_directional(emitter)"),
        (features.emissive_triangles, "EMITTER_TRIANGLE", "sample_triangle(emitter, point, a, b)"),
        (features.environment, "EMITTER_SKY", "sample_sky(emitter, a, b)"),
    ];
    let used = shapes.iter().filter(|(is_used, ..)| *is_used);
    let cases = used.map(|(_, shape, sample)| format!("        case {shape}: {{ return {sample}; }}\n"));
    format!(
        "fn sample_emitter(emitter: Emitter, point: vec3<f32>, a: f32, b: f32) -> LightSample {{\n    \
         switch emitter.shape {{\n{}        default: {{ return LightSample(); }}\n    }}\n}}\n",
        cases.collect::<String>()
    )
}

fn composed(is_used: bool, with: &'static str, without: &'static str) -> &'static str {
    if is_used { with } else { without }
}

/// A module of shading with what all of them need.
fn new_module(label: &str) -> Module {
    Module::with_parameters::<ShadeParams>(label, "params")
        .text(&ShadeParams::description().wgsl)
        .text(&SurfaceData::description().wgsl)
        .text(&constants())
        .text(include_str!("../vector.wgsl"))
}

/// Bindings: directions, hits; triangles, positions, tables; normals where the scene has them; uvs
/// where it has textures; the surfaces, which begin with the dispatch.
pub fn surface_module(features: &Features) -> Module {
    let mut module = new_module("shade::surface")
        .items::<[f32; 4]>("directions")
        .items::<[u32; 4]>("hits")
        .table::<[u32; 4]>("triangles")
        .table::<[f32; 4]>("positions")
        .table::<u32>("tables");
    if features.vertex_normals {
        module = module.table::<[f32; 4]>("normals");
    }
    if features.textures {
        module = module.table::<[f32; 2]>("uvs");
    }
    let material = MaterialData::description();
    module
        .dispatch_items_mut::<SurfaceData>("surfaces")
        .text(&material.wgsl)
        .text(&material.wgsl_loader("load_material", "tables"))
        .text(include_str!("offset.wgsl"))
        .text(composed(features.vertex_normals, include_str!("normals.wgsl"), FLAT_NORMALS))
        .text(composed(features.textures, include_str!("texture.wgsl"), NO_TEXTURES))
        .text(include_str!("surface.wgsl"))
}

/// A module of what follows from surfaces. Bindings: surfaces, directions, path ids, states.
fn path_module(label: &str, features: &Features) -> Module {
    new_module(label)
        .dispatch_items::<SurfaceData>("surfaces")
        .items::<[f32; 4]>("directions")
        .items::<u32>("path_ids")
        .items::<[u32; 4]>("states")
        .text(&PathState::description().wgsl)
        .text(&random::wgsl())
        .text(include_str!("bsdf.wgsl"))
        .text(composed(features.specular, include_str!("glossy.wgsl"), MATT))
        .text(include_str!("reflection.wgsl"))
}

/// Bindings: surfaces, directions, path ids, states; emitters; film; directions and states of the
/// shadow rays.
pub fn shadow_module(features: &Features) -> Module {
    path_module("shade::shadow", features)
        .table::<Emitter>("emitters")
        .table_mut::<[f32; 4]>("film")
        .items_mut::<[f32; 4]>("shadow_directions")
        .items_mut::<[u32; 4]>("shadow_states")
        .text(&Emitter::description().wgsl)
        .text(include_str!("offset.wgsl"))
        .text(include_str!("weight.wgsl"))
        .text(include_str!("light.wgsl"))
        .text(composed(features.sphere_lights, include_str!("sphere_light.wgsl"), ""))
        .text(composed(features.punctual_lights, include_str!("punctual_light.wgsl"), ""))
        .text(composed(features.emissive_triangles, include_str!("emission.wgsl"), NO_EMISSION))
        .text(composed(features.environment, include_str!("sky.wgsl"), NO_SKY))
        .text(&sample_emitter(features))
        .text(include_str!("shadow.wgsl"))
}

/// Bindings: surfaces, directions, path ids, states; origins of both queues; directions and states of
/// the next rays.
pub fn next_module(features: &Features) -> Module {
    path_module("shade::next", features)
        .items_mut::<[f32; 4]>("origins")
        .items_mut::<[f32; 4]>("next_directions")
        .items_mut::<[u32; 4]>("next_states")
        .text(include_str!("next.wgsl"))
}

/// Bindings: path ids, states, distances; film.
pub fn add_light_module() -> Module {
    Module::new("shade::add_light")
        .items::<u32>("path_ids")
        .items::<[u32; 4]>("states")
        .items::<f32>("distances")
        .table_mut::<[f32; 4]>("film")
        .text(include_str!("add_light.wgsl"))
}

fn constants() -> String {
    let floats = [
        ("PI", std::f32::consts::PI),
        ("FRAC_1_PI", std::f32::consts::FRAC_1_PI),
        ("F32_MAX", f32::MAX),
        ("DIELECTRIC_F0", DIELECTRIC_F0),
        ("MIRROR_ALPHA", MIRROR_ALPHA),
        ("SHORT_OF_TRIANGLE", SHORT_OF_TRIANGLE),
        ("OFFSET_OF_POINT", OFFSET_OF_POINT),
        ("OFFSET_OF_TRIANGLE", OFFSET_OF_TRIANGLE),
    ];
    let integers = [
        ("EMITTER_SPHERE", EMITTER_SPHERE),
        ("EMITTER_POINT", EMITTER_POINT),
        ("EMITTER_SPOT", EMITTER_SPOT),
        ("EMITTER_DIRECTIONAL", EMITTER_DIRECTIONAL),
        ("EMITTER_TRIANGLE", EMITTER_TRIANGLE),
        ("EMITTER_SKY", EMITTER_SKY),
        ("MATERIAL_WORDS", (size_of::<MaterialData>() / size_of::<u32>()) as u32),
        ("LIGHT_DRAWS", LIGHT_DRAWS),
        ("NO_TRIANGLE", Hit::NONE),
        ("ROULETTE_FREE_BOUNCES", ROULETTE_FREE_BOUNCES),
    ];
    wgsl_constants(&floats, &integers) + "var<private> infinity_bits: u32 = 0x7f800000u;\n"
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::Rounding;

    /// What stands in the modules if and only if a scene has the feature; alpha masks are the trace kernel's.
    const MARKS: [(&str, &[&str]); 7] = [
        ("textures", &["texel_color", "uvs"]),
        ("emissive-triangles", &["sample_triangle", "params.emission_density", "case EMITTER_TRIANGLE:"]),
        ("sphere-lights", &["sample_sphere", "case EMITTER_SPHERE:"]),
        ("punctual-lights", &["sample_point", "case EMITTER_SPOT:", "sample_directional"]),
        ("environment", &["sky_radiance", "case EMITTER_SKY:"]),
        ("specular", &["ggx_distribution", "fresnel("]),
        ("vertex-normals", &["normals:", "normals["]),
    ];

    #[test]
    fn a_feature_is_in_the_module_if_and_only_if_the_scene_has_it() {
        let found = |features: &Features, mark: &str| {
            let modules = [surface_module(features), shadow_module(features), next_module(features)];
            modules.iter().any(|module| module.wgsl(Rounding::UNKNOWN).contains(mark))
        };
        for (name, feature) in Features::each() {
            let Some((_, marks)) = MARKS.iter().find(|(marked, _)| *marked == name) else {
                assert_eq!(name, "alpha-masks");
                continue;
            };
            for mark in *marks {
                assert!(found(&feature, mark), "{name}: {mark} is missing");
                assert!(!found(&Features::default(), mark), "{name}: {mark} is there for nothing");
                let others = Features::each().into_iter().filter(|(other, _)| *other != name);
                let others = others.fold(Features::default(), |all, (_, other)| all.union(other));
                assert!(!found(&others, mark), "{name}: {mark} is there for something else");
            }
        }
    }
}
