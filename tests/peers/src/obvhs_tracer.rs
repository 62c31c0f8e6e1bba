//! obvhs with its own everything, triangles in leaf order as its examples do it.

use std::time::Duration;

use formats::ray::{Hit, Ray};
use glam::Vec3A;
use obvhs::BvhBuildParams;
use obvhs::bvh2::builder::build_bvh2_from_tris;
use obvhs::cwbvh::builder::build_cwbvh_from_tris;
use obvhs::ray::{Ray as ObvhsRay, RayHit};
use obvhs::triangle::Triangle;
use scenes::Scene;

use crate::tracing::{Trace, for_each_ray};

/// Its binary hierarchy, by the preset that ours are built by.
pub fn binary(scene: &Scene) -> Trace {
    let triangles = triangles_of(scene);
    let tree = build_bvh2_from_tris(&triangles, BvhBuildParams::medium_build(), &mut Duration::default());
    let leaves = Leaves::new(&triangles, &tree.primitive_indices);
    Box::new(move |rays, hits| {
        let nearest =
            leaves.nearest(|ray, hit| tree.ray_traverse(ray, hit, |ray, slot| leaves.distance(ray, slot)));
        let is_blocked =
            |ray: &Ray| !tree.ray_traverse_miss(converted(ray), |ray, slot| leaves.distance(ray, slot));
        for_each_ray(rays, hits, nearest, is_blocked);
    })
}

/// Its eight-wide compressed hierarchy, likewise.
pub fn wide(scene: &Scene) -> Trace {
    let triangles = triangles_of(scene);
    let tree = build_cwbvh_from_tris(&triangles, BvhBuildParams::medium_build(), &mut Duration::default());
    let leaves = Leaves::new(&triangles, &tree.primitive_indices);
    Box::new(move |rays, hits| {
        let nearest =
            leaves.nearest(|ray, hit| tree.ray_traverse(ray, hit, |ray, slot| leaves.distance(ray, slot)));
        let is_blocked =
            |ray: &Ray| !tree.ray_traverse_miss(converted(ray), |ray, slot| leaves.distance(ray, slot));
        for_each_ray(rays, hits, nearest, is_blocked);
    })
}

/// Triangles in the order of leaves, and which of the scene each is.
struct Leaves {
    triangles: Vec<Triangle>,
    order: Vec<u32>,
}

impl Leaves {
    fn new(triangles: &[Triangle], order: &[u32]) -> Self {
        let triangles = order.iter().map(|&index| triangles[index as usize]).collect();
        Self { triangles, order: order.to_vec() }
    }

    #[inline]
    fn distance(&self, ray: &ObvhsRay, slot: usize) -> f32 {
        self.triangles[slot].intersect(ray)
    }

    /// The nearest hit by a traversal; it has no weights of corners.
    fn nearest(&self, traverse: impl Fn(ObvhsRay, &mut RayHit) -> bool) -> impl Fn(&Ray) -> Hit {
        move |ray| {
            let mut hit = RayHit::none();
            traverse(converted(ray), &mut hit);
            match self.order.get(hit.primitive_id as usize) {
                Some(&triangle) => Hit { t: hit.t, triangle, u: 0.0, v: 0.0 },
                None => Hit::MISS,
            }
        }
    }
}

fn triangles_of(scene: &Scene) -> Vec<Triangle> {
    let corner = |index: u32| Vec3A::from_array(scene.positions[index as usize]);
    let triangle = |corners: &[u32; 3]| {
        let [v0, v1, v2] = corners.map(corner);
        Triangle { v0, v1, v2 }
    };
    scene.triangles.iter().map(triangle).collect()
}

fn converted(ray: &Ray) -> ObvhsRay {
    ObvhsRay::new(ray.origin.into(), ray.direction.into(), ray.t_min, ray.t_max)
}
