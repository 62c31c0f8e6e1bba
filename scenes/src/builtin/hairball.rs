//! `hairball`: thousands of thin curves wound around each other, the hardest case for a hierarchy
//! of boxes and the least coherent for rays (after Laine's model of the same name).

use glam::DVec3;

use super::canvas::Canvas;
use super::numbers::{Dice, sin_cos};
use super::setting::{Recipe, camera, environment, glossy, metal, palette, sphere_light};
use super::shapes::{Frame, path};
use crate::Scene;

pub(super) const RECIPE: Recipe = Recipe {
    name: "hairball",
    description: "A ball of thin curled hairs with a hollow in its middle, lit by the sky and two sphere lights, one in the hollow.",
    triangles: [9_000, 500_000, 50_000_000],
    setting,
    draw,
};

/// Radius of the ball, metres.
const RADIUS: f64 = 2.0;
/// Radius of the hollow that no hair enters.
const HOLLOW: f64 = 0.45;

palette! {
    CHESTNUT = glossy("chestnut", [0.42, 0.2, 0.09], 0.45);
    BLOND = glossy("blond", [0.66, 0.46, 0.22], 0.4);
    AUBURN = glossy("auburn", [0.5, 0.14, 0.06], 0.45);
    COPPER = metal("copper", [0.9, 0.56, 0.4], 0.3);
}

fn setting() -> Scene {
    Scene {
        materials: materials(),
        lights: vec![
            sphere_light([3.0, 4.0, 3.5], [120.0, 110.0, 95.0]),
            sphere_light([-0.1, 0.2, -0.1], [2.4, 2.0, 1.5]),
            environment([0.7, 0.85, 1.1], [0.35, 0.3, 0.27]),
        ],
        cameras: vec![
            camera("outside", [0.0, 1.2, 6.0], [0.0, 0.0, 0.0], 0.125),
            camera("close", [1.6, 1.0, 2.1], [0.0, 0.3, 0.2], 0.14),
            camera("inside", [0.0, 0.0, 0.0], [1.0, 0.35, 0.6], 0.2),
        ],
        ..Scene::default()
    }
}

fn draw(canvas: &mut Canvas) {
    // Detail goes mostly into more hairs, the rest into smoother ones.
    let smoothness = canvas.detail.sqrt().sqrt().max(0.35);
    let rows = (30.0 * smoothness) as u32;
    let hairs = canvas.round(2500.0 * (canvas.detail / smoothness).max(0.05));
    for hair in 0..hairs {
        let mut dice = Dice::of_cell(61, i64::from(hair), 0);
        let path = wind(&mut dice, rows);
        let around = canvas.round(3.4).max(3);
        let thickness = dice.between(0.004, 0.0075);
        let shade = [CHESTNUT, BLOND, AUBURN, COPPER][dice.below(4)];
        canvas.tube(shade, &Frame::IDENTITY, &path, |t| thickness * (1.0 - t * t), around);
    }
}

/// A curve that starts near the hollow and is wound around the ball on its way out.
fn wind(dice: &mut Dice, rows: u32) -> Vec<DVec3> {
    let axis = dice.direction();
    let side = axis.any_orthonormal_vector();
    let other = axis.cross(side);
    let start = dice.unit();
    let turns = dice.between(0.15, 0.75);
    let tilt = dice.between(-0.25, 0.25);
    let depth = dice.between(HOLLOW, 0.75 * RADIUS);
    let reach = dice.between(0.8, 1.0) * RADIUS;
    let (curl_size, curl_turns) = (dice.between(0.03, 0.2), dice.between(1.5, 5.5));
    let curl_start = dice.unit();
    path(rows, |t| {
        let (sine, cosine) = sin_cos(start + turns * t);
        let (rise, level) = sin_cos(tilt * (2.0 * t - 1.0));
        let outward = (side * cosine + other * sine) * level + axis * rise;
        let (curl, sway) = sin_cos(curl_start + curl_turns * t);
        let radius = depth + (reach - depth) * t + 0.5 * curl_size * curl * t;
        outward * radius.max(HOLLOW) + axis * (curl_size * sway)
    })
}
