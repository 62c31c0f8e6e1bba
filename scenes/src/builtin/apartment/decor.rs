//! What stands about in every room: lamps, plants, pictures, books, cushions.

use glam::{DAffine3, DVec3, dvec3};

use super::super::mesh::Canvas;
use super::super::numbers::{Dice, fractal_noise, sin_cos};
use super::super::shapes::{
    Shading, block, blocks, lump, place, revolve, ring, rounded_block, sheet, stretch, tilt, tube,
};
use super::Paint;

/// A shade on a cord around the sphere light at the origin of `frame`; the cord ends in the
/// ceiling, so many metres above.
pub(super) fn hanging_lamp(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3, cord: f64) {
    let shade = [[0.24, -0.08], [0.21, 0.02], [0.12, 0.12], [0.04, 0.16]];
    on_cord(canvas, paint, frame, cord, &shade);
}

/// The same with a flat dish above the light, which shines on the walls too.
pub(super) fn ceiling_lamp(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3, cord: f64) {
    let dish = [[0.23, 0.085], [0.22, 0.095], [0.1, 0.12], [0.03, 0.16]];
    on_cord(canvas, paint, frame, cord, &dish);
}

fn on_cord(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3, cord: f64, shade: &[[f64; 2]]) {
    let facets = [canvas.steps(48.0, 10), canvas.steps(5.0, 2)];
    revolve(canvas, paint.brass, frame, &[shade], facets);
    let path = [0.14, cord].map(|y| frame.transform_point3(dvec3(0.0, y, 0.0)));
    tube(canvas, paint.black, &path, |_| 0.006, 6);
    let rose = [[0.06, cord - 0.03], [0.05, cord]];
    revolve(canvas, paint.brass, frame, &[&rose], [facets[0], 1]);
}

/// A lamp on a foot, its shade open above and below around the sphere light at the origin of
/// `frame`; `height` metres stand below the light.
pub(super) fn standing_lamp(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3, height: f64) {
    let facets = [canvas.steps(48.0, 10), canvas.steps(4.0, 1)];
    let size = 0.5 + 0.25 * height.min(1.6);
    let shade = [[0.26 * size, -0.16 * size], [0.17 * size, 0.24 * size]];
    revolve(canvas, paint.shade, frame, &[&shade], facets);
    let foot = [[0.0, -height], [0.17 * size, -height], [0.17 * size, 0.02 - height], [0.02, 0.05 - height]];
    revolve(canvas, paint.brass, frame, &[&foot[..2], &foot[1..3], &foot[2..]], facets);
    let pole = [-height + 0.03, -0.09].map(|y| frame.transform_point3(dvec3(0.0, y, 0.0)));
    tube(canvas, paint.brass, &pole, |_| 0.012, 8);
    for arm in 0..3 {
        let (sine, cosine) = sin_cos(f64::from(arm) / 3.0);
        let reach = 0.25 * size;
        let path = [(0.0, -0.1), (reach, -0.12 * size)]
            .map(|(out, y)| frame.transform_point3(dvec3(out * cosine, y, out * sine)));
        tube(canvas, paint.brass, &path, |_| 0.004, 5);
    }
}

/// A pot with long bent leaves.
pub(super) fn plant(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3, height: f64, seed: u64) {
    let facets = [canvas.steps(40.0, 8), canvas.steps(4.0, 1)];
    let size = 0.14 * height.sqrt();
    let pot = [[0.7 * size, 0.0], [0.95 * size, 0.9 * size], [1.05 * size, 1.6 * size]];
    let rim = [[1.05 * size, 1.6 * size], [1.12 * size, 1.7 * size], [0.95 * size, 1.68 * size]];
    revolve(canvas, paint.clay, frame, &[&pot, &rim], facets);
    let soil = [[1.0 * size, 1.55 * size], [0.0, 1.6 * size]];
    revolve(canvas, paint.soil, frame, &[&soil], [facets[0], 1]);
    let mut dice = Dice::of_cell(221, seed as i64, 0);
    for _ in 0..26 {
        let turned = *frame * place(0.0, 1.5 * size, 0.0, dice.unit());
        let length = height * dice.between(0.6, 1.0);
        let (bend, width) = (dice.between(0.3, 0.9), 0.045 * height.sqrt() * dice.between(0.7, 1.2));
        let cells = [2 * canvas.steps(2.0, 1), canvas.steps(14.0, 4)];
        sheet(canvas, paint.leaf, cells, Shading::Smooth, |u, v| {
            let across = 2.0 * u - 1.0;
            let half = width * (4.0 * v * (1.0 - v)).sqrt().max(0.08);
            let out = bend * length * v * v;
            let y = length * (v - 0.45 * bend * v * v * v) + 0.25 * half * across * across;
            turned.transform_point3(dvec3(across * half, y, 0.02 + out))
        });
    }
}

