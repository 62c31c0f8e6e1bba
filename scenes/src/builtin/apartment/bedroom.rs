//! The bedroom: a double bed, bedside tables, a wardrobe, a chest with a mirror.

use glam::{DAffine3, dvec3};

use super::super::mesh::Canvas;
use super::super::numbers::{ease, fractal_noise};
use super::super::shapes::{Shading, block, blocks, place, revolve, sheet, tilt};
use super::decor::{self, soft_block};
use super::{BEDROOM_LIGHT, BEDSIDE_LIGHT, CEILING, Paint};

pub(super) fn draw(canvas: &mut Canvas, paint: &Paint) {
    let bed = place(0.1, 0.0, 8.0, 0.25);
    double_bed(canvas, paint, &bed);
    for x in [-1.3, 1.3] {
        bedside_table(canvas, paint, &(bed * place(x, 0.0, 0.26, 0.0)));
    }
    let [x, y, z] = BEDROOM_LIGHT;
    decor::ceiling_lamp(canvas, paint, &place(x, y, z, 0.0), CEILING - y);
    let [x, y, z] = BEDSIDE_LIGHT;
    decor::standing_lamp(canvas, paint, &place(x, y, z, 0.0), y - 0.45);
    decor::pile_of_books(canvas, paint, &place(0.4, 0.45, 6.7, 0.2), 401);
    wardrobe(canvas, paint, &place(4.94, 0.0, 8.7, -0.25));
    chest(canvas, paint, &place(1.6, 0.0, 6.07, 0.0));
    decor::rug(canvas, paint, &place(3.0, 0.0, 8.0, 0.25), [1.1, 0.6]);
    decor::plant(canvas, paint, &place(4.55, 0.0, 7.0, 0.0), 1.2, 402);
    decor::framed(canvas, paint, &place(0.07, 1.55, 8.0, 0.25), [0.55, 0.35], paint.pictures[0]);
}

/// A bed of 1.7 by 2.1 m; the middle of its head is at the origin, it lies along z.
fn double_bed(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3) {
    soft_block(canvas, paint.walnut, frame, ([-0.92, 0.12, 0.0], [0.92, 0.34, 2.15]), 0.02);
    soft_block(canvas, paint.walnut, frame, ([-0.95, 0.05, -0.03], [0.95, 1.05, 0.05]), 0.025);
    for (x, z) in [(-0.82, 0.12), (0.82, 0.12), (-0.82, 2.02), (0.82, 2.02)] {
        let (low, high) = (dvec3(x - 0.03, 0.0, z - 0.03), dvec3(x + 0.03, 0.12, z + 0.03));
        block(canvas, paint.walnut, frame, low, high);
    }
    soft_block(canvas, paint.linen, frame, ([-0.87, 0.34, 0.06], [0.87, 0.54, 2.1]), 0.06);
    for x in [-0.43, 0.43] {
        let spot = *frame * place(x, 0.63, 0.36, 0.01 * x) * tilt(-0.035);
        decor::cushion(canvas, paint.linen, &spot, [0.36, 0.1, 0.23]);
        let spot = *frame * place(0.8 * x, 0.72, 0.6, 0.02 * x) * tilt(-0.1);
        decor::cushion(canvas, paint.cushions[if x < 0.0 { 0 } else { 1 }], &spot, [0.21, 0.08, 0.21]);
    }
    // The blanket: flat on top, hanging over both sides and the foot, with creases.
    let cells = [canvas.steps(110.0, 16), canvas.steps(96.0, 14)];
    sheet(canvas, paint.cushions[2], cells, Shading::Smooth, |u, v| {
        let across = (2.0 * u - 1.0) * 1.22;
        let along = 2.3 - 1.55 * v;
        let side = (across.abs() - 0.86).clamp(0.0, 0.36);
        let foot = (along - 2.06).clamp(0.0, 0.24);
        let top = 0.565 + 0.022 * (1.2 + fractal_noise(411, 9.0 * u, 6.0 * v, 4));
        let crease = 0.03 * fractal_noise(412, 14.0 * u, 12.0 * v, 2);
        let drop = |hang: f64| 0.9 * hang + 0.06 * ease((8.0 * hang).min(1.0));
        let y = top - drop(side).max(drop(foot));
        let x = across.signum() * (across.abs() - 0.8 * side + crease * ease((6.0 * side).min(1.0)));
        let z = along - 0.7 * foot + crease * ease((6.0 * foot).min(1.0));
        frame.transform_point3(dvec3(x, y, z))
    });
}

