//! The living room: sofa corner, dining table, shelves, television.

use glam::{DAffine3, dvec3};

use super::super::mesh::Canvas;
use super::super::shapes::{block, blocks, place, revolve, tilt};
use super::decor::{self, soft_block};
use super::table::{self, chair, dining_table};
use super::{CEILING, DINING_LIGHT, FLOOR_LAMP_LIGHT, LIVING_LIGHT, Paint};

pub(super) fn draw(canvas: &mut Canvas, paint: &Paint) {
    decor::rug(canvas, paint, &place(2.3, 0.0, 3.6, 0.0), [1.7, 1.2]);
    sofa(canvas, paint, &place(2.3, 0.0, 5.35, 0.5), 3);
    sofa(canvas, paint, &place(0.65, 0.0, 3.55, 0.25), 2);
    coffee_table(canvas, paint, &place(2.4, 0.0, 3.7, 0.0));
    television(canvas, paint, &place(2.6, 0.0, 0.32, 0.0));
    let [x, y, z] = LIVING_LIGHT;
    decor::ceiling_lamp(canvas, paint, &place(x, y, z, 0.0), CEILING - y);
    let [x, y, z] = FLOOR_LAMP_LIGHT;
    decor::standing_lamp(canvas, paint, &place(x, y, z, 0.0), y);
    decor::plant(canvas, paint, &place(4.15, 0.0, 0.55, 0.0), 1.7, 301);
    decor::plant(canvas, paint, &place(7.5, 0.0, 5.5, 0.0), 1.4, 302);

    let [x, y, z] = DINING_LIGHT;
    decor::hanging_lamp(canvas, paint, &place(x, y, z, 0.0), CEILING - y);
    let table = place(x, 0.0, z, 0.0);
    dining_table(canvas, paint, &table);
    for (dx, dz, turns) in [
        (-0.5, 0.78, 0.49),
        (0.5, 0.8, 0.51),
        (-0.5, -0.78, 0.01),
        (0.5, -0.82, -0.02),
        (-1.3, 0.0, 0.26),
        (1.32, 0.05, -0.24),
    ] {
        chair(canvas, paint, &(table * place(dx, 0.0, dz, turns)));
    }
    for (seed, x) in [(311, 4.0), (312, 5.05)] {
        // Against the wall to the bedroom and the study.
        let shelf = place(x + 1.1, 0.0, 5.93, 0.5);
        decor::bookcase(canvas, paint, &shelf, [1.0, 2.16], seed);
    }
    decor::framed(canvas, paint, &place(2.3, 1.65, 5.93, 0.5), [0.6, 0.4], paint.pictures[0]);
    decor::framed(canvas, paint, &place(0.07, 1.6, 4.9, 0.25), [0.3, 0.42], paint.pictures[1]);
    decor::framed(canvas, paint, &place(7.93, 1.6, 0.8, -0.25), [0.3, 0.42], paint.pictures[2]);
}

/// A sofa with so many seats, its back at the origin, looking along z.
fn sofa(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3, seats: u32) {
    let half = 0.36 * f64::from(seats);
    let cloth = paint.sofa;
    soft_block(canvas, cloth, frame, ([-half, 0.12, -0.5], [half, 0.3, 0.42]), 0.04);
    soft_block(canvas, cloth, frame, ([-half, 0.2, -0.54], [half, 0.78, -0.32]), 0.08);
    for side in [-1.0, 1.0] {
        let (near, far) = (side * half, side * (half + 0.2));
        let arm = ([near.min(far), 0.12, -0.52], [near.max(far), 0.6, 0.44]);
        soft_block(canvas, cloth, frame, arm, 0.09);
        for z in [-0.42, 0.34] {
            let leg = *frame * place(side * (half + 0.08), 0.0, z, 0.0);
            let around = canvas.steps(14.0, 5);
            revolve(canvas, paint.walnut, &leg, &[&[[0.018, 0.0], [0.03, 0.13]]], [around, 1]);
        }
    }
    for seat in 0..seats {
        let x = 0.72 * (f64::from(seat) + 0.5) - half;
        let cushion = ([x - 0.355, 0.3, -0.34], [x + 0.355, 0.46, 0.45]);
        soft_block(canvas, cloth, frame, cushion, 0.06);
        let leaning = *frame * place(x, 0.62, -0.24, 0.0) * tilt(0.215);
        decor::cushion(canvas, cloth, &leaning, [0.34, 0.11, 0.24]);
    }
    for (index, x) in [(0, 0.22 - half), (1, half - 0.26)] {
        let leaning = *frame * place(x, 0.62, -0.06, 0.03) * tilt(0.19);
        decor::cushion(canvas, paint.cushions[index], &leaning, [0.22, 0.08, 0.22]);
    }
}