/// A picture or a mirror on a wall: x along it, z out of it, its middle at the origin.
pub(super) fn framed(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3, half: [f64; 2], inside: u32) {
    let [x, y] = half;
    let upright = *frame * tilt(0.25);
    ring(canvas, paint.walnut, &upright, [dvec3(-x, 0.0, -y), dvec3(x, 0.035, y)], 0.04);
    let (low, high) = (dvec3(-x + 0.03, -y + 0.03, 0.0), dvec3(x - 0.03, y - 0.03, 0.012));
    block(canvas, inside, frame, low, high);
}

/// A bookcase with its books; x along it, z out of it, its back at the origin.
pub(super) fn bookcase(
    canvas: &mut Canvas,
    paint: &Paint,
    frame: &DAffine3,
    [width, height]: [f64; 2],
    seed: u64,
) {
    const DEPTH: f64 = 0.3;
    let half = 0.5 * width;
    let boards = (height / 0.36) as u32;
    let step = height / f64::from(boards);
    let sides = [
        ([-half, 0.0, 0.0], [-half + 0.025, height, DEPTH]),
        ([half - 0.025, 0.0, 0.0], [half, height, DEPTH]),
        ([-half, 0.0, 0.0], [half, height, 0.01]),
        ([-half, height - 0.025, 0.0], [half, height, DEPTH]),
    ];
    blocks(canvas, paint.oak, frame, &sides);
    let mut dice = Dice::of_cell(231, seed as i64, 0);
    for board in 0..boards {
        let y = step * f64::from(board) + 0.03;
        let (low, high) = (dvec3(-half, y - 0.025, 0.0), dvec3(half, y, DEPTH));
        block(canvas, paint.oak, frame, low, high);
        let mut x = -half + 0.03;
        let full = half - dice.between(0.05, 0.3 * width);
        while x < full {
            let thickness = dice.between(0.018, 0.05);
            let size = [thickness, dice.between(0.19, 0.3), dice.between(0.14, 0.22)];
            let gap = DEPTH - 0.02 - size[2];
            let spot = *frame * place(x + 0.5 * thickness, y, gap, 0.0);
            book(canvas, paint, &spot, size, dice.below(paint.books.len()));
            x += thickness + 0.002;
        }
        if full < half - 0.16 {
            let spot = *frame * place(0.5 * (full + half) + 0.03, y, 0.15, 0.0);
            vase(canvas, paint, &spot, dice.between(0.14, 0.24));
        }
    }
}

/// An upright book; its spine faces z.
fn book(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3, size: [f64; 3], colour: usize) {
    let [thickness, height, depth] = size;
    let half = 0.5 * thickness;
    let cover = paint.books[colour];
    let boards = [
        ([-half, 0.0, 0.0], [-half + 0.003, height, depth]),
        ([half - 0.003, 0.0, 0.0], [half, height, depth]),
    ];
    blocks(canvas, cover, frame, &boards);
    let (low, high) = (dvec3(-half + 0.003, 0.004, 0.004), dvec3(half - 0.003, height - 0.004, depth));
    block(canvas, paint.pages, frame, low, high);
    // The rounded spine.
    let around = canvas.steps(6.0, 1);
    sheet(canvas, cover, [around, 1], Shading::Smooth, |u, v| {
        let (sine, cosine) = sin_cos(0.5 * u);
        frame.transform_point3(dvec3(-half * cosine, height * v, depth + 0.6 * half * sine))
    });
}

