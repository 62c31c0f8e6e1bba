//! Camera rays on threads.

use formats::ray::Ray;
use glam::Vec3;
use rayon::prelude::*;

use crate::stages::random::Random;
use crate::stages::shared::GenerateParams;
use crate::stages::vector::normalize3;

/// One ray per pixel, in pixel order, top row first.
pub fn generate(params: &GenerateParams) -> Vec<Ray> {
    (0..params.count).into_par_iter().map(|pixel| camera_ray(params, pixel)).collect()
}

fn camera_ray(params: &GenerateParams, pixel: u32) -> Ray {
    let mut random = Random::new(params.seed, pixel, params.pass_index, 0);
    let x = (pixel % params.width) as f32 + random.draw();
    let y = (pixel / params.width) as f32 + random.draw();
    let sx = 2.0 * x / params.width as f32 - 1.0;
    let sy = 1.0 - 2.0 * y / params.height as f32;
    let direction =
        normalize3(Vec3::from(params.forward) + Vec3::from(params.right) * sx + Vec3::from(params.up) * sy);
    Ray { origin: params.eye, t_min: 0.0, direction: direction.to_array(), t_max: f32::INFINITY }
}
