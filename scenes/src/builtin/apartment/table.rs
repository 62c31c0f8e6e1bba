//! Tables, chairs and what is laid on tables.

use glam::{DAffine3, DVec3, dvec3};

use super::super::mesh::Canvas;
use super::super::numbers::{Dice, sin_cos};
use super::super::shapes::{ball, place, revolve, stretch, tube};
use super::Paint;
use super::decor::{self, soft_block};

/// A table of 2.0 by 1.0 m with turned legs, laid for four.
pub(super) fn dining_table(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3) {
    soft_block(canvas, paint.oak, frame, ([-1.0, 0.72, -0.5], [1.0, 0.76, 0.5]), 0.012);
    for (low, high) in [
        ([-0.88, 0.62, -0.42], [0.88, 0.72, -0.4]),
        ([-0.88, 0.62, 0.4], [0.88, 0.72, 0.42]),
        ([-0.9, 0.62, -0.4], [-0.88, 0.72, 0.4]),
        ([0.88, 0.62, -0.4], [0.9, 0.72, 0.4]),
    ] {
        soft_block(canvas, paint.oak, frame, (low, high), 0.004);
    }
    for (x, z) in [(-0.86, -0.38), (0.86, -0.38), (0.86, 0.38), (-0.86, 0.38)] {
        let facets = [canvas.steps(26.0, 6), canvas.steps(4.0, 1)];
        let leg = [[0.02, 0.0], [0.028, 0.06], [0.02, 0.1], [0.04, 0.4], [0.028, 0.52], [0.045, 0.58]];
        let head = [[0.045, 0.58], [0.045, 0.72]];
        revolve(canvas, paint.oak, &(*frame * place(x, 0.0, z, 0.0)), &[&leg, &head], facets);
    }
    let top = *frame * place(0.0, 0.76, 0.0, 0.0);
    for (x, z, turns) in [(-0.5, 0.3, 0.0), (0.5, 0.3, 0.0), (-0.5, -0.3, 0.5), (0.5, -0.3, 0.5)] {
        let setting = top * place(x, 0.0, z, turns);
        plate(canvas, paint, &setting, 0.13);
        plate(canvas, paint, &(setting * place(0.0, 0.008, 0.0, 0.0)), 0.095);
        cutlery(canvas, paint, &setting);
        glass(canvas, paint, &(setting * place(0.16, 0.0, -0.14, 0.0)));
    }
    fruit_bowl(canvas, paint, &top);
    bottle(canvas, paint, &(top * place(0.28, 0.0, 0.08, 0.0)));
    decor::vase(canvas, paint, &(top * place(-0.3, 0.0, -0.02, 0.0)), 0.22);
}

/// A chair with a slatted back, looking along z.
pub(super) fn chair(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3) {
    soft_block(canvas, paint.oak, frame, ([-0.22, 0.43, -0.21], [0.22, 0.46, 0.23]), 0.012);
    decor::cushion(canvas, paint.cushions[2], &(*frame * place(0.0, 0.475, 0.01, 0.0)), [0.2, 0.025, 0.2]);
    let around = canvas.steps(14.0, 5);
    let along = canvas.steps(10.0, 3);
    let mut bar = |points: [[f64; 3]; 3], thickness: f64| {
        // A parabola through the three points.
        let [a, b, c] = points.map(DVec3::from);
        let path: Vec<DVec3> = (0..=along)
            .map(|step| {
                let t = f64::from(step) / f64::from(along);
                let point =
                    a * ((1.0 - t) * (1.0 - 2.0 * t)) + b * (4.0 * t * (1.0 - t)) + c * (t * (2.0 * t - 1.0));
                frame.transform_point3(point)
            })
            .collect();
        tube(canvas, paint.oak, &path, |_| thickness, around);
    };
    for side in [-1.0, 1.0] {
        bar([[0.21 * side, 0.0, 0.21], [0.2 * side, 0.22, 0.2], [0.19 * side, 0.44, 0.19]], 0.016);
        let back_leg = [[0.21 * side, 0.0, -0.23], [0.19 * side, 0.44, -0.18], [0.19 * side, 0.9, -0.27]];
        bar(back_leg, 0.016);
        bar([[0.2 * side, 0.18, 0.2], [0.2 * side, 0.18, 0.0], [0.2 * side, 0.18, -0.2]], 0.01);
    }
    for (y, z) in [(0.88, -0.265), (0.58, -0.2)] {
        bar([[-0.19, y, z], [0.0, y + 0.01, z - 0.05], [0.19, y, z]], 0.014);
    }
    for slat in 0..5 {
        let x = 0.065 * (f64::from(slat) - 2.0);
        let bow = 0.045 - 2.0 * x * x;
        bar([[x, 0.58, -0.2 - bow], [x, 0.73, -0.23 - bow], [x, 0.88, -0.265 - bow]], 0.008);
    }
}

