//! Camera rays on threads.

use formats::ray::Ray;
use glam::Vec3;
use rayon::prelude::*;

use crate::stages::random::Random;
use crate::stages::shared::GenerateParams;
use crate::stages::vector::normalize3;

/// Writes one ray per pixel, in pixel order, top row first.
pub fn generate(params: &GenerateParams, rays: &mut [Ray]) {
    let queue = Random::of_queue(params.seed, params.pass_index, 0);
    rays.par_iter_mut().enumerate().for_each(|(pixel, ray)| *ray = camera_ray(params, queue, pixel as u32));
}

fn camera_ray(params: &GenerateParams, queue: u32, pixel: u32) -> Ray {
    let mut random = Random::of_pixel(queue, pixel);
    let x = (pixel % params.width) as f32 + random.draw();
    let y = (pixel / params.width) as f32 + random.draw();
    let sx = 2.0 * x / params.width as f32 - 1.0;
    let sy = 1.0 - 2.0 * y / params.height as f32;
    let direction =
        normalize3(Vec3::from(params.forward) + Vec3::from(params.right) * sx + Vec3::from(params.up) * sy);
    Ray { origin: params.eye, t_min: 0.0, direction: direction.to_array(), t_max: f32::INFINITY }
}