/// Books lying on each other.
pub(super) fn pile_of_books(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3, seed: u64) {
    let mut dice = Dice::of_cell(241, seed as i64, 0);
    let mut y = 0.0;
    for _ in 0..4 {
        let thickness = dice.between(0.02, 0.045);
        let turned = *frame * place(0.0, y + 0.5 * thickness, 0.0, dice.between(-0.04, 0.04));
        // Laid on its side: a book's own x becomes the vertical.
        let lying = turned * place(0.0, 0.0, 0.0, 0.25) * tilt(0.25) * place(0.0, 0.0, 0.0, 0.25);
        let spot = lying * place(0.0, -0.1, -0.08, 0.0);
        book(canvas, paint, &spot, [thickness, 0.2, 0.15], dice.below(paint.books.len()));
        y += thickness + 0.001;
    }
}

pub(super) fn vase(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3, height: f64) {
    let facets = [canvas.steps(36.0, 8), canvas.steps(4.0, 1)];
    let body = [[0.22, 0.0], [0.36, 0.25], [0.3, 0.55], [0.12, 0.8], [0.18, 1.0]];
    let lip = [[0.18, 1.0], [0.16, 1.0]];
    let inside = [[0.16, 1.0], [0.1, 0.8], [0.1, 0.6]];
    let frame = *frame * stretch(height, height, height);
    revolve(canvas, paint.copper, &frame, &[&body, &lip, &inside], facets);
}

/// A plump square cushion, lying; `half` is half its edge.
pub(super) fn cushion(canvas: &mut Canvas, material: u32, frame: &DAffine3, half: [f64; 3]) {
    let rows = canvas.steps(22.0, 5);
    let frame = *frame * stretch(half[0], half[1], half[2]);
    lump(canvas, material, &frame, rows, |outward| {
        let fourth = |x: f64| x * x * x * x;
        // A ball blown up towards a square, with drawn-in edges.
        let square = fourth(outward.x) + fourth(outward.y) + fourth(outward.z);
        1.0 / square.sqrt().sqrt()
    });
}

/// A rug with a little relief, and fringes on its short sides.
pub(super) fn rug(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3, half: [f64; 2]) {
    let cells = [canvas.steps(56.0, 4), canvas.steps(36.0, 4)];
    let [half_x, half_z] = half;
    sheet(canvas, paint.rug, cells, Shading::Smooth, |u, v| {
        let y = 0.012 + 0.002 * fractal_noise(251, 24.0 * u, 17.0 * v, 2);
        let (x, z) = ((2.0 * u - 1.0) * half_x, (1.0 - 2.0 * v) * half_z);
        frame.transform_point3(dvec3(x, y, z))
    });
    let fringes = canvas.steps(150.0, 10);
    for side in [-1.0, 1.0] {
        for fringe in 0..fringes {
            let mut dice = Dice::of_cell(252, i64::from(fringe), side as i64);
            let z = half_z * (2.0 * (f64::from(fringe) + 0.5) / f64::from(fringes) - 1.0);
            let sway = dice.between(-0.02, 0.02);
            let path: [DVec3; 4] =
                [(0.0, 0.012, 0.0), (0.03, 0.01, 0.3), (0.06, 0.006, 0.8), (0.08, 0.004, 1.0)]
                    .map(|(out, y, t)| frame.transform_point3(dvec3(side * (half_x + out), y, z + t * sway)));
            tube(canvas, paint.cushions[2], &path, |_| 0.0035, 4);
        }
    }
}

/// A block with softly rounded edges; sharp ones where the detail allows no better.
pub(super) fn soft_block(
    canvas: &mut Canvas,
    material: u32,
    frame: &DAffine3,
    (low, high): ([f64; 3], [f64; 3]),
    radius: f64,
) {
    match canvas.steps(4.0, 0) {
        0 => block(canvas, material, frame, low.into(), high.into()),
        steps => rounded_block(canvas, material, frame, [low.into(), high.into()], radius, steps),
    }
}
