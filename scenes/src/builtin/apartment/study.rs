//! The study: a desk with a computer, an office chair, walls of books.

use glam::{DAffine3, DVec3, dvec3};

use super::super::mesh::Canvas;
use super::super::numbers::sin_cos;
use super::super::shapes::{ball, block, blocks, place, revolve, stretch, tilt, tube};
use super::decor::{self, soft_block};
use super::table::cup;
use super::{CEILING, DESK_LIGHT, Paint, STUDY_LIGHT};

pub(super) fn draw(canvas: &mut Canvas, paint: &Paint) {
    let desk = place(6.9, 0.0, 9.5, 0.5);
    desk_with_computer(canvas, paint, &desk);
    office_chair(canvas, paint, &place(6.95, 0.0, 8.65, 0.03));
    let [x, y, z] = STUDY_LIGHT;
    decor::ceiling_lamp(canvas, paint, &place(x, y, z, 0.0), CEILING - y);
    let [x, y, z] = DESK_LIGHT;
    decor::standing_lamp(canvas, paint, &place(x, y, z, 0.0), y - 0.74);
    for (index, z) in [7.2, 8.25].into_iter().enumerate() {
        let shelf = place(8.93, 0.0, z, -0.25);
        decor::bookcase(canvas, paint, &shelf, [1.0, 2.16], 501 + index as u64);
    }
    for (index, z) in [7.0, 8.05].into_iter().enumerate() {
        let shelf = place(5.07, 0.0, z, 0.25);
        decor::bookcase(canvas, paint, &shelf, [1.0, 1.8], 511 + index as u64);
    }
    decor::framed(canvas, paint, &place(6.7, 1.6, 6.07, 0.0), [0.6, 0.45], paint.pictures[1]);
    decor::plant(canvas, paint, &place(8.5, 0.0, 9.5, 0.0), 1.3, 521);
}

/// A desk, its user on the side of z.
fn desk_with_computer(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3) {
    soft_block(canvas, paint.oak, frame, ([-1.3, 0.7, -0.38], [1.3, 0.74, 0.38]), 0.01);
    for x in [-1.2, 1.2] {
        let legs = [
            ([x - 0.03, 0.0, -0.34], [x + 0.03, 0.7, -0.28]),
            ([x - 0.03, 0.0, 0.28], [x + 0.03, 0.7, 0.34]),
            ([x - 0.03, 0.6, -0.28], [x + 0.03, 0.66, 0.28]),
        ];
        blocks(canvas, paint.black, frame, &legs);
    }
    let top = *frame * place(0.0, 0.74, 0.0, 0.0);
    for (x, turns) in [(-0.36, 0.02), (0.36, -0.02)] {
        monitor(canvas, paint, &(top * place(x, 0.0, -0.18, turns)));
    }
    keyboard(canvas, paint, &(top * place(0.0, 0.0, 0.17, 0.0)));
    let mouse = top * place(0.36, 0.012, 0.18, 0.0) * stretch(0.03, 0.018, 0.05);
    let rows = canvas.steps(16.0, 4);
    ball(canvas, paint.black, &mouse, rows);
    cup(canvas, paint, &(top * place(-0.5, 0.0, 0.2, 0.4)));
    decor::pile_of_books(canvas, paint, &(top * place(-0.9, 0.0, -0.1, 0.05)), 531);
    decor::pile_of_books(canvas, paint, &(top * place(0.75, 0.0, 0.1, -0.08)), 532);
}

fn monitor(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3) {
    soft_block(canvas, paint.black, frame, ([-0.31, 0.1, -0.03], [0.31, 0.5, 0.0]), 0.01);
    block(canvas, paint.screen, frame, dvec3(-0.3, 0.115, -0.01), dvec3(0.3, 0.49, 0.003));
    soft_block(canvas, paint.steel, frame, ([-0.03, 0.0, -0.06], [0.03, 0.3, -0.03]), 0.008);
    soft_block(canvas, paint.steel, frame, ([-0.13, 0.0, -0.12], [0.13, 0.01, 0.08]), 0.004);
}

/// A keyboard with its keys.
fn keyboard(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3) {
    soft_block(canvas, paint.steel, frame, ([-0.23, 0.0, -0.08], [0.23, 0.012, 0.08]), 0.005);
    for row in 0..5 {
        let keys = if row == 0 { 8 } else { 20 };
        for key in 0..keys {
            // The keys of the lowest row are wider.
            let width = 0.44 / f64::from(keys);
            let x = width * f64::from(key) - 0.22;
            let z = 0.045 - 0.027 * f64::from(row);
            let body = ([x + 0.0015, 0.01, z], [x + width - 0.0015, 0.019, z + 0.024]);
            soft_block(canvas, paint.black, frame, body, 0.003);
        }
    }
}

/// A chair on five castors, looking along z.
fn office_chair(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3) {
    soft_block(canvas, paint.black, frame, ([-0.25, 0.43, -0.24], [0.25, 0.52, 0.25]), 0.045);
    let back = *frame * place(0.0, 0.52, -0.26, 0.0) * tilt(-0.02);
    soft_block(canvas, paint.black, &back, ([-0.22, 0.08, -0.03], [0.22, 0.62, 0.04]), 0.035);
    let around = canvas.steps(16.0, 6);
    let spine = [[0.44, -0.12], [0.42, -0.3], [0.6, -0.33], [0.8, -0.34]]
        .map(|[y, z]| frame.transform_point3(dvec3(0.0, y, z)));
    tube(canvas, paint.chrome, &spine, |_| 0.018, around);
    let stem = [[0.03, 0.1], [0.03, 0.25], [0.018, 0.25], [0.018, 0.44]];
    revolve(canvas, paint.chrome, frame, &[&stem[..2], &stem[1..3], &stem[2..]], [around, 1]);
    for foot in 0..5 {
        let (sine, cosine) = sin_cos(f64::from(foot) / 5.0);
        let path = [(0.02, 0.13), (0.16, 0.1), (0.3, 0.075)]
            .map(|(out, y)| frame.transform_point3(dvec3(out * cosine, y, out * sine)));
        tube(canvas, paint.chrome, &path, |t| 0.024 - 0.01 * t, around);
        let castor = *frame * place(0.3 * cosine, 0.033, 0.3 * sine, 0.0) * stretch(0.033, 0.033, 0.033);
        let rows = canvas.steps(10.0, 4);
        ball(canvas, paint.black, &castor, rows);
    }
    for side in [-1.0, 1.0] {
        let arm = [[0.3, 0.46, 0.0], [0.3, 0.68, -0.02], [0.29, 0.7, 0.16]]
            .map(|[x, y, z]| frame.transform_point3(DVec3::new(side * x, y, z)));
        tube(canvas, paint.black, &arm, |_| 0.02, around);
    }
}
