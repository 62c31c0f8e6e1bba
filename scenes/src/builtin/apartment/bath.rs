//! The bathroom: tub, basin with a mirror, toilet, towels.

use glam::{DAffine3, DVec3, dvec3};

use super::super::mesh::Canvas;
use super::super::numbers::{fractal_noise, sin_cos};
use super::super::shapes::{Shading, blocks, place, revolve, sheet, stretch, tube};
use super::decor::{self, soft_block};
use super::{BATH_LIGHT, CEILING, Paint};

pub(super) fn draw(canvas: &mut Canvas, paint: &Paint) {
    let [x, y, z] = BATH_LIGHT;
    decor::ceiling_lamp(canvas, paint, &place(x, y, z, 0.0), CEILING - y);
    bathtub(canvas, paint, &place(13.5, 0.0, 8.1, 0.25));
    basin(canvas, paint, &place(9.07, 0.0, 7.6, 0.25));
    toilet(canvas, paint, &place(9.6, 0.0, 9.9, 0.5));
    towel_rail(canvas, paint, &place(13.0, 0.0, 6.07, 0.0));
    decor::plant(canvas, paint, &place(12.6, 0.0, 9.6, 0.0), 0.9, 601);
    // Tiles up to shoulder height on the wall behind the tub and the basin.
    for (frame, length) in [(place(13.94, 0.0, 6.1, -0.25), 3.8), (place(9.06, 0.0, 9.9, 0.25), 3.8)] {
        wall_tiles(canvas, paint, &frame, length);
    }
}

fn wall_tiles(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3, length: f64) {
    let columns = (length / 0.2) as u32;
    for row in 0..9 {
        for column in 0..columns {
            let (x, y) = (0.2 * f64::from(column), 0.1 + 0.2 * f64::from(row));
            blocks(canvas, paint.wall_tile, frame, &[([x, y, 0.0], [x + 0.195, y + 0.195, 0.008])]);
        }
    }
}

/// An oval tub along x, 1.75 m long.
fn bathtub(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3) {
    let facets = [canvas.steps(80.0, 16), canvas.steps(8.0, 2)];
    let oval = *frame * stretch(0.875, 1.0, 0.4);
    let outside = [[0.78, 0.02], [0.86, 0.2], [0.95, 0.5], [1.0, 0.56]];
    let rim = [[1.0, 0.56], [1.0, 0.585], [0.93, 0.585], [0.9, 0.55]];
    let inside = [[0.9, 0.55], [0.82, 0.3], [0.6, 0.14], [0.0, 0.12]];
    revolve(canvas, paint.china, &oval, &[&outside, &rim, &inside], facets);
    let around = canvas.steps(14.0, 6);
    let tap = [[0.0, -0.42], [0.75, -0.42], [0.82, -0.38], [0.82, -0.28], [0.77, -0.25]]
        .map(|[y, z]| frame.transform_point3(dvec3(0.0, y, z)));
    tube(canvas, paint.chrome, &tap, |_| 0.016, around);
}

/// A basin on a foot below a mirror, its back at the origin.
fn basin(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3) {
    let facets = [canvas.steps(64.0, 12), canvas.steps(6.0, 2)];
    let bowl = *frame * place(0.0, 0.0, 0.27, 0.0) * stretch(0.3, 1.0, 0.22);
    let foot = [[0.4, 0.0], [0.25, 0.3], [0.3, 0.62]];
    let outside = [[0.3, 0.62], [0.8, 0.72], [1.0, 0.84], [0.98, 0.86]];
    let inside = [[0.98, 0.86], [0.9, 0.85], [0.6, 0.74], [0.0, 0.71]];
    revolve(canvas, paint.china, &bowl, &[&foot, &outside, &inside], facets);
    let around = canvas.steps(14.0, 6);
    let tap = [[0.83, 0.06], [0.98, 0.06], [1.02, 0.1], [1.01, 0.17], [0.98, 0.19]]
        .map(|[y, z]| frame.transform_point3(dvec3(0.0, y, z)));
    tube(canvas, paint.chrome, &tap, |_| 0.012, around);
    decor::framed(canvas, paint, &(*frame * place(0.0, 1.5, 0.0, 0.0)), [0.45, 0.4], paint.mirror);
    let shelf = ([-0.35, 1.04, 0.0], [0.35, 1.05, 0.12]);
    soft_block(canvas, paint.chrome, frame, shelf, 0.003);
    for (x, height) in [(-0.25, 0.12), (-0.15, 0.09), (0.22, 0.14)] {
        decor::vase(canvas, paint, &(*frame * place(x, 1.05, 0.06, 0.0)), height);
    }
}

/// A toilet, its back at the origin, along z.
fn toilet(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3) {
    let facets = [canvas.steps(56.0, 12), canvas.steps(5.0, 2)];
    let bowl = *frame * place(0.0, 0.0, 0.45, 0.0) * stretch(0.19, 1.0, 0.26);
    let outside = [[0.55, 0.0], [0.5, 0.15], [0.85, 0.32], [1.0, 0.4]];
    let seat = [[1.0, 0.4], [1.04, 0.42], [1.0, 0.44], [0.0, 0.45]];
    revolve(canvas, paint.china, &bowl, &[&outside, &seat], facets);
    soft_block(canvas, paint.china, frame, ([-0.2, 0.38, 0.0], [0.2, 0.78, 0.18]), 0.03);
    soft_block(canvas, paint.china, frame, ([-0.21, 0.78, -0.01], [0.21, 0.81, 0.19]), 0.012);
}

/// Two towels over a rail.
fn towel_rail(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3) {
    let around = canvas.steps(14.0, 6);
    for y in [1.2, 1.5] {
        let path = [[-0.45, 0.0], [-0.45, 0.1], [0.45, 0.1], [0.45, 0.0]]
            .map(|[x, z]| frame.transform_point3(DVec3::new(x, y, z)));
        tube(canvas, paint.chrome, &path, |_| 0.01, around);
    }
    let cells = [canvas.steps(28.0, 4), canvas.steps(44.0, 8)];
    for (index, x) in [(0, -0.2), (2, 0.22)] {
        sheet(canvas, paint.cushions[index], cells, Shading::Smooth, |u, v| {
            // Up the front, over the rail in a half circle, down behind it.
            let (y, z) = if v < 0.5 {
                (0.95 + 1.1 * v, 0.115)
            } else if v < 0.6 {
                let (sine, cosine) = sin_cos(5.0 * (v - 0.5));
                (1.5 + 0.015 * sine, 0.1 + 0.015 * cosine)
            } else {
                (1.5 - 1.1 * (v - 0.6), 0.085)
            };
            let sway = 0.008 * fractal_noise(611, 7.0 * u, 6.0 * v, 2) * (1.5 - y).clamp(0.0, 0.2) * 5.0;
            frame.transform_point3(dvec3(x + 0.16 * (2.0 * u - 1.0), y, z + sway))
        });
    }
}
