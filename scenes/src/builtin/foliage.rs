//! Leaves for plants and trees: a generated texture with holes, and clouds of small patches of it.

use glam::{DVec2, DVec3, dvec2, dvec3};

use super::canvas::Canvas;
use super::numbers::{Dice, sin_cos};
use super::shapes::{Frame, quad};
use crate::Texture;

/// Texels along each edge of the leaf texture.
const TEXELS: u32 = 64;

/// A sprig of seven leaves on a stem; what is around them is transparent.
pub(super) fn sprig_texture() -> Texture {
    let texel = |index: u32| {
        let point =
            dvec2(f64::from(index % TEXELS) + 0.5, f64::from(index / TEXELS) + 0.5) / f64::from(TEXELS);
        let on_stem = (point.x - 0.5).abs() < 0.014 && point.y > 0.2;
        match (leaf_at(point), on_stem) {
            (Some(shade), _) => {
                let channel = |value: f64| (value * shade).round() as u8;
                [channel(120.0), channel(158.0), channel(72.0), 255]
            }
            (None, true) => [104, 92, 58, 255],
            (None, false) => [96, 120, 60, 0],
        }
    };
    Texture { width: TEXELS, height: TEXELS, rgba: (0..TEXELS * TEXELS).map(texel).collect() }
}

/// How bright the leaf is that covers this point of the unit square, if any does.
fn leaf_at(point: DVec2) -> Option<f64> {
    let pairs = (0..6).map(|leaf| {
        let turns = if leaf % 2 == 0 { 0.17 } else { -0.17 };
        (dvec2(0.5, 0.88 - 0.1 * f64::from(leaf)), turns, 1.0 - 0.04 * f64::from(leaf))
    });
    let top = std::iter::once((dvec2(0.5, 0.34), 0.0, 1.1));
    pairs.chain(top).find_map(|(root, turns, brightness)| {
        let (sine, cosine) = sin_cos(turns);
        let offset = point - root;
        // Along the leaf and across it; v runs down, so leaves grow towards smaller v.
        let along = (offset.x * sine - offset.y * cosine) / 0.32;
        let across = (offset.x * cosine + offset.y * sine) / 0.32;
        let half_width = 0.8 * along * (1.0 - along);
        let inside = (0.0..=1.0).contains(&along) && across.abs() <= half_width;
        let vein = if across.abs() < 0.025 { 0.8 } else { 1.0 };
        inside.then_some(brightness * vein * (0.9 + 0.2 * along))
    })
}

impl Canvas {
    /// A cloud of leaf patches in the unit ball of `frame`, denser near its surface: so many of two
    /// triangles each, their edge about `size` metres in world space.
    pub(super) fn leaves(&mut self, material: u32, frame: &Frame, count: u32, size: f64, seed: u64) {
        self.draw(2 * u64::from(count), |scene| {
            let mut dice = Dice::new(seed);
            for _ in 0..count {
                let outward = dice.direction();
                // A cube root would fill the ball evenly; leaves sit further out.
                let depth = dice.unit().sqrt().sqrt();
                let centre = frame.transform_point3(outward * depth);
                let facing = (outward + 0.9 * random_vector(&mut dice)).normalize_or(DVec3::Y);
                let across = facing.cross(random_vector(&mut dice)).normalize_or(DVec3::X);
                let half = 0.5 * size * dice.between(0.75, 1.25);
                let (right, up) = (across * half, facing.cross(across) * half);
                let (left_edge, right_edge) = (centre - right, centre + right);
                quad(scene, material, [left_edge - up, right_edge - up, right_edge + up, left_edge + up]);
            }
        });
    }
}

/// Uniform in the cube from -1 to 1.
fn random_vector(dice: &mut Dice) -> DVec3 {
    let x = dice.between(-1.0, 1.0);
    let y = dice.between(-1.0, 1.0);
    dvec3(x, y, dice.between(-1.0, 1.0))
}
