//! The kitchen: a row of cupboards with sink and stove, a fridge, open shelves, a glowing panel.

use glam::{DAffine3, DVec3, dvec3};

use super::super::mesh::Canvas;
use super::super::numbers::sin_cos;
use super::super::shapes::{block, blocks, patch, place, revolve, ring, tube};
use super::decor::{self, soft_block};
use super::table::{bottle, cup, fruit_bowl, plate};
use super::{CEILING, Paint};

/// Height of the worktops, metres.
const WORKTOP: f64 = 0.9;

pub(super) fn draw(canvas: &mut Canvas, paint: &Paint) {
    // Along the outer wall with the window, and along the right-hand wall.
    let back = place(10.5, 0.0, 0.06, 0.0);
    cupboards(canvas, paint, &(back * place(-2.1, 0.0, 0.0, 0.0)), 8);
    sink(canvas, paint, &(back * place(0.0, WORKTOP, 0.31, 0.0)));
    let right = place(13.94, 0.0, 1.7, -0.25);
    cupboards(canvas, paint, &(right * place(-1.0, 0.0, 0.0, 0.0)), 4);
    stove(canvas, paint, &right);
    hood(canvas, paint, &right);
    fridge(canvas, paint, &place(13.55, 0.0, 3.9, -0.25));
    for (height, seed) in [(1.45, 0), (1.85, 1)] {
        crockery_shelf(canvas, paint, &place(13.0, height, 0.07, 0.0), seed);
    }
    island(canvas, paint, &place(11.0, 0.0, 2.7, 0.0));
    panel(canvas, paint, &place(11.0, CEILING, 2.3, 0.0));
    wall_tiles(canvas, paint, &place(8.07, WORKTOP + 0.03, 0.062, 0.0));
}

/// A row of base cupboards, 0.6 m each, with handles and a worktop; the left end at the origin.
fn cupboards(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3, count: u32) {
    let length = 0.6 * f64::from(count);
    let carcass = ([0.0, 0.1, 0.0], [length, WORKTOP - 0.04, 0.58]);
    blocks(canvas, paint.white, frame, &[carcass]);
    blocks(canvas, paint.black, frame, &[([0.0, 0.0, 0.0], [length, 0.1, 0.52])]);
    let top = ([-0.01, WORKTOP - 0.04, 0.0], [length + 0.01, WORKTOP, 0.63]);
    soft_block(canvas, paint.worktop, frame, top, 0.008);
    let around = canvas.steps(10.0, 4);
    for cupboard in 0..count {
        let x = 0.6 * f64::from(cupboard);
        let fronts: &[[f64; 2]] =
            if cupboard % 3 == 1 { &[[0.12, 0.36], [0.37, 0.61], [0.62, 0.84]] } else { &[[0.12, 0.84]] };
        for &[bottom, top] in fronts {
            let front = ([x + 0.005, bottom, 0.58], [x + 0.595, top, 0.6]);
            soft_block(canvas, paint.white, frame, front, 0.006);
            let y = top - 0.05;
            let path = [[0.18, 0.6], [0.18, 0.63], [0.2, 0.635], [0.4, 0.635], [0.42, 0.63], [0.42, 0.6]]
                .map(|[dx, z]| frame.transform_point3(dvec3(x + dx, y, z)));
            tube(canvas, paint.steel, &path, |_| 0.006, around);
        }
    }
}

/// A steel basin let into the worktop, with its tap; the origin is the middle of its rim.
fn sink(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3) {
    let (low, high) = (dvec3(-0.4, 0.0, -0.22), dvec3(0.4, 0.012, 0.22));
    ring(canvas, paint.steel, frame, [low, high], 0.04);
    let bottom = [(-0.36, 0.18), (0.36, 0.18), (0.36, -0.18), (-0.36, -0.18)]
        .map(|(x, z)| frame.transform_point3(dvec3(x, 0.002, z)));
    patch(canvas, paint.chrome, bottom, [4, 4]);
    let along = canvas.steps(24.0, 6);
    let around = canvas.steps(16.0, 6);
    let mut path = vec![frame.transform_point3(dvec3(0.0, 0.0, -0.24))];
    path.extend((0..=along).map(|step| {
        let (sine, cosine) = sin_cos(0.5 * f64::from(step) / f64::from(along));
        frame.transform_point3(dvec3(0.0, 0.25 + 0.1 * sine, -0.14 - 0.1 * cosine))
    }));
    path.push(frame.transform_point3(dvec3(0.0, 0.2, -0.04)));
    tube(canvas, paint.chrome, &path, |_| 0.013, around);
    let lever =
        [[0.03, 0.06, -0.24], [0.1, 0.1, -0.24]].map(|point| frame.transform_point3(DVec3::from(point)));
    tube(canvas, paint.chrome, &lever, |_| 0.008, around);
}

