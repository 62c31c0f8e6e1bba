//! Radiance of diffuse scenes by the plainest path tracer there is, in f64: directions are drawn by the
//! cosine, light is what they meet. No light is sampled, nothing is weighted between ways of
//! sampling, no path ends by chance; so it is noisy, and nothing that could be wrong in a renderer's
//! sampling is shared with it. For pictures that no formula knows.

use std::f64::consts::{PI, TAU};

use recorder::oracle::line::{Line, cross, dot, minus};
use recorder::oracle::{ExactHit, Oracle};
use scenes::{Light, Scene};

/// A path tracer over a scene of diffuse surfaces without textures, lit by emissive triangles, sphere
/// lights and a sky.
#[derive(Clone, Debug)]
pub(crate) struct Reference<'a> {
    scene: &'a Scene,
    oracle: Oracle,
}

/// Linear RGB.
type Color = [f64; 3];

impl<'a> Reference<'a> {
    /// For a scene.
    pub(crate) fn new(scene: &'a Scene) -> Self {
        Self { scene, oracle: Oracle::new(scene) }
    }

    /// One sample of the radiance that arrives at `origin` from `direction` (of any length) after as many
    /// bounces as a recording has: the last of `bounces` surfaces still reflects light that comes to it straight.
    /// `draw` gives numbers in 0..1.
    pub(crate) fn radiance(
        &self,
        origin: [f64; 3],
        direction: [f64; 3],
        bounces: u32,
        draw: &mut impl FnMut() -> f64,
    ) -> Color {
        let mut line = Line { origin, direction, t_min: 0.0, t_max: f64::INFINITY };
        let (mut sum, mut throughput) = ([0.0; 3], [1.0; 3]);
        for bounce in 0..=bounces {
            let hit = self.oracle.closest_on(&line);
            // The camera does not see the glow of sphere lights.
            let lamps = if bounce == 0 { [0.0; 3] } else { self.lamps(&line, hit.as_ref()) };
            let Some(hit) = hit else {
                let sky = self.sky(&line);
                return [0, 1, 2].map(|c| sum[c] + throughput[c] * (sky[c] + lamps[c]));
            };
            let material =
                &self.scene.materials[self.scene.triangle_materials[hit.triangle as usize] as usize];
            for channel in 0..3 {
                sum[channel] +=
                    throughput[channel] * (f64::from(material.emission[channel]) + lamps[channel]);
                throughput[channel] *= f64::from(material.base_color[channel]);
            }
            line = self.reflected(&line, &hit, draw);
        }
        sum
    }

    /// Radiance of the sphere lights that a line meets before anything else.
    fn lamps(&self, line: &Line, hit: Option<&ExactHit>) -> Color {
        let mut sum = [0.0; 3];
        for light in &self.scene.lights {
            let Light::Sphere { position, radius, intensity } = light else { continue };
            let radius = f64::from(*radius);
            let to_centre = minus(position.map(f64::from), line.origin);
            let speed = line.speed();
            let along = dot(to_centre, line.direction) / speed;
            let half = radius * radius - (dot(to_centre, to_centre) - along * along);
            let distance = along - half.max(0.0).sqrt();
            let is_seen = half > 0.0 && distance > 0.0 && hit.is_none_or(|hit| distance < hit.t * speed);
            if is_seen {
                (0..3).for_each(|c| sum[c] += f64::from(intensity[c]) / (PI * radius * radius));
            }
        }
        sum
    }

    fn sky(&self, line: &Line) -> Color {
        let height = 0.5 + 0.5 * line.direction[1] / line.speed();
        let sky = self.scene.lights.iter().find_map(|light| match light {
            Light::Environment(sky) => Some(sky),
            _ => None,
        });
        sky.map_or([0.0; 3], |sky| {
            [0, 1, 2].map(|c| f64::from(sky.nadir[c]) * (1.0 - height) + f64::from(sky.zenith[c]) * height)
        })
    }

    /// A line from a hit into the hemisphere that the ray came from, drawn by the cosine.
    fn reflected(&self, line: &Line, hit: &ExactHit, draw: &mut impl FnMut() -> f64) -> Line {
        let [p, q, r] = self.scene.corners(hit.triangle as usize).map(|corner| corner.map(f64::from));
        let across = cross(minus(q, p), minus(r, p));
        let facing = if dot(across, line.direction) > 0.0 { -1.0 } else { 1.0 };
        let length = dot(across, across).sqrt() * facing;
        let normal = across.map(|x| x / length);
        // A point on the unit sphere added to the normal has a direction drawn by the cosine.
        let (z, turn) = (1.0 - 2.0 * draw(), TAU * draw());
        let radius = (1.0 - z * z).max(0.0).sqrt();
        let direction = [radius * turn.cos() + normal[0], radius * turn.sin() + normal[1], z + normal[2]];
        // Far beyond f64's rounding, far below what a picture shows.
        let size = p.iter().chain(&q).chain(&r).fold(0.0f64, |most, x| most.max(x.abs()));
        let origin = [0, 1, 2]
            .map(|axis| line.origin[axis] + hit.t * line.direction[axis] + 1e-9 * size * normal[axis]);
        Line { origin, direction, t_min: 0.0, t_max: f64::INFINITY }
    }
}
