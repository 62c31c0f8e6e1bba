//! Unit space: the scene's bounding box moved to 0 and divided by its largest extent.

use serde::{Deserialize, Serialize};

use crate::ray::{Hit, Ray};

/// The map from world space to unit space (docs/keys.md: `u(p) = (p − box.min)·s`).
///
/// Only subtraction and multiplication of single values, so every device gives the same bits.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct UnitSpace {
    /// Lowest corner of the scene's bounding box, world units.
    pub min: [f32; 3],
    /// One over the largest extent of the box; 1 if that is 0.
    pub scale: f32,
    /// The highest corner of the box in unit space: its sides, each in [0, 1].
    pub sides: [f32; 3],
}

impl UnitSpace {
    /// From the corners of a bounding box in world space.
    pub fn from_bounds(min: [f32; 3], max: [f32; 3]) -> Self {
        let extent = [0, 1, 2].map(|axis| max[axis] - min[axis]);
        let largest = extent[0].max(extent[1]).max(extent[2]);
        let scale = if largest > 0.0 { 1.0 / largest } else { 1.0 };
        Self { min, scale, sides: extent.map(|side| side * scale) }
    }

    /// A world-space point in unit space.
    #[inline(always)]
    pub fn point(&self, world: [f32; 3]) -> [f32; 3] {
        [0, 1, 2].map(|axis| (world[axis] - self.min[axis]) * self.scale)
    }

    /// How far a ray from `origin` (unit space) runs before it leaves the bounding box, in unit
    /// lengths; 0 if it never meets the box, `+inf` for a zero direction inside it.
    #[inline(always)]
    pub fn exit(&self, origin: [f32; 3], direction: [f32; 3]) -> f32 {
        let mut nearest_far = f32::INFINITY;
        let mut farthest_near = 0.0f32;
        // Without branches, so that many rays are computed at once.
        for axis in 0..3 {
            let (o, d) = (origin[axis], direction[axis]);
            let to_min = (0.0 - o) / d;
            let to_max = (self.sides[axis] - o) / d;
            let is_outside = (o < 0.0) | (o > self.sides[axis]);
            let beside = if is_outside { f32::NEG_INFINITY } else { f32::INFINITY };
            let is_parallel = d == 0.0;
            nearest_far = nearest_far.min(if is_parallel { beside } else { to_min.max(to_max) });
            farthest_near = farthest_near.max(if is_parallel { 0.0 } else { to_min.min(to_max) });
        }
        if nearest_far < farthest_near { 0.0 } else { nearest_far }
    }

    /// Traced length of a closest ray in unit lengths: to the hit, or to the exit on a miss.
    pub fn closest_length(&self, ray: &Ray, hit: &Hit) -> f32 {
        if hit.is_hit() { hit.t * self.scale } else { self.exit(self.point(ray.origin), ray.direction) }
    }

    /// Traced length of a shadow ray in unit lengths: to the occluder that was found
    /// (`distance` in world units, `+inf` for none), no farther than the light or the exit.
    pub fn shadow_length(&self, ray: &Ray, distance: f32) -> f32 {
        let exit = self.exit(self.point(ray.origin), ray.direction);
        (distance * self.scale).min(ray.t_max * self.scale).min(exit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kitchen_like() -> UnitSpace {
        UnitSpace::from_bounds([-2.0, 1.0, 10.0], [6.0, 5.0, 12.0])
    }

    #[test]
    fn corners_map_to_zero_and_sides() {
        let unit = kitchen_like();
        assert_eq!(unit.point([-2.0, 1.0, 10.0]), [0.0; 3]);
        assert_eq!(unit.point([6.0, 5.0, 12.0]), unit.sides);
        assert_eq!(unit.sides, [1.0, 0.5, 0.25]);
    }

    #[test]
    fn flat_and_empty_scenes_keep_scale_one() {
        assert_eq!(UnitSpace::from_bounds([3.0; 3], [3.0; 3]).scale, 1.0);
    }

    #[test]
    fn exit_from_inside_outside_and_beside() {
        let unit = kitchen_like();
        assert_eq!(unit.exit([0.25, 0.25, 0.125], [1.0, 0.0, 0.0]), 0.75);
        assert_eq!(unit.exit([0.25, 0.25, 0.125], [0.0, -1.0, 0.0]), 0.25);
        assert_eq!(unit.exit([-1.0, 0.25, 0.125], [1.0, 0.0, 0.0]), 2.0);
        assert_eq!(unit.exit([-1.0, 0.25, 0.125], [-1.0, 0.0, 0.0]), 0.0);
        assert_eq!(unit.exit([0.5, 0.75, 0.125], [1.0, 0.0, 0.0]), 0.0);
        assert_eq!(unit.exit([0.5, 0.25, 0.125], [0.0; 3]), f32::INFINITY);
    }

    #[test]
    fn traced_lengths_follow_the_definition() {
        let unit = kitchen_like();
        let ray = Ray { origin: [0.0, 3.0, 11.0], t_min: 0.0, direction: [1.0, 0.0, 0.0], t_max: 4.0 };
        let hit = Hit { t: 2.0, triangle: 7, u: 0.0, v: 0.0 };
        assert_eq!(unit.closest_length(&ray, &hit), 0.25);
        assert_eq!(unit.closest_length(&ray, &Hit::MISS), 0.75);
        assert_eq!(unit.shadow_length(&ray, f32::INFINITY), 0.5);
        assert_eq!(unit.shadow_length(&ray, 1.0), 0.125);
    }
}
