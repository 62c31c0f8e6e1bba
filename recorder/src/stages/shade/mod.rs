//! Shade: at each hit, the light that the ray met, one shadow ray to a light sample, and the
//! path's next ray.
//!
//! [`path`] is the arithmetic; [`bsdf`], [`light`] and [`surface`] its parts, each with WGSL of the same
//! name beside it; [`tables`] is the scene as both read it, [`emitters`] the lights in it.

pub mod bsdf;
pub mod cpu;
pub mod emitters;
pub mod gpu;
pub mod light;
pub mod path;
pub mod surface;
pub mod tables;

use formats::manifest::QueueId;

use crate::stages::setup::Setup;
use crate::stages::shared::ShadeParams;

/// Parameters for all rays of a queue; `count` is the dispatch's to set.
pub fn params(setup: &Setup, id: QueueId) -> ShadeParams {
    let tables = &setup.tables;
    ShadeParams {
        first: 0,
        count: 0,
        pass_index: id.pass,
        bounce: id.bounce,
        seed: setup.seed_words(),
        is_last: u32::from(id.bounce + 1 == setup.bounces),
        roulette: u32::from(setup.roulette),
        zenith: tables.zenith.to_array(),
        emitter_count: tables.emitters.len() as u32,
        nadir: tables.nadir.to_array(),
        emission_density: tables.emission_density,
        sky_density: tables.sky_density,
        first_material: if setup.features.textures { tables.texels.len() as u32 } else { 0 },
        ..ShadeParams::default()
    }
}
