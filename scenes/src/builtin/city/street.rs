//! Streets: roadway, pavement, markings, lamps, trees and parked cars; and parks.

use glam::{DAffine3, DVec3, dvec3};

use super::super::mesh::Canvas;
use super::super::shapes::{block, patch, place, revolve, rounded_block, tilt, tube};
use super::{HALF_BLOCK, HALF_LOT, KERB, PITCH, Paint, Plot};

/// The ground of a plot and what stands on its pavement.
pub(super) fn draw(canvas: &mut Canvas, paint: &Paint, plot: &mut Plot) {
    let frame = plot.frame;
    let half = 0.5 * PITCH;
    flat(canvas, paint.asphalt, &frame, [-half, -half, half, half], 0.0);
    let (low, high) = (dvec3(-HALF_BLOCK, 0.0, -HALF_BLOCK), dvec3(HALF_BLOCK, KERB, HALF_BLOCK));
    block(canvas, paint.paving, &frame, low, high);
    for side in 0..4 {
        // x along the street, z towards its middle.
        let frame = frame * place(0.0, 0.0, 0.0, 0.25 * f64::from(side));
        if side < 2 && plot.keeps(canvas) {
            markings(canvas, paint, &frame);
        }
        for lamp in [-14.0, 14.0] {
            if plot.keeps(canvas) {
                street_lamp(canvas, paint, &(frame * place(lamp, KERB, HALF_BLOCK - 0.6, 0.0)));
            }
        }
        for tree in [-21.0, -7.0, 7.0, 21.0] {
            if plot.dice.chance(0.6) {
                let spot = frame * place(tree, KERB, HALF_BLOCK - 1.0, plot.dice.unit());
                let height = plot.dice.between(5.0, 8.0);
                super::tree(canvas, paint, plot, &spot, height);
            }
        }
        for space in 0..7 {
            let taken = plot.dice.chance(0.4) && plot.keeps(canvas);
            let (x, turns) = (f64::from(space) * 6.4 - 19.2, if plot.dice.chance(0.5) { 0.5 } else { 0.0 });
            let colour = paint.cars[plot.dice.below(paint.cars.len())];
            if taken {
                let spot = frame * place(x, 0.0, HALF_BLOCK + 1.3, turns);
                car(canvas, paint, plot, &spot, colour);
            }
        }
    }
}

/// A horizontal rectangle, given as least x and z, then greatest x and z.
fn flat(canvas: &mut Canvas, material: u32, frame: &DAffine3, sides: [f64; 4], y: f64) {
    let [left, back, right, front] = sides;
    let corners = [(left, front), (right, front), (right, back), (left, back)]
        .map(|(x, z)| frame.transform_point3(dvec3(x, y, z)));
    patch(canvas, material, corners, [1, 1]);
}

/// The broken line in the middle of a street and the zebra crossing at its end.
fn markings(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3) {
    const ABOVE_ASPHALT: f64 = 0.012;
    let middle = 0.5 * PITCH;
    for dash in 0..9 {
        let x = 5.5 * f64::from(dash) - 23.5;
        let sides = [x, middle - 0.08, x + 2.5, middle + 0.08];
        flat(canvas, paint.road_marking, frame, sides, ABOVE_ASPHALT);
    }
    for stripe in 0..10 {
        let z = HALF_BLOCK + 0.4 + 1.6 * f64::from(stripe);
        let sides = [-27.5, z, -24.5, z + 0.8];
        flat(canvas, paint.road_marking, frame, sides, ABOVE_ASPHALT);
    }
}

/// A mast with an arm over the roadway.
fn street_lamp(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3) {
    let path = [[0.0, 0.0], [6.2, 0.0], [7.0, 0.35], [7.3, 1.0], [7.35, 2.0]]
        .map(|[y, z]| frame.transform_point3(dvec3(0.0, y, z)));
    tube(canvas, paint.steel, &path, |t| 0.1 - 0.05 * t, 5);
    block(canvas, paint.steel, frame, dvec3(-0.16, 7.26, 1.6), dvec3(0.16, 7.4, 2.4));
}

/// A parked car, along x.
fn car(canvas: &mut Canvas, paint: &Paint, plot: &Plot, frame: &DAffine3, colour: u32) {
    let steps = plot.steps(canvas, 1.0, 1);
    let mut part = |material: u32, low: [f64; 3], high: [f64; 3], radius: f64| {
        let corners = [DVec3::from(low), DVec3::from(high)];
        rounded_block(canvas, material, frame, corners, radius, steps);
    };
    part(colour, [-2.1, 0.28, -0.86], [2.1, 0.88, 0.86], 0.2);
    part(paint.glass, [-1.5, 0.7, -0.76], [1.0, 1.38, 0.76], 0.3);
    block(canvas, colour, frame, dvec3(-1.2, 1.36, -0.6), dvec3(0.7, 1.41, 0.6));
    let around = plot.steps(canvas, 10.0, 5);
    for (x, z) in [(-1.3, 0.72), (1.3, 0.72), (-1.3, -0.72), (1.3, -0.72)] {
        let axle = *frame * place(x, 0.32, z, 0.0) * tilt(0.25);
        let (edge, hub) = (0.32, 0.19);
        let tyre = [[hub, -0.12], [edge, -0.12], [edge, 0.12], [hub, 0.12]];
        revolve(canvas, paint.tyre, &axle, &[&tyre[..2], &tyre[1..3], &tyre[2..]], [around, 1]);
        let caps = [[[0.0, -0.1], [hub, -0.11]], [[hub, 0.11], [0.0, 0.1]]];
        revolve(canvas, paint.steel, &axle, &[&caps[0], &caps[1]], [around, 1]);
    }
}

/// A lawn with paths, trees and benches.
pub(super) fn park(canvas: &mut Canvas, paint: &Paint, plot: &mut Plot) {
    let frame = plot.frame;
    let reach = HALF_LOT;
    flat(canvas, paint.lawn, &frame, [-reach, -reach, reach, reach], KERB + 0.02);
    flat(canvas, paint.paving, &frame, [-reach, -1.2, reach, 1.2], KERB + 0.04);
    flat(canvas, paint.paving, &frame, [-1.2, -reach, 1.2, reach], KERB + 0.045);
    for cell in 0..36 {
        let (column, row) = (cell % 6, cell / 6);
        let at = |index: i32| 8.0 * (f64::from(index) - 2.5);
        let (dx, dz) = (plot.dice.between(-1.8, 1.8), plot.dice.between(-1.8, 1.8));
        let stands = plot.dice.chance(0.75);
        let height = plot.dice.between(6.0, 11.0);
        if stands {
            let spot = frame * place(at(column) + dx, KERB, at(row) + dz, plot.dice.unit());
            super::tree(canvas, paint, plot, &spot, height);
        }
    }
    for bench in 0..8 {
        let side = if bench % 2 == 0 { 0.0 } else { 0.5 };
        let x = 11.0 * (f64::from(bench / 2) - 1.5);
        let frame = frame * place(x, KERB, 0.0, side) * place(0.0, 0.0, -1.9, 0.0);
        block(canvas, paint.bark, &frame, dvec3(-0.9, 0.42, -0.22), dvec3(0.9, 0.48, 0.22));
        block(canvas, paint.bark, &frame, dvec3(-0.9, 0.55, -0.28), dvec3(0.9, 0.95, -0.22));
        for leg in [-0.7, 0.7] {
            let (low, high) = (dvec3(leg - 0.05, 0.0, -0.2), dvec3(leg + 0.05, 0.42, 0.2));
            block(canvas, paint.steel, &frame, low, high);
        }
    }
}