/// A hob with pots on the worktop of the right-hand wall, an oven below.
fn stove(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3) {
    let hob = ([-0.3, WORKTOP, 0.06], [0.3, WORKTOP + 0.008, 0.56]);
    soft_block(canvas, paint.screen, frame, hob, 0.003);
    soft_block(canvas, paint.black, frame, ([-0.29, 0.14, 0.6], [0.29, 0.7, 0.612]), 0.004);
    let handle = [[-0.22, 0.64], [0.22, 0.64]].map(|[x, y]| frame.transform_point3(dvec3(x, y, 0.65)));
    let around = canvas.steps(36.0, 10);
    tube(canvas, paint.steel, &handle, |_| 0.01, around / 3);
    for (x, z, radius, height) in [(-0.14, 0.2, 0.1, 0.13), (0.15, 0.42, 0.12, 0.09)] {
        let spot = *frame * place(x, WORKTOP + 0.008, z, 0.15);
        let outside = [[0.0, 0.0], [radius, 0.0], [radius, height], [radius + 0.006, height + 0.004]];
        let lid = [[radius, height + 0.004], [0.5 * radius, height + 0.02], [0.012, height + 0.026]];
        let knob = [[0.012, height + 0.026], [0.018, height + 0.045], [0.0, height + 0.05]];
        let pieces: [&[[f64; 2]]; 5] = [&outside[..2], &outside[1..3], &outside[2..], &lid, &knob];
        revolve(canvas, paint.copper, &spot, &pieces, [around, 3]);
        for side in [-1.0, 1.0] {
            let path = [[0.0, -0.04], [0.035, -0.03], [0.035, 0.03], [0.0, 0.04]]
                .map(|[out, z]| spot.transform_point3(dvec3(side * (radius + out), 0.75 * height, z)));
            tube(canvas, paint.steel, &path, |_| 0.006, around / 4);
        }
    }
}

/// A steel hood above the stove.
fn hood(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3) {
    let corner = |half: f64, depth: f64, y: f64| {
        [(-half, 0.0), (-half, depth), (half, depth), (half, 0.0)]
            .map(|(x, z)| frame.transform_point3(dvec3(x, y, z)))
    };
    let (below, above) = (corner(0.36, 0.5, 1.6), corner(0.14, 0.26, 1.9));
    for here in 0..3 {
        let next = here + 1;
        let corners = [below[here], below[next], above[next], above[here]];
        patch(canvas, paint.steel, corners, [1, 1]);
    }
    let parts = [([-0.14, 1.9, 0.0], [0.14, CEILING, 0.26]), ([-0.36, 1.55, 0.0], [0.36, 1.6, 0.5])];
    blocks(canvas, paint.steel, frame, &parts);
}

fn fridge(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3) {
    soft_block(canvas, paint.steel, frame, ([-0.32, 0.04, -0.3], [0.32, 0.7, 0.34]), 0.015);
    soft_block(canvas, paint.steel, frame, ([-0.32, 0.71, -0.3], [0.32, 1.9, 0.34]), 0.015);
    let around = canvas.steps(14.0, 5);
    for (bottom, top) in [(0.4, 0.66), (0.8, 1.4)] {
        let path = [[bottom, 0.34], [bottom, 0.38], [top, 0.38], [top, 0.34]]
            .map(|[y, z]| frame.transform_point3(dvec3(-0.26, y, z)));
        tube(canvas, paint.chrome, &path, |_| 0.01, around);
    }
}

