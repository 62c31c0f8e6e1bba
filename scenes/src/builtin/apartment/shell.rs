//! The apartment itself: walls with their openings, floors, ceiling, windows, doors, curtains.

use glam::{DAffine3, dvec3};

use super::super::mesh::Canvas;
use super::super::numbers::{Dice, fractal_noise, sin_cos};
use super::super::shapes::{Shading, block, blocks, patch, place, ring, sheet, tilt, tube};
use super::decor;
use super::{CEILING, HALL_LIGHT, Paint};

/// Half the thickness of a wall.
const HALF_WALL: f64 = 0.06;

/// A hole in a wall.
#[derive(Clone, Copy)]
struct Opening {
    /// Distances along the wall, metres.
    from: f64,
    to: f64,
    /// Heights.
    sill: f64,
    head: f64,
}

const fn door(from: f64, to: f64) -> Opening {
    Opening { from, to, sill: 0.0, head: 2.1 }
}

const fn window(from: f64, to: f64) -> Opening {
    Opening { from, to, sill: 0.9, head: 2.25 }
}

pub(super) fn draw(canvas: &mut Canvas, paint: &Paint) {
    let at = |x: f64, z: f64| place(x, 0.0, z, 0.0);
    let down = |x: f64, z: f64| place(x, 0.0, z, -0.25);
    // Walls along x, from left to right.
    wall(canvas, paint, &at(0.0, 0.0), 14.0, &[window(1.2, 3.2), window(4.6, 6.6), window(9.6, 11.4)]);
    wall(canvas, paint, &at(8.0, 4.5), 6.0, &[door(2.2, 3.6)]);
    wall(canvas, paint, &at(0.0, 6.0), 14.0, &[door(3.7, 4.6), door(8.05, 8.95), door(11.2, 12.1)]);
    wall(canvas, paint, &at(0.0, 10.0), 14.0, &[window(1.5, 3.5), window(6.2, 7.8), window(11.0, 12.2)]);
    // Walls along z, from top to bottom.
    wall(canvas, paint, &down(0.0, 0.0), 10.0, &[window(2.0, 3.8)]);
    wall(canvas, paint, &down(8.0, 0.0), 6.0, &[door(1.4, 3.4), door(4.75, 5.75)]);
    wall(canvas, paint, &down(5.0, 6.0), 4.0, &[]);
    wall(canvas, paint, &down(9.0, 6.0), 4.0, &[]);
    wall(canvas, paint, &down(14.0, 0.0), 10.0, &[door(4.8, 5.7)]);
    let corners = [(0.0, 0.0), (14.0, 0.0), (14.0, 10.0), (0.0, 10.0)];
    patch(canvas, paint.ceiling, corners.map(|(x, z)| dvec3(x, CEILING, z)), [1, 1]);
    let mut roof = corners.map(|(x, z)| dvec3(x, CEILING + 0.2, z));
    roof.reverse();
    patch(canvas, paint.ceiling, roof, [1, 1]);
    planks(canvas, paint, [0.0, 8.0], [0.0, 6.0]);
    planks(canvas, paint, [8.0, 14.0], [4.5, 6.0]);
    planks(canvas, paint, [0.0, 9.0], [6.0, 10.0]);
    tiles(canvas, paint, [8.0, 14.0], [0.0, 4.5]);
    tiles(canvas, paint, [9.0, 14.0], [6.0, 10.0]);
    for (hinge, turns) in [((4.6, 6.0), -0.27), ((8.95, 6.0), -0.3), ((12.1, 6.0), -0.22)] {
        door_leaf(canvas, paint, &place(hinge.0, 0.0, hinge.1, turns));
    }
    door_leaf(canvas, paint, &place(14.0, 0.0, 5.69, -0.25));
    for (x, z, turns) in [(2.2, 0.06, 0.0), (5.6, 0.06, 0.0), (2.5, 9.94, 0.5), (7.0, 9.94, 0.5)] {
        curtains(canvas, paint, &place(x, 0.0, z, turns), 1.05);
        radiator(canvas, paint, &place(x, 0.0, z, turns));
    }
}

