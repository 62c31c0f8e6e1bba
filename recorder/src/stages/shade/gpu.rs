//! The modules of the shade kernel and of adding light, composed for what a scene uses.

use scenes::features::Features;

use super::bsdf::{DIELECTRIC_F0, MIRROR_ALPHA};
use super::emitters::{
    EMITTER_DIRECTIONAL, EMITTER_POINT, EMITTER_SKY, EMITTER_SPHERE, EMITTER_SPOT, EMITTER_TRIANGLE,
    SHORT_OF_TRIANGLE,
};
use super::path::ROULETTE_FREE_BOUNCES;
use super::surface::{OFFSET_OF_POINT, OFFSET_OF_TRIANGLE};
use super::tables::NO_TEXTURE;
use crate::gpu::Module;
use crate::stages::generate::gpu::random_text;
use crate::stages::key::wgsl::wgsl_f32;
use crate::stages::shared::{Emitter, MaterialData, PathState, ShadeParams, Span, TextureData};
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

/// Bindings: directions, path ids, states, hits; triangles, positions, materials, emitters;
/// normals where the scene has them; uvs, textures, texels where it has those; then film, and
/// origins, directions, states and flags of the shadow rays and of the next rays.
pub fn module(features: &Features) -> Module {
    let mut module = Module::new("shade::main")
        .immediate::<ShadeParams>("params", "ShadeParams")
        .read("directions", "vec4<f32>")
        .read("path_ids", "u32")
        .read("states", "vec4<u32>")
        .read("hits", "vec4<u32>")
        .read("triangles", "vec4<u32>")
        .read("positions", "vec4<f32>")
        .read("materials", "MaterialData")
        .read("emitters", "Emitter");
    if features.vertex_normals {
        module = module.read("normals", "vec4<f32>");
    }
    if features.textures {
        module = module.read("uvs", "vec2<f32>").read("textures", "TextureData").read("texels", "u32");
    }
    module = module.write("film", "vec4<f32>");
    for queue in ["shadow", "next"] {
        module = module
            .write(&format!("{queue}_origins"), "vec4<f32>")
            .write(&format!("{queue}_directions"), "vec4<f32>")
            .write(&format!("{queue}_states"), "vec4<u32>")
            .write(&format!("{queue}_flags"), "u32");
    }
    for shared in [
        ShadeParams::description(),
        MaterialData::description(),
        TextureData::description(),
        Emitter::description(),
        PathState::description(),
    ] {
        module = module.text(&shared.wgsl);
    }
    module
        .text(&constants(features))
        .text(include_str!("../vector.wgsl"))
        .text(&random_text())
        .text(include_str!("bsdf.wgsl"))
        .text(include_str!("surface.wgsl"))
        .text(if features.vertex_normals { include_str!("normals.wgsl") } else { FLAT_NORMALS })
        .text(if features.textures { include_str!("texture.wgsl") } else { NO_TEXTURES })
        .text(include_str!("light.wgsl"))
        .text(include_str!("kernel.wgsl"))
}

/// Bindings: path ids, states, distances; film.
pub fn add_light_module() -> Module {
    Module::new("shade::add_light")
        .immediate::<Span>("span", "Span")
        .read("path_ids", "u32")
        .read("states", "vec4<u32>")
        .read("distances", "f32")
        .write("film", "vec4<f32>")
        .text(&Span::description().wgsl)
        .text(include_str!("add_light.wgsl"))
}

fn constants(features: &Features) -> String {
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
        ("NO_TEXTURE", NO_TEXTURE),
        ("NO_TRIANGLE", Hit::NONE),
        ("ROULETTE_FREE_BOUNCES", ROULETTE_FREE_BOUNCES),
    ];
    let floats = floats.map(|(name, value)| format!("const {name} = {};\n", wgsl_f32(value)));
    format!(
        "{}{}const GLOSSY = {};\n",
        floats.concat(),
        crate::gpu::kernel::constants_wgsl(&integers),
        features.specular
    )
}