/// A board with piles of plates, cups and bottles.
fn crockery_shelf(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3, seed: u32) {
    let (low, high) = (dvec3(-0.85, -0.03, 0.0), dvec3(0.85, 0.0, 0.28));
    block(canvas, paint.oak, frame, low, high);
    for pile in 0..2 {
        let x = -0.65 + 0.32 * f64::from(pile);
        for layer in 0..6 + seed {
            let spot = *frame * place(x, 0.008 * f64::from(layer), 0.14, 0.0);
            plate(canvas, paint, &spot, 0.12 - 0.02 * f64::from(pile));
        }
    }
    for index in 0..5 {
        let spot = place(0.02 + 0.11 * f64::from(index), 0.0, 0.14, 0.17 * f64::from(index));
        cup(canvas, paint, &(*frame * spot));
    }
    for index in 0..2 + seed {
        bottle(canvas, paint, &(*frame * place(0.62 + 0.09 * f64::from(index), 0.0, 0.14, 0.0)));
    }
}

/// A worktop in the middle of the room, with stools.
fn island(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3) {
    cupboards(canvas, paint, &(*frame * place(-0.9, 0.0, -0.3, 0.0)), 3);
    let top = *frame * place(0.0, WORKTOP, 0.0, 0.0);
    fruit_bowl(canvas, paint, &(top * place(0.5, 0.0, 0.0, 0.0)));
    decor::plant(canvas, paint, &(top * place(-0.7, 0.0, 0.0, 0.0)), 0.35, 341);
    for index in 0..3 {
        let spot = place(-0.25 + 0.13 * f64::from(index), 0.0, 0.1, 0.2 * f64::from(index));
        cup(canvas, paint, &(top * spot));
    }
    for x in [-0.5, 0.4] {
        stool(canvas, paint, &(*frame * place(x, 0.0, 0.62, 0.0)));
    }
}

fn stool(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3) {
    let around = canvas.steps(36.0, 8);
    let seat = [[0.0, 0.6], [0.16, 0.6], [0.175, 0.62], [0.16, 0.645], [0.0, 0.635]];
    revolve(canvas, paint.walnut, frame, &[&seat[..2], &seat[1..4], &seat[3..]], [around, 3]);
    for leg in 0..4 {
        let (sine, cosine) = sin_cos(0.125 + 0.25 * f64::from(leg));
        let path = [(0.2, 0.0), (0.13, 0.6)]
            .map(|(out, y)| frame.transform_point3(dvec3(out * cosine, y, out * sine)));
        tube(canvas, paint.black, &path, |_| 0.011, around / 4);
    }
    let rung: Vec<DVec3> = (0..=around)
        .map(|step| {
            let (sine, cosine) = sin_cos(f64::from(step) / f64::from(around));
            frame.transform_point3(dvec3(0.175 * cosine, 0.22, 0.175 * sine))
        })
        .collect();
    tube(canvas, paint.black, &rung, |_| 0.008, around / 6 + 3);
}

/// The glowing panel in its frame below the ceiling.
fn panel(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3) {
    let (low, high) = (dvec3(-0.65, -0.04, -0.35), dvec3(0.65, 0.0, 0.35));
    ring(canvas, paint.steel, frame, [low, high], 0.04);
    let corners = [(-0.6, -0.3), (0.6, -0.3), (0.6, 0.3), (-0.6, 0.3)]
        .map(|(x, z)| frame.transform_point3(dvec3(x, -0.03, z)));
    patch(canvas, paint.panel, corners, [1, 1]);
}

/// Glazed tiles above the worktop, on both sides of the window.
fn wall_tiles(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3) {
    const SIZE: f64 = 0.122;
    for row in 0..4 {
        for column in 0..48 {
            let (x, y) = (SIZE * f64::from(column), SIZE * f64::from(row));
            let is_at_window = (1.3..3.45).contains(&x);
            if !is_at_window {
                let tile = ([x, y, 0.0], [x + SIZE - 0.004, y + SIZE - 0.004, 0.01]);
                soft_block(canvas, paint.wall_tile, frame, tile, 0.003);
            }
        }
    }
}
