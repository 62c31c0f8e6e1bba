//! `cornell`: the box that the graphics laboratory of Cornell University built and measured.

use glam::{DVec3, dvec3};

use super::canvas::Canvas;
use super::setting::{Recipe, camera, lamp, matt, palette};
use super::shapes::Frame;
use crate::Scene;

pub(super) const RECIPE: Recipe = Recipe {
    name: "cornell",
    description: "The Cornell box: red and green walls, two blocks, a glowing square in the ceiling.",
    triangles: [38, 38, 4_000_000],
    setting,
    draw,
};

/// Length of the longest edge of the box, metres; the unit of its detail.
const EDGE: f64 = 0.55;

palette! {
    WHITE = matt("white", [0.725, 0.71, 0.68]);
    RED = matt("red", [0.63, 0.065, 0.05]);
    GREEN = matt("green", [0.14, 0.45, 0.091]);
    LAMP = lamp("ceiling light", [17.0, 12.0, 4.0]);
}

fn setting() -> Scene {
    Scene {
        materials: materials(),
        cameras: vec![
            camera("front", [0.278, 0.273, -0.8], [0.278, 0.273, 0.0], 0.109),
            camera("corner", [0.06, 0.46, 0.04], [0.36, 0.12, 0.5], 0.13),
        ],
        ..Scene::default()
    }
}

/// A point given in millimetres, as the box was measured.
fn millimetres(x: f64, y: f64, z: f64) -> DVec3 {
    dvec3(x, y, z) * 0.001
}

fn draw(canvas: &mut Canvas) {
    let (width, height, depth) = (556.0, 548.8, 559.2);
    let [a, b, c, d] =
        [(0.0, 0.0), (width, 0.0), (width, depth), (0.0, depth)].map(|(x, z)| millimetres(x, 0.0, z));
    let up = millimetres(0.0, height, 0.0);
    wall(canvas, WHITE, [d, c, b, a]);
    wall(canvas, WHITE, [c, d, d + up, c + up]);
    wall(canvas, RED, [b, c, c + up, b + up]);
    wall(canvas, GREEN, [d, a, a + up, d + up]);
    // The ceiling around the light, and the light in its opening.
    for (material, [left, right], [near, far]) in [
        (WHITE, [0.0, width], [0.0, 227.0]),
        (WHITE, [0.0, 213.0], [227.0, 332.0]),
        (WHITE, [343.0, width], [227.0, 332.0]),
        (WHITE, [0.0, width], [332.0, depth]),
        (LAMP, [213.0, 343.0], [227.0, 332.0]),
    ] {
        let corners = [(left, near), (right, near), (right, far), (left, far)];
        wall(canvas, material, corners.map(|(x, z)| millimetres(x, height, z)));
    }
    standing_block(canvas, 165.0, [[130.0, 65.0], [82.0, 225.0], [240.0, 272.0], [290.0, 114.0]]);
    standing_block(canvas, 330.0, [[423.0, 247.0], [265.0, 296.0], [314.0, 456.0], [472.0, 406.0]]);
}

/// Into how many cells to cut an edge; all edges of equal length at one detail are cut alike, up
/// to one cell.
fn cells(canvas: &mut Canvas, from: DVec3, to: DVec3) -> u32 {
    canvas.steps(8.0 * from.distance(to) / EDGE, 1)
}

fn wall(canvas: &mut Canvas, material: u32, corners: [DVec3; 4]) {
    let cells = [cells(canvas, corners[0], corners[1]), cells(canvas, corners[1], corners[2])];
    canvas.patch(material, &Frame::IDENTITY, corners, cells);
}

/// A block on the floor; its footprint runs counter-clockwise seen from below.
fn standing_block(canvas: &mut Canvas, height: f64, footprint: [[f64; 2]; 4]) {
    let below = footprint.map(|[x, z]| millimetres(x, 0.0, z));
    let above = footprint.map(|[x, z]| millimetres(x, height, z));
    // Shared by the faces that meet in an edge, so that no edge opens.
    let around = [cells(canvas, below[0], below[1]), cells(canvas, below[1], below[2])];
    let upwards = cells(canvas, below[0], above[0]);
    canvas.patch(WHITE, &Frame::IDENTITY, above, around);
    for here in 0..4 {
        let next = (here + 1) % 4;
        let corners = [below[here], below[next], above[next], above[here]];
        canvas.patch(WHITE, &Frame::IDENTITY, corners, [around[here % 2], upwards]);
    }
}
