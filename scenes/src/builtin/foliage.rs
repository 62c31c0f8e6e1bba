//! Leaves for plants and trees: a generated texture with holes, and clouds of small patches of it.

use glam::{DAffine3, DVec2, DVec3, dvec2, dvec3};

use super::mesh::{Canvas, Vertex};
use super::numbers::{Dice, sin_cos};
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
        let side = if leaf % 2 == 0 { 1.0 } else { -1.0 };
        let height = 0.88 - 0.1 * f64::from(leaf);
        (dvec2(0.5, height), side * 0.17, 1.0 - 0.04 * f64::from(leaf))
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

/// A cloud of leaf patches in the unit ball of `frame`, denser near its surface.
pub(super) struct Leaves {
    pub(super) material: u32,
    /// How many patches; two triangles each.
    pub(super) count: u32,
    /// Edge of a patch in world space, metres.
    pub(super) size: f64,
}

impl Leaves {
    pub(super) fn draw(&self, canvas: &mut Canvas, frame: &DAffine3, dice: &mut Dice) {
        // A stream of their own: a canvas that only counts does not call the stroke.
        let mut leaf_dice = Dice::new(dice.bits());
        let dice = &mut leaf_dice;
        canvas.draw(2 * u64::from(self.count), |mesh| {
            for _ in 0..self.count {
                let (sine, cosine) = sin_cos(dice.unit());
                let height = dice.between(-1.0, 1.0);
                let radius = (1.0 - height * height).sqrt();
                let outward = dvec3(radius * cosine, height, radius * sine);
                // A cube root would fill the ball evenly; leaves sit further out.
                let depth = dice.unit().sqrt().sqrt();
                let centre = frame.transform_point3(outward * depth);
                let facing = (outward + 0.9 * random_vector(dice)).normalize_or(DVec3::Y);
                let across = facing.cross(random_vector(dice)).normalize_or(DVec3::X);
                let upward = facing.cross(across);
                let half = 0.5 * self.size * dice.between(0.75, 1.25);
                let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| {
                    mesh.vertex(Vertex {
                        position: centre + across * (x * half) + upward * (y * half),
                        normal: DVec3::ZERO,
                        uv: dvec2(0.5 + 0.5 * x, 0.5 - 0.5 * y),
                    })
                });
                mesh.triangle(self.material, [corners[0], corners[1], corners[2]]);
                mesh.triangle(self.material, [corners[0], corners[2], corners[3]]);
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
