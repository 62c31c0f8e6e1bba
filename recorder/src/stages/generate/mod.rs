//! Generate: one camera ray per pixel, at a random place within it.

pub mod cpu;
pub mod gpu;

use crate::stages::setup::Setup;
use crate::stages::shared::GenerateParams;

/// Parameters for all pixels of a pass.
pub fn params(setup: &Setup, pass: u32) -> GenerateParams {
    let camera = &setup.camera;
    let half_height = (0.5 * camera.yfov_radians).tan();
    let half_width = half_height * setup.width as f32 / setup.height as f32;
    GenerateParams {
        eye: camera.eye,
        width: setup.width,
        forward: camera.forward,
        height: setup.height,
        right: camera.right.map(|x| x * half_width),
        pass_index: pass,
        up: camera.up.map(|x| x * half_height),
        first: 0,
        seed: setup.seed_words(),
        count: setup.width * setup.height,
        unused: 0,
    }
}