fn bedside_table(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3) {
    let parts = [
        ([-0.24, 0.42, -0.2], [0.24, 0.45, 0.2]),
        ([-0.22, 0.15, -0.2], [0.22, 0.42, 0.18]),
        ([-0.22, 0.0, -0.2], [-0.18, 0.15, -0.16]),
        ([0.18, 0.0, -0.2], [0.22, 0.15, -0.16]),
        ([-0.22, 0.0, 0.14], [-0.18, 0.15, 0.18]),
        ([0.18, 0.0, 0.14], [0.22, 0.15, 0.18]),
    ];
    blocks(canvas, paint.walnut, frame, &parts);
    drawer(canvas, paint, frame, ([-0.2, 0.18, 0.18], [0.2, 0.39, 0.2]));
}

/// The front of a drawer, with a knob in its middle.
fn drawer(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3, (low, high): ([f64; 3], [f64; 3])) {
    soft_block(canvas, paint.walnut, frame, (low, high), 0.006);
    let around = canvas.steps(16.0, 5);
    let rows = canvas.steps(2.0, 1);
    let middle = place(0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), high[2], 0.0);
    let turned = [[0.006, 0.0], [0.006, 0.014], [0.016, 0.022], [0.012, 0.03], [0.0, 0.032]];
    revolve(canvas, paint.brass, &(*frame * middle * tilt(0.25)), &[&turned], [around, rows]);
}

/// A wardrobe with four doors, its back at the origin.
fn wardrobe(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3) {
    let carcass = [([-1.05, 0.06, 0.0], [1.05, 2.2, 0.58]), ([-1.08, 2.2, 0.0], [1.08, 2.25, 0.62])];
    blocks(canvas, paint.white, frame, &carcass);
    blocks(canvas, paint.walnut, frame, &[([-1.03, 0.0, 0.02], [1.03, 0.06, 0.55])]);
    for door in 0..4 {
        let x = 0.525 * (f64::from(door) - 1.5);
        for (bottom, top) in [(0.08, 1.3), (1.32, 2.18)] {
            let front = ([x - 0.255, bottom, 0.58], [x + 0.255, top, 0.6]);
            soft_block(canvas, paint.white, frame, front, 0.008);
            let inset = ([x - 0.19, bottom + 0.07, 0.59], [x + 0.19, top - 0.07, 0.615]);
            soft_block(canvas, paint.oak, frame, inset, 0.01);
        }
    }
}

/// A chest of drawers with a mirror above it.
fn chest(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3) {
    blocks(canvas, paint.walnut, frame, &[([-0.6, 0.05, 0.0], [0.6, 0.8, 0.42])]);
    blocks(canvas, paint.oak, frame, &[([-0.62, 0.8, 0.0], [0.62, 0.83, 0.45])]);
    for row in 0..3 {
        for column in 0..2 {
            let (x, y) = (0.59 * f64::from(column) - 0.58, 0.09 + 0.235 * f64::from(row));
            drawer(canvas, paint, frame, ([x, y, 0.42], [x + 0.57, y + 0.22, 0.44]));
        }
    }
    decor::framed(canvas, paint, &(*frame * place(0.0, 1.45, 0.0, 0.0)), [0.5, 0.45], paint.mirror);
    decor::vase(canvas, paint, &(*frame * place(-0.45, 0.83, 0.2, 0.0)), 0.25);
}
