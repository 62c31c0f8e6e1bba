//! `cornell`: the box that the graphics laboratory of Cornell University built and measured.

use glam::{DVec3, dvec3};

use super::BuiltinInfo;
use super::mesh::Canvas;
use super::setting::{Materials, Recipe, Setting, camera};
use super::shapes::patch;

pub(super) const RECIPE: Recipe = Recipe {
    info: BuiltinInfo {
        name: "cornell",
        description: "The Cornell box: red and green walls, two blocks, a glowing square in the ceiling.",
        default_triangles: 38,
        least_triangles: 38,
        most_triangles: 4_000_000,
    },
    setting,
    draw,
};

/// Length of the longest edge of the box, metres; the unit of its detail.
const EDGE: f64 = 0.55;

struct Paint {
    white: u32,
    red: u32,
    green: u32,
    lamp: u32,
}

impl Paint {
    fn new(materials: &mut Materials) -> Self {
        Self {
            white: materials.matt("white", [0.725, 0.71, 0.68]),
            red: materials.matt("red", [0.63, 0.065, 0.05]),
            green: materials.matt("green", [0.14, 0.45, 0.091]),
            lamp: materials.lamp("ceiling light", [17.0, 12.0, 4.0]),
        }
    }
}

fn setting() -> Setting {
    let mut materials = Materials::default();
    Paint::new(&mut materials);
    Setting {
        materials: materials.0,
        textures: Vec::new(),
        lights: Vec::new(),
        environment: None,
        cameras: vec![
            camera("front", [0.278, 0.273, -0.8], [0.278, 0.273, 0.0], 0.109),
            camera("corner", [0.06, 0.46, 0.04], [0.36, 0.12, 0.5], 0.13),
        ],
    }
}

/// A point given in millimetres, as the box was measured.
fn millimetres(x: f64, y: f64, z: f64) -> DVec3 {
    dvec3(x, y, z) * 0.001
}

fn draw(canvas: &mut Canvas) {
    let paint = Paint::new(&mut Materials::default());
    walls(canvas, &paint);
    ceiling(canvas, &paint);
    for (height, footprint) in [
        (165.0, [[130.0, 65.0], [82.0, 225.0], [240.0, 272.0], [290.0, 114.0]]),
        (330.0, [[423.0, 247.0], [265.0, 296.0], [314.0, 456.0], [472.0, 406.0]]),
    ] {
        standing_block(canvas, paint.white, height, footprint);
    }
}

/// Into how many cells to cut an edge; all edges of equal length at one detail are cut alike, up
/// to one cell.
fn cells(canvas: &mut Canvas, from: DVec3, to: DVec3) -> u32 {
    canvas.steps(8.0 * from.distance(to) / EDGE, 1)
}

fn wall(canvas: &mut Canvas, material: u32, corners: [DVec3; 4]) {
    let across = cells(canvas, corners[0], corners[1]);
    let along = cells(canvas, corners[1], corners[2]);
    patch(canvas, material, corners, [across, along]);
}

fn walls(canvas: &mut Canvas, paint: &Paint) {
    let (width, height, depth) = (556.0, 548.8, 559.2);
    let [a, b, c, d] =
        [(0.0, 0.0), (width, 0.0), (width, depth), (0.0, depth)].map(|(x, z)| millimetres(x, 0.0, z));
    let up = millimetres(0.0, height, 0.0);
    wall(canvas, paint.white, [d, c, b, a]);
    wall(canvas, paint.white, [c, d, d + up, c + up]);
    wall(canvas, paint.red, [b, c, c + up, b + up]);
    wall(canvas, paint.green, [d, a, a + up, d + up]);
}

/// The ceiling around the light, and the light in its opening.
fn ceiling(canvas: &mut Canvas, paint: &Paint) {
    let xs = [0.0, 213.0, 343.0, 556.0];
    let zs = [0.0, 227.0, 332.0, 559.2];
    let piece = |x: [usize; 2], z: [usize; 2]| {
        [(x[0], z[0]), (x[1], z[0]), (x[1], z[1]), (x[0], z[1])]
            .map(|(x, z)| millimetres(xs[x], 548.8, zs[z]))
    };
    wall(canvas, paint.white, piece([0, 3], [0, 1]));
    wall(canvas, paint.white, piece([0, 1], [1, 2]));
    wall(canvas, paint.white, piece([2, 3], [1, 2]));
    wall(canvas, paint.white, piece([0, 3], [2, 3]));
    wall(canvas, paint.lamp, piece([1, 2], [1, 2]));
}

/// A block on the floor; its footprint runs counter-clockwise seen from below.
fn standing_block(canvas: &mut Canvas, material: u32, height: f64, footprint: [[f64; 2]; 4]) {
    let below = footprint.map(|[x, z]| millimetres(x, 0.0, z));
    let above = footprint.map(|[x, z]| millimetres(x, height, z));
    // Shared by the faces that meet in an edge, so that no edge opens.
    let around = [cells(canvas, below[0], below[1]), cells(canvas, below[1], below[2])];
    let upwards = cells(canvas, below[0], above[0]);
    patch(canvas, material, above, around);
    for here in 0..4 {
        let next = (here + 1) % 4;
        let corners = [below[here], below[next], above[next], above[here]];
        patch(canvas, material, corners, [around[here % 2], upwards]);
    }
}
