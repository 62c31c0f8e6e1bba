//! `terrain`: mountains around a lake, with rocks and firs, under an open sky.

use glam::{DVec3, dvec3};

use super::canvas::{Canvas, Vertex};
use super::numbers::{Dice, ease, fractal_noise, sin_cos, value_noise};
use super::setting::{Recipe, camera, environment, glossy, matt, palette};
use super::shapes::{Frame, Shading, place, stretch};
use crate::{Light, Scene};

pub(super) const RECIPE: Recipe = Recipe {
    name: "terrain",
    description: "Mountains around a lake, with rocks and firs, under the sun and an open sky.",
    triangles: [6_000, 500_000, 50_000_000],
    setting,
    draw,
};

/// Edge of the square of land, metres.
const EDGE: f64 = 1200.0;
/// Cameras: name, where on the land, so many metres above it, what it looks at.
const VIEWS: [(&str, [f64; 2], f64, [f64; 3]); 3] = [
    ("shore", [-60.0, 215.0], 7.0, [60.0, 38.0, -300.0]),
    ("ridge", [330.0, 330.0], 45.0, [-40.0, 10.0, -60.0]),
    ("forest", [-250.0, 120.0], 9.0, [120.0, 20.0, -80.0]),
];
palette! {
    GRASS = matt("grass", [0.13, 0.21, 0.06]);
    MEADOW = matt("meadow", [0.24, 0.27, 0.09]);
    ROCK = matt("rock", [0.29, 0.26, 0.23]);
    SNOW = glossy("snow", [0.86, 0.88, 0.9], 0.7);
    SAND = matt("sand", [0.5, 0.43, 0.3]);
    WATER = glossy("water", [0.02, 0.06, 0.07], 0.06);
    BOULDER = matt("boulder", [0.36, 0.34, 0.31]);
    BARK = matt("bark", [0.17, 0.11, 0.07]);
    NEEDLES = matt("needles", [0.05, 0.12, 0.05]);
}

fn setting() -> Scene {
    let direction = dvec3(-0.62, -0.5, -0.6).normalize().as_vec3().to_array();
    let sun = Light::Directional { direction, irradiance: [4.2, 3.7, 3.0] };
    Scene {
        materials: materials(),
        lights: vec![sun, environment([0.45, 0.75, 1.3], [0.75, 0.8, 0.85])],
        cameras: VIEWS
            .map(|(name, [x, z], above, target)| camera(name, [x, height(x, z) + above, z], target, 0.14))
            .to_vec(),
        ..Scene::default()
    }
}

/// Height of the land above the lake, metres.
fn height(x: f64, z: f64) -> f64 {
    let (u, w) = (x / EDGE, z / EDGE);
    // A basin: low in the middle, rising to the rim, with a wandering shore.
    let wander = 0.06 * fractal_noise(71, 5.0 * u, 5.0 * w, 3);
    let rim = ((u * u + w * w).sqrt() + wander - 0.12) / 0.38;
    let basin = ease(rim.clamp(0.0, 1.0));
    let mut ridges = 0.0;
    let (mut size, mut frequency) = (1.0, 4.0);
    for octave in 0..7 {
        let shift = 0.71 * octave as f64;
        let noise = value_noise(80 + octave, u * frequency + shift, w * frequency - shift);
        // Folding the noise at 0 makes crests.
        let crest = 1.0 - noise.abs();
        ridges += size * (crest * crest - 0.4);
        size *= 0.48;
        frequency *= 2.03;
    }
    let rolling = 7.0 * fractal_noise(95, 9.0 * u, 9.0 * w, 4);
    190.0 * basin * (0.35 + 0.65 * ridges)
        + rolling * (0.3 + rim.clamp(0.0, 1.0))
        + 60.0 * rim.min(0.25)
        + 3.0
}

fn draw(canvas: &mut Canvas) {
    land(canvas);
    let corners = [(-0.5, 0.5), (0.5, 0.5), (0.5, -0.5), (-0.5, -0.5)];
    let lake = corners.map(|(x, z)| dvec3(0.62 * x * EDGE, 0.0, 0.62 * z * EDGE));
    canvas.patch(WATER, &Frame::IDENTITY, lake, [1, 1]);
    scatter(canvas);
}