fn coffee_table(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3) {
    let around = canvas.steps(72.0, 16);
    let top = [[0.0, 0.36], [0.5, 0.36], [0.52, 0.38], [0.5, 0.4], [0.0, 0.4]];
    revolve(canvas, paint.walnut, frame, &[&top[..2], &top[1..4], &top[3..]], [around, 2]);
    for leg in 0..3 {
        let turned = *frame * place(0.0, 0.0, 0.0, f64::from(leg) / 3.0);
        let leg = turned * place(0.0, 0.0, 0.34, 0.0) * tilt(0.02);
        revolve(canvas, paint.brass, &leg, &[&[[0.012, 0.0], [0.018, 0.36]]], [around / 4, 1]);
    }
    let top = *frame * place(0.0, 0.4, 0.0, 0.0);
    decor::pile_of_books(canvas, paint, &(top * place(-0.2, 0.0, 0.08, 0.1)), 321);
    table::fruit_bowl(canvas, paint, &(top * place(0.2, 0.0, -0.1, 0.0)));
    table::cup(canvas, paint, &(top * place(0.12, 0.0, 0.25, 0.3)));
}

/// A sideboard with a television on it.
fn television(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3) {
    let carcass = [([-0.95, 0.15, -0.2], [0.95, 0.55, 0.22]), ([-0.97, 0.55, -0.22], [0.97, 0.58, 0.24])];
    blocks(canvas, paint.oak, frame, &carcass);
    for door in 0..4 {
        let x = 0.475 * (f64::from(door) - 1.5);
        let front = ([x - 0.23, 0.17, 0.2], [x + 0.23, 0.53, 0.24]);
        soft_block(canvas, paint.white, frame, front, 0.008);
        let around = canvas.steps(12.0, 5);
        let knob = *frame * place(x + 0.17, 0.4, 0.24, 0.0) * tilt(0.25);
        let turned = [[0.006, 0.0], [0.006, 0.015], [0.015, 0.022], [0.0, 0.03]];
        revolve(canvas, paint.brass, &knob, &[&turned], [around, 1]);
    }
    for x in [-0.85, 0.85] {
        let legs = [
            ([x - 0.02, 0.0, -0.16], [x + 0.02, 0.15, -0.12]),
            ([x - 0.02, 0.0, 0.14], [x + 0.02, 0.15, 0.18]),
        ];
        blocks(canvas, paint.walnut, frame, &legs);
    }
    soft_block(canvas, paint.black, frame, ([-0.65, 0.66, -0.04], [0.65, 1.42, 0.0]), 0.015);
    let (low, high) = (dvec3(-0.63, 0.68, -0.01), dvec3(0.63, 1.4, 0.004));
    block(canvas, paint.screen, frame, low, high);
    let foot = [([-0.05, 0.58, -0.04], [0.05, 0.68, -0.01]), ([-0.25, 0.58, -0.12], [0.25, 0.595, 0.1])];
    blocks(canvas, paint.black, frame, &foot);
    decor::vase(canvas, paint, &(*frame * place(0.82, 0.58, 0.0, 0.0)), 0.3);
    decor::pile_of_books(canvas, paint, &(*frame * place(-0.8, 0.58, 0.0, 0.02)), 322);
}
