//! Rays that leave surfaces through the project's own offset: none finds the triangle that it leaves, none
//! leaks through a closed surface.

use glam::Vec3;
use rayon::prelude::*;
use recorder::stages::shade::surface::offset_origin;

use crate::numbers::{Numbers, ray};
use crate::runner::{Backend, Case, kernels, run, trace};
use crate::shapes::{FAR_AWAY, Triangle, cube, placed, scene_of, sphere};
use formats::ray::Ray;
use recorder::stages::trace::TraceKernel;

/// Rays from points on triangles to the side of `inwards`, and the triangle that each leaves.
fn spawn(triangles: &[Triangle], centre: [f32; 3], each: usize) -> (Vec<Ray>, Vec<u32>) {
    let chunks = triangles.par_iter().enumerate().map(|(index, &triangle)| {
        let mut numbers = Numbers::new(40 + index as u32);
        let [p, q, r] = triangle.map(Vec3::from);
        let mut normal = (q - p).cross(r - p).normalize();
        if normal.dot(Vec3::from(centre) - p) < 0.0 {
            normal = -normal;
        }
        let rays = (0..each).map(|_| {
            let (root, part) = (numbers.unit().sqrt(), numbers.unit());
            let point = p + (q - p) * (root * (1.0 - part)) + (r - p) * (root * part);
            let origin = offset_origin(point, normal, q - p, r - p);
            let mut direction = Vec3::from(numbers.direction());
            let up = direction.dot(normal);
            // Half of them grazing.
            let wanted = if numbers.unit() < 0.5 { up.abs() } else { up.abs().powi(4) };
            direction = (direction + normal * (wanted - up)).normalize();
            (ray(origin.to_array(), direction.to_array()), index as u32)
        });
        rays.collect::<Vec<_>>()
    });
    chunks.flatten_iter().unzip()
}

#[test]
fn a_million_rays_leave_a_thousand_triangles() {
    let scenes = [
        ("sphere", placed(&sphere(16), 5.0, [0.0; 3]), [0.0; 3]),
        ("sphere far away", placed(&sphere(16), 500.0, FAR_AWAY), FAR_AWAY),
        ("box of millimetres", placed(&cube(9), 4000.0, [0.0, 4000.0, 0.0]), [0.0, 4000.0, 0.0]),
    ];
    for (name, triangles, centre) in scenes {
        assert!(triangles.len() >= 960);
        let (rays, own) = spawn(&triangles, centre, 1000);
        let scene = scene_of(name, &triangles);
        for (backend, kernel) in kernels() {
            let count = if backend == Backend::Cpu { rays.len() } else { 50_000 };
            // The GPU's share comes from all triangles.
            let step = rays.len() / count;
            let picked: Vec<Ray> = rays.iter().step_by(step).copied().collect();
            let own: Vec<u32> = own.iter().step_by(step).copied().collect();
            let answers = trace(backend, kernel, &scene, &picked);
            let leaks = answers.hits.iter().filter(|hit| !hit.is_hit()).count();
            let shadows = answers.distances.iter().filter(|distance| distance.is_infinite()).count();
            let again = answers.hits.iter().zip(&own).filter(|(hit, own)| hit.triangle == **own).count();
            println!(
                "{name:20} {:22} {:8} rays: {leaks} leaks, {shadows} of shadow rays, {again} hit their own triangle",
                answers.name,
                picked.len()
            );
            let is_own = kernel != TraceKernel::RayQuery;
            assert!(!is_own || leaks + shadows + again == 0, "{name}, {}", answers.name);
        }
        let judged: Vec<Ray> = rays.into_iter().step_by(97).collect();
        run(&Case::closed(format!("spawned in a {name}"), scene, judged));
    }
}