/// A wall along x of `frame`, with skirting, and frames in its openings (in ascending order).
fn wall(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3, length: f64, openings: &[Opening]) {
    let mut piece = |from: f64, to: f64, bottom: f64, top: f64| {
        let (low, high) = (dvec3(from, bottom, -HALF_WALL), dvec3(to, top, HALF_WALL));
        block(canvas, paint.wall, frame, low, high);
    };
    let mut solid_from = -HALF_WALL;
    for opening in openings {
        piece(solid_from, opening.from, 0.0, CEILING);
        piece(opening.from, opening.to, opening.head, CEILING);
        if opening.sill > 0.0 {
            piece(opening.from, opening.to, 0.0, opening.sill);
        }
        solid_from = opening.to;
    }
    piece(solid_from, length + HALF_WALL, 0.0, CEILING);
    let mut solid_from = 0.0;
    let doors = openings.iter().filter(|opening| opening.sill == 0.0);
    for (from, to) in doors.map(|door| (door.from, door.to)).chain([(length, length)]) {
        let reach = HALF_WALL + 0.015;
        let (low, high) = (dvec3(solid_from, 0.0, -reach), dvec3(from, 0.09, reach));
        block(canvas, paint.white, frame, low, high);
        solid_from = to;
    }
    for opening in openings {
        frame_of(canvas, paint, frame, *opening);
    }
}

/// The wooden frame of a door, or of a window with its sill and bars.
fn frame_of(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3, opening: Opening) {
    // Lying flat in a frame of its own: x along the wall, y through it, z downwards.
    let upright = *frame * tilt(0.25);
    let Opening { from, to, sill, head } = opening;
    let reach = HALF_WALL + 0.02;
    let foot = if sill > 0.0 { sill } else { -0.2 };
    let (low, high) = (dvec3(from - 0.05, -reach, -head - 0.05), dvec3(to + 0.05, reach, -foot + 0.05));
    ring(canvas, paint.white, &upright, [low, high], 0.08);
    if sill > 0.0 {
        let middle = 0.5 * (from + to);
        let parts = [
            ([middle - 0.04, sill, -0.03], [middle + 0.04, head, 0.03]),
            ([from, sill + 0.9, -0.02], [to, sill + 0.94, 0.02]),
            ([from - 0.1, sill - 0.03, -0.18], [to + 0.1, sill, 0.18]),
        ];
        blocks(canvas, paint.white, frame, &parts);
    }
}

/// A floor of planks of changing shade and length, along x.
fn planks(canvas: &mut Canvas, paint: &Paint, [left, right]: [f64; 2], [back, front]: [f64; 2]) {
    let rows = ((front - back) / 0.16) as i64;
    let width = (front - back) / rows as f64;
    for row in 0..rows {
        let mut dice = Dice::of_cell(201, row, (10.0 * left + back) as i64);
        let near = back + width * row as f64;
        let mut x = left;
        while x < right {
            let end = (x + dice.between(0.9, 2.0)).min(right);
            let shade = paint.planks[dice.below(3)];
            let corners = [(x, near + width), (end, near + width), (end, near), (x, near)];
            patch(canvas, shade, corners.map(|(x, z)| dvec3(x, 0.0, z)), [1, 1]);
            x = end;
        }
    }
}

/// A floor of square tiles with light joints.
fn tiles(canvas: &mut Canvas, paint: &Paint, [left, right]: [f64; 2], [back, front]: [f64; 2]) {
    const JOINT: f64 = 0.004;
    let (columns, rows) = (((right - left) / 0.4) as u32, ((front - back) / 0.4) as u32);
    let size = ((right - left) / f64::from(columns), (front - back) / f64::from(rows));
    let corners = [(left, front), (right, front), (right, back), (left, back)];
    patch(canvas, paint.ceiling, corners.map(|(x, z)| dvec3(x, -JOINT, z)), [1, 1]);
    for column in 0..columns {
        for row in 0..rows {
            let (x, z) = (left + size.0 * f64::from(column), back + size.1 * f64::from(row));
            let low = dvec3(x + JOINT, -0.01, z + JOINT);
            let high = dvec3(x + size.0 - JOINT, 0.0, z + size.1 - JOINT);
            block(canvas, paint.floor_tile, &DAffine3::IDENTITY, low, high);
        }
    }
}

