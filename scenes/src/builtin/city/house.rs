//! Houses with gable roofs, in gardens.

use glam::{DAffine3, dvec3};

use super::super::mesh::Canvas;
use super::super::shapes::{block, patch, place};
use super::{HALF_LOT, KERB, Paint, Plot};

/// Two rows of houses, back to back.
pub(super) fn row(canvas: &mut Canvas, paint: &Paint, plot: &mut Plot) {
    const HOUSES: u32 = 3;
    let lawn = [(-1.0, 1.0), (1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)]
        .map(|(x, z)| plot.frame.transform_point3(dvec3(HALF_LOT * x, KERB + 0.02, HALF_LOT * z)));
    patch(canvas, paint.lawn, lawn, [1, 1]);
    for side in 0..2 {
        for place_in_row in 0..HOUSES {
            if plot.is_vacant(side * HOUSES + place_in_row, 2 * HOUSES) {
                return;
            }
            let width = 2.0 * HALF_LOT / f64::from(HOUSES);
            let x = -HALF_LOT + width * (f64::from(place_in_row) + 0.5);
            let front = plot.frame * place(0.0, KERB, 0.0, 0.5 * f64::from(side));
            let set_back = plot.dice.between(12.5, 15.0);
            let frame = front * place(x, 0.0, set_back, 0.0);
            house(canvas, paint, plot, &frame);
            garden(canvas, paint, plot, &(front * place(x, 0.0, 0.0, 0.0)), 0.5 * width);
        }
    }
}

/// A house of one or two floors; z points to its street.
fn house(canvas: &mut Canvas, paint: &Paint, plot: &mut Plot, frame: &DAffine3) {
    let plot = &mut plot.part();
    let half_x = plot.dice.between(4.6, 6.2);
    let half_z = plot.dice.between(3.8, 4.8);
    let floors = 1 + plot.dice.below(2) as u32;
    let wall = [paint.white, paint.brick, paint.sandstone, paint.white][plot.dice.below(4)];
    let eaves = 0.4 + 2.7 * f64::from(floors);
    let (low, high) = (dvec3(-half_x, 0.0, -half_z), dvec3(half_x, eaves, half_z));
    block(canvas, wall, frame, low, high);
    gable_roof(canvas, paint, frame, [half_x, half_z], eaves, wall);
    let chimney = plot.dice.between(-0.7, 0.7) * half_x;
    let (low, high) = (dvec3(chimney - 0.35, eaves, -1.4), dvec3(chimney + 0.35, eaves + 3.6, -0.7));
    block(canvas, paint.brick, frame, low, high);
    for (turns, out, width) in
        [(0.0, half_z, half_x), (0.25, half_x, half_z), (0.5, half_z, half_x), (0.75, half_x, half_z)]
    {
        let facade = *frame * place(0.0, 0.0, 0.0, turns) * place(0.0, 0.0, out, 0.0);
        for floor in 0..floors {
            let columns = plot.steps(canvas, 3.0, 1);
            for column in 0..columns {
                let x = width * ((2.0 * f64::from(column) + 1.0) / f64::from(columns) - 1.0);
                let is_door = turns == 0.0 && floor == 0 && column == columns / 2;
                if is_door {
                    door(canvas, paint, &(facade * place(x, 0.0, 0.0, 0.0)));
                } else {
                    let sill = 1.2 + 2.7 * f64::from(floor);
                    window(canvas, paint, &(facade * place(x, sill, 0.0, 0.0)));
                }
            }
        }
    }
}

fn door(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3) {
    block(canvas, paint.white, frame, dvec3(-0.65, 0.0, 0.0), dvec3(0.65, 2.4, 0.08));
    block(canvas, paint.bark, frame, dvec3(-0.5, 0.1, 0.0), dvec3(0.5, 2.25, 0.12));
    block(canvas, paint.paving, frame, dvec3(-0.9, 0.0, 0.0), dvec3(0.9, 0.12, 1.2));
}

/// A pane in a frame with a bar across, above a sill.
fn window(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3) {
    block(canvas, paint.glass, frame, dvec3(-0.55, 0.0, 0.0), dvec3(0.55, 1.3, 0.03));
    for (low, high) in [
        ([-0.65, -0.1, 0.0], [0.65, 0.0, 0.14]),
        ([-0.65, 1.3, 0.0], [0.65, 1.42, 0.08]),
        ([-0.65, 0.0, 0.0], [-0.55, 1.3, 0.08]),
        ([0.55, 0.0, 0.0], [0.65, 1.3, 0.08]),
        ([-0.03, 0.0, 0.0], [0.03, 1.3, 0.06]),
    ] {
        block(canvas, paint.white, frame, low.into(), high.into());
    }
}

/// Two slopes with a thickness, the triangular walls below them, the ridge along x.
fn gable_roof(
    canvas: &mut Canvas,
    paint: &Paint,
    frame: &DAffine3,
    [half_x, half_z]: [f64; 2],
    eaves: f64,
    wall: u32,
) {
    let rise = 0.75 * half_z;
    let point = |x: f64, y: f64, z: f64| frame.transform_point3(dvec3(x, eaves + y, z));
    for side in [-1.0, 1.0] {
        let (reach, overhang) = (half_x + 0.5, half_z + 0.5);
        let drop = -0.5 * rise / half_z;
        for (lift, facing) in [(0.18, side), (0.0, -side)] {
            let edge = [facing * -reach, facing * reach];
            let corners = [
                point(edge[0], drop + lift, side * overhang),
                point(edge[1], drop + lift, side * overhang),
                point(edge[1], rise + lift, 0.0),
                point(edge[0], rise + lift, 0.0),
            ];
            patch(canvas, paint.roof_tile, corners, [1, 1]);
        }
        let fascia = [
            point(side * -reach, drop, side * overhang),
            point(side * reach, drop, side * overhang),
            point(side * reach, drop + 0.18, side * overhang),
            point(side * -reach, drop + 0.18, side * overhang),
        ];
        patch(canvas, paint.white, fascia, [1, 1]);
        let gable = [
            point(side * half_x, 0.0, side * half_z),
            point(side * half_x, 0.0, -side * half_z),
            point(side * half_x, rise, 0.0),
        ];
        triangle(canvas, wall, gable);
    }
}

fn triangle(canvas: &mut Canvas, material: u32, corners: [glam::DVec3; 3]) {
    canvas.draw(1, |mesh| {
        let corners = corners
            .map(|position| mesh.vertex(super::super::mesh::Vertex { position, ..Default::default() }));
        mesh.triangle(material, corners);
    });
}

/// Hedges between neighbours, a path to the door and trees behind the house.
fn garden(canvas: &mut Canvas, paint: &Paint, plot: &mut Plot, frame: &DAffine3, half: f64) {
    let corners = [(-0.7, HALF_LOT), (0.7, HALF_LOT), (0.7, 16.0), (-0.7, 16.0)]
        .map(|(x, z)| frame.transform_point3(dvec3(x, 0.04, z)));
    patch(canvas, paint.paving, corners, [1, 1]);
    let (low, high) = (dvec3(half - 0.25, 0.0, 0.0), dvec3(half + 0.25, 1.0, HALF_LOT));
    block(canvas, paint.white, frame, low, high);
    for z in [2.5, 5.5, 20.5] {
        let x = plot.dice.between(-0.75, 0.75) * half;
        let side = if x.abs() < 2.0 { 3.0 } else { 0.0 };
        let tree = *frame * place(x + side, 0.0, z, plot.dice.unit());
        let height = plot.dice.between(3.5, 7.0);
        super::tree(canvas, paint, plot, &tree, height);
    }
}