/// The ground: a grid of heights with smooth normals, painted by height and slope.
fn land(canvas: &mut Canvas) {
    let cells = ((440.0 * canvas.detail.sqrt()) as u32).max(40);
    let step = EDGE / f64::from(cells);
    let stride = cells + 1;
    canvas.draw(2 * u64::from(cells) * u64::from(cells), |scene| {
        let at = |column: u32, row: u32| {
            let x = step * f64::from(column) - 0.5 * EDGE;
            let z = step * f64::from(row) - 0.5 * EDGE;
            dvec3(x, height(x, z), z)
        };
        let points: Vec<DVec3> = (0..stride * stride).map(|i| at(i % stride, i / stride)).collect();
        let first = scene.positions.len() as u32;
        let of = |column: u32, row: u32| points[(row.min(cells) * stride + column.min(cells)) as usize];
        for row in 0..stride {
            for column in 0..stride {
                let across = of(column + 1, row) - of(column.saturating_sub(1), row);
                let along = of(column, row + 1) - of(column, row.saturating_sub(1));
                scene.push_vertex(Vertex {
                    position: of(column, row),
                    normal: along.cross(across).normalize_or(DVec3::Y),
                    ..Vertex::default()
                });
            }
        }
        for row in 0..cells {
            for column in 0..cells {
                let a = row * stride + column;
                let (b, c, d) = (a + 1, a + 1 + stride, a + stride);
                for corners in [[a, d, c], [a, c, b]] {
                    let material = ground(corners.map(|index| points[index as usize]));
                    scene.push_triangle(material, corners.map(|index| first + index));
                }
            }
        }
    });
}

/// What covers a facet of the ground.
fn ground([a, b, c]: [DVec3; 3]) -> u32 {
    let level = (b - a).cross(c - a).normalize_or(DVec3::Y).y;
    let middle = (a + b + c) / 3.0;
    let blur = value_noise(99, middle.x / 23.0, middle.z / 23.0);
    if middle.y < 1.6 + blur {
        SAND
    } else if middle.y > 105.0 + 20.0 * blur && level > 0.58 + 0.06 * blur {
        SNOW
    } else if level < 0.72 + 0.04 * blur || middle.y > 70.0 + 20.0 * blur {
        ROCK
    } else if blur > 0.15 {
        MEADOW
    } else {
        GRASS
    }
}

/// Firs and boulders, one candidate for each cell of a grid.
fn scatter(canvas: &mut Canvas) {
    const CELLS: i64 = 72;
    let share = canvas.detail.min(1.0);
    for cell in 0..CELLS * CELLS {
        let (column, row) = (cell % CELLS, cell / CELLS);
        let mut dice = Dice::of_cell(77, column, row);
        let place_in = |index: i64, shift: f64| EDGE * ((index as f64 + shift) / CELLS as f64 - 0.5);
        let (x, z) = (place_in(column, dice.unit()), place_in(row, dice.unit()));
        let y = height(x, z);
        let slope = (height(x + 2.0, z) - y).abs().max((height(x, z + 2.0) - y).abs()) / 2.0;
        let kept = dice.chance(0.02 + 0.98 * share);
        let wooded = value_noise(101, x / 90.0, z / 90.0) > -0.25;
        // Nothing grows near a camera.
        let in_view =
            VIEWS.iter().any(|(_, stand, ..)| (x - stand[0]).abs().max((z - stand[1]).abs()) < 14.0);
        if !kept || y < 2.5 || in_view {
            continue;
        }
        if wooded && y < 75.0 && slope < 0.75 {
            fir(canvas, dvec3(x, y, z), &mut dice);
        } else if slope < 0.9 && dice.chance(0.35) {
            boulder(canvas, dvec3(x, y, z), &mut dice);
        }
    }
}

/// A trunk and a few skirts of needles.
fn fir(canvas: &mut Canvas, foot: DVec3, dice: &mut Dice) {
    let size = dice.between(6.0, 13.0);
    let frame = place(foot.x, foot.y - 0.4, foot.z, dice.unit()) * stretch(size, size, size);
    let around = canvas.steps(6.0, 4);
    canvas.revolve(BARK, &frame, &[&[[0.03, 0.0], [0.015, 0.5]]], [around, 1]);
    for skirt in 0..4 {
        let t = f64::from(skirt) / 4.0;
        let (reach, foot) = (0.21 * (1.0 - 0.75 * t), 0.14 + 0.68 * t);
        let profile = [[0.3 * reach, foot + 0.05], [reach, foot], [0.0, foot + 0.32 - 0.1 * t]];
        canvas.revolve(NEEDLES, &frame, &[&profile[..2], &profile[1..]], [around, 1]);
    }
}

/// A lumpy ball, half in the ground.
fn boulder(canvas: &mut Canvas, foot: DVec3, dice: &mut Dice) {
    let size = dice.between(0.6, 3.2);
    let frame = place(foot.x, foot.y, foot.z, dice.unit()) * stretch(size, 0.7 * size, 1.2 * size);
    let lumps = dice.bits();
    let rows = canvas.steps(6.0, 3);
    canvas.surface(BOULDER, &frame, [2 * rows, rows], [true; 2], Shading::Smooth, |u, v| {
        // From the lower pole to the upper one.
        let ((y, radius), (sine, cosine)) = (sin_cos(0.5 * v - 0.25), sin_cos(u));
        let (x, z) = (radius * cosine, -radius * sine);
        dvec3(x, y, z) * (1.0 + 0.2 * fractal_noise(lumps, 1.4 * x + y, 1.4 * z - y, 2))
    });
}