/// A panelled door with its handles; the hinge is at the origin, the leaf along -x when closed.
fn door_leaf(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3) {
    block(canvas, paint.white, frame, dvec3(-0.87, 0.01, -0.02), dvec3(-0.02, 2.06, 0.02));
    for (bottom, top) in [(0.15, 0.85), (1.0, 1.95)] {
        let upright = *frame * tilt(0.25);
        let (low, high) = (dvec3(-0.76, -0.035, -top), dvec3(-0.13, 0.035, -bottom));
        ring(canvas, paint.white, &upright, [low, high], 0.035);
    }
    let around = canvas.steps(10.0, 5);
    for side in [-1.0, 1.0] {
        let path = [[-0.8, 0.02], [-0.8, 0.055], [-0.785, 0.07], [-0.68, 0.07]]
            .map(|[x, z]| frame.transform_point3(dvec3(x, 1.04, side * z)));
        tube(canvas, paint.brass, &path, |_| 0.009, around);
    }
}

/// A rod with a curtain on each side of a window; z points into the room.
fn curtains(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3, half: f64) {
    let around = canvas.steps(10.0, 5);
    let rod = [-half - 0.35, half + 0.35].map(|x| frame.transform_point3(dvec3(x, 2.42, 0.12)));
    tube(canvas, paint.brass, &rod, |_| 0.014, around);
    let cells = [canvas.steps(64.0, 16), canvas.steps(24.0, 4)];
    for (side, seed) in [(-1.0, 1), (1.0, 2)] {
        sheet(canvas, paint.curtain, cells, Shading::Smooth, |u, v| {
            let (wave, _) = sin_cos(8.0 * u);
            let loose = 1.0 - 0.6 * v;
            let depth = 0.13
                + 0.05 * wave * (0.4 + 0.6 * loose)
                + 0.02 * loose * fractal_noise(seed, 6.0 * u, 2.0 * v, 2);
            let x = side * (half + 0.05) + 0.28 * (2.0 * u - 1.0) * (0.85 + 0.15 * loose);
            frame.transform_point3(dvec3(x, 0.03 + 2.38 * v, depth))
        });
    }
}

/// A radiator with ribs below a window.
fn radiator(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3) {
    for rib in 0..22 {
        let x = 0.06 * (f64::from(rib) - 10.5);
        let parts = [([x - 0.02, 0.12, 0.03], [x + 0.02, 0.72, 0.1])];
        blocks(canvas, paint.white, frame, &parts);
    }
    let bars = [([-0.68, 0.16, 0.05], [0.68, 0.2, 0.08]), ([-0.68, 0.64, 0.05], [0.68, 0.68, 0.08])];
    blocks(canvas, paint.white, frame, &bars);
}

/// The hall: its lamp, a bench with shoes' room, hooks, a mirror.
pub(super) fn furnish_hall(canvas: &mut Canvas, paint: &Paint) {
    let [x, y, z] = HALL_LIGHT;
    decor::ceiling_lamp(canvas, paint, &place(x, y, z, 0.0), CEILING - y);
    let bench = place(12.9, 0.0, 5.74, 0.5);
    let parts = [
        ([-0.55, 0.42, -0.18], [0.55, 0.46, 0.18]),
        ([-0.55, 0.0, -0.18], [-0.51, 0.42, 0.18]),
        ([0.51, 0.0, -0.18], [0.55, 0.42, 0.18]),
        ([-0.51, 0.16, -0.18], [0.51, 0.18, 0.18]),
    ];
    blocks(canvas, paint.oak, &bench, &parts);
    decor::framed(canvas, paint, &place(9.6, 1.5, 5.93, 0.5), [0.4, 0.6], paint.mirror);
    decor::plant(canvas, paint, &place(13.6, 0.0, 4.9, 0.0), 1.3, 211);
    decor::framed(canvas, paint, &place(13.2, 1.55, 4.57, 0.0), [0.35, 0.25], paint.pictures[2]);
}