/// A plate of this radius.
pub(super) fn plate(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3, radius: f64) {
    let facets = [canvas.steps(48.0, 10), canvas.steps(3.0, 1)];
    let under = [[0.0, 0.002], [0.6 * radius, 0.0], [radius, 0.016]];
    let lip = [[radius, 0.016], [0.98 * radius, 0.019]];
    let upper = [[0.98 * radius, 0.019], [0.64 * radius, 0.006], [0.0, 0.006]];
    revolve(canvas, paint.china, frame, &[&under, &lip, &upper], facets);
}

/// A cup with its handle.
pub(super) fn cup(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3) {
    let facets = [canvas.steps(36.0, 8), canvas.steps(3.0, 1)];
    let outside = [[0.0, 0.001], [0.024, 0.0], [0.037, 0.04], [0.04, 0.08]];
    let lip = [[0.04, 0.08], [0.037, 0.081]];
    let inside = [[0.037, 0.081], [0.033, 0.04], [0.025, 0.006], [0.0, 0.006]];
    revolve(canvas, paint.china, frame, &[&outside, &lip, &inside[..3], &inside[2..]], facets);
    let along = canvas.steps(14.0, 4);
    let path: Vec<DVec3> = (0..=along)
        .map(|step| {
            let (sine, cosine) = sin_cos(0.5 * f64::from(step) / f64::from(along));
            frame.transform_point3(dvec3(0.036 + 0.028 * sine, 0.042 + 0.024 * cosine, 0.0))
        })
        .collect();
    tube(canvas, paint.china, &path, |_| 0.004, facets[0] / 4 + 1);
}

/// A stemmed glass of coloured glass.
fn glass(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3) {
    let facets = [canvas.steps(32.0, 8), canvas.steps(4.0, 1)];
    let foot = [[0.0, 0.0], [0.033, 0.001], [0.006, 0.008], [0.004, 0.07]];
    let bowl = [[0.004, 0.07], [0.034, 0.1], [0.036, 0.14], [0.03, 0.17]];
    let lip = [[0.03, 0.17], [0.028, 0.17]];
    let inside = [[0.028, 0.17], [0.032, 0.14], [0.03, 0.105], [0.015, 0.082], [0.0, 0.078]];
    revolve(canvas, paint.bottle, frame, &[&foot, &bowl, &lip, &inside], facets);
}

pub(super) fn bottle(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3) {
    let facets = [canvas.steps(36.0, 8), canvas.steps(4.0, 1)];
    let body = [[0.036, 0.0], [0.038, 0.01], [0.038, 0.18]];
    let underside = [[0.0, 0.0], [0.036, 0.0]];
    let lip = [[0.014, 0.3], [0.016, 0.303], [0.011, 0.305]];
    let neck = [[0.038, 0.18], [0.034, 0.2], [0.015, 0.235], [0.014, 0.3]];
    let cork = [[0.011, 0.3], [0.011, 0.32], [0.0, 0.32]];
    revolve(canvas, paint.bottle, frame, &[&underside, &body, &neck, &lip[..2], &lip[1..]], facets);
    revolve(canvas, paint.pages, frame, &[&cork[..2], &cork[1..]], [facets[0], 1]);
}

/// A wide bowl with apples and oranges.
pub(super) fn fruit_bowl(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3) {
    let facets = [canvas.steps(56.0, 12), canvas.steps(5.0, 1)];
    let outside = [[0.0, 0.001], [0.06, 0.0], [0.055, 0.012], [0.12, 0.05], [0.15, 0.09]];
    let lip = [[0.15, 0.09], [0.146, 0.092]];
    let inside = [[0.146, 0.092], [0.11, 0.052], [0.05, 0.025], [0.0, 0.022]];
    revolve(canvas, paint.copper, frame, &[&outside, &lip, &inside], facets);
    let mut dice = Dice::new(331);
    for fruit in 0..7 {
        let (sine, cosine) = sin_cos(f64::from(fruit) / 6.0);
        let (out, y) = if fruit < 6 { (0.075, 0.085) } else { (0.0, 0.13) };
        let size = dice.between(0.034, 0.04);
        let spot = *frame * place(out * cosine, y, out * sine, 0.0) * stretch(size, 0.93 * size, size);
        let rows = canvas.steps(16.0, 4);
        ball(canvas, paint.fruit[dice.below(2)], &spot, rows);
    }
}

/// Knife, fork and spoon beside a plate.
fn cutlery(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3) {
    for x in [-0.165, 0.16, 0.185] {
        soft_block(canvas, paint.steel, frame, ([x - 0.005, 0.0, -0.02], [x + 0.005, 0.004, 0.1]), 0.002);
        let head = ([x - 0.009, 0.0, -0.09], [x + 0.009, 0.004, -0.02]);
        soft_block(canvas, paint.steel, frame, head, 0.002);
    }
}
