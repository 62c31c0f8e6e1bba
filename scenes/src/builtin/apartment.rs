//! `apartment`: six furnished rooms, lit from inside.
//!
//! In metres, x to the right and z down: the living room is 8 by 6 from the origin, to the right of it are the
//! kitchen and the hall, below it the bedroom, the study and the bathroom.

use glam::dvec3;

use super::canvas::Canvas;
use super::numbers::{Dice, sin_cos};
use super::setting::{Recipe, camera, environment, glossy, lamp, matt, metal, palette, sphere_light};
use super::shapes::{Frame, place, tilt};
use crate::Scene;

pub(super) const RECIPE: Recipe = Recipe {
    name: "apartment",
    description: "Six furnished rooms with doors, windows, curtains, books and mirrors, lit by lamps and a glowing panel.",
    triangles: [10_500, 400_000, 20_000_000],
    setting,
    draw,
};

/// From floor to ceiling, metres.
const CEILING: f64 = 2.7;
/// Half the thickness of a wall.
const HALF_WALL: f64 = 0.06;

palette! {
    WALL = matt("wall", [0.78, 0.75, 0.69]);
    PLANK = glossy("plank", [0.43, 0.28, 0.16], 0.35);
    TILE = glossy("tile", [0.32, 0.33, 0.34], 0.2);
    WHITE = glossy("white lacquer", [0.8, 0.79, 0.76], 0.3);
    OAK = glossy("oak", [0.5, 0.34, 0.19], 0.5);
    WALNUT = glossy("walnut", [0.24, 0.14, 0.08], 0.4);
    BLACK = glossy("black plastic", [0.03, 0.03, 0.035], 0.1);
    GRANITE = glossy("granite", [0.1, 0.1, 0.11], 0.15);
    CHINA = glossy("china", [0.84, 0.83, 0.8], 0.12);
    SOFA = matt("sofa cloth", [0.16, 0.24, 0.27]);
    MUSTARD = matt("mustard cloth", [0.62, 0.41, 0.08]);
    RUST = matt("rust cloth", [0.5, 0.17, 0.08]);
    LINEN = matt("linen", [0.78, 0.77, 0.74]);
    CURTAIN = matt("curtain", [0.62, 0.55, 0.43]);
    BLUE = matt("blue book", [0.08, 0.15, 0.36]);
    STEEL = metal("brushed steel", [0.6, 0.6, 0.62], 0.32);
    BRASS = metal("brass", [0.85, 0.63, 0.3], 0.28);
    MIRROR = metal("mirror", [0.93, 0.94, 0.94], 0.0);
    PANEL = lamp("ceiling panel", [14.0, 13.6, 12.6]);
}

/// Where the sphere lights are, and how bright; each hangs in a lamp of its own.
const LAMPS: [([f64; 3], f32); 6] = [
    ([2.6, 2.3, 3.0], 18.0),
    ([5.9, 1.65, 4.3], 12.0),
    ([2.9, 2.3, 8.0], 13.0),
    ([7.0, 2.3, 7.8], 11.0),
    ([10.5, 2.3, 5.25], 9.0),
    ([11.4, 2.3, 7.9], 11.0),
];

/// A hole in a wall: from where to where along it, and its sill and head.
type Opening = (f64, f64, [f64; 2]);
const DOOR: [f64; 2] = [0.0, 2.1];
const WINDOW: [f64; 2] = [0.9, 2.25];

/// Each wall from where, of which length, along z or else x, with its openings in ascending order.
const WALLS: [([f64; 2], f64, bool, &[Opening]); 9] = [
    ([0.0, 0.0], 14.0, false, &[(1.2, 3.2, WINDOW), (4.6, 6.6, WINDOW), (9.6, 11.4, WINDOW)]),
    ([8.0, 4.5], 6.0, false, &[(2.2, 3.6, DOOR)]),
    ([0.0, 6.0], 14.0, false, &[(3.7, 4.6, DOOR), (8.05, 8.95, DOOR), (11.2, 12.1, DOOR)]),
    ([0.0, 10.0], 14.0, false, &[(1.5, 3.5, WINDOW), (6.2, 7.8, WINDOW), (11.0, 12.2, WINDOW)]),
    ([0.0, 0.0], 10.0, true, &[(2.0, 3.8, WINDOW)]),
    ([8.0, 0.0], 6.0, true, &[(1.4, 3.4, DOOR), (4.75, 5.75, DOOR)]),
    ([5.0, 6.0], 4.0, true, &[]),
    ([9.0, 6.0], 4.0, true, &[]),
    ([14.0, 0.0], 10.0, true, &[(4.8, 5.7, DOOR)]),
];

/// Furniture that stands in one place: material, lowest and highest corner.
const FURNITURE: [(u32, [f64; 3], [f64; 3]); 33] = [
    // Living room: rug, television on a sideboard, pictures.
    (RUST, [0.9, 0.0, 2.4], [4.2, 0.02, 4.8]),
    (OAK, [1.7, 0.12, 0.08], [3.6, 0.55, 0.52]),
    (BLACK, [2.0, 0.55, 0.25], [3.3, 1.35, 0.29]),
    (BLUE, [1.8, 1.3, 5.91], [2.9, 2.0, 5.94]),
    (RUST, [0.06, 1.3, 4.3], [0.09, 1.9, 5.1]),
    // Kitchen: units below the window, cupboards, tap, hob, fridge, island.
    (WHITE, [8.07, 0.1, 0.06], [13.94, 0.88, 0.62]),
    (GRANITE, [8.07, 0.88, 0.06], [13.94, 0.92, 0.66]),
    (OAK, [8.07, 1.5, 0.06], [9.4, 2.25, 0.4]),
    (OAK, [11.6, 1.5, 0.06], [13.94, 2.25, 0.4]),
    (STEEL, [10.45, 0.92, 0.08], [10.55, 1.2, 0.15]),
    (BLACK, [12.2, 0.91, 0.12], [12.9, 0.93, 0.6]),
    (STEEL, [13.2, 0.02, 1.9], [13.94, 1.95, 2.7]),
    (OAK, [10.2, 0.1, 2.05], [12.0, 0.88, 2.75]),
    (GRANITE, [10.1, 0.88, 1.95], [12.1, 0.93, 2.95]),
    // Bedroom: bed and bedding, bedside table, wardrobe, chest with a mirror, picture.
    (WALNUT, [0.1, 0.12, 7.05], [2.3, 0.34, 8.95]),
    (WALNUT, [0.07, 0.05, 7.0], [0.14, 1.05, 9.0]),
    (LINEN, [0.15, 0.34, 7.1], [2.25, 0.56, 8.9]),
    (RUST, [0.95, 0.42, 7.05], [2.3, 0.62, 8.95]),
    (LINEN, [0.2, 0.54, 7.25], [0.65, 0.68, 7.9]),
    (LINEN, [0.2, 0.54, 8.1], [0.65, 0.68, 8.75]),
    (WALNUT, [0.1, 0.05, 6.45], [0.5, 0.48, 6.9]),
    (WHITE, [4.34, 0.05, 7.6], [4.94, 2.25, 9.8]),
    (OAK, [1.0, 0.05, 6.07], [2.2, 0.83, 6.5]),
    (MIRROR, [1.1, 1.05, 6.06], [2.1, 1.95, 6.08]),
    (MUSTARD, [0.06, 1.35, 7.6], [0.09, 1.85, 8.4]),
    // Bathroom: basin with a mirror, the bottom of the bath, toilet.
    (MIRROR, [9.06, 1.1, 7.2], [9.08, 1.9, 8.0]),
    (WHITE, [9.07, 0.3, 7.1], [9.5, 0.72, 8.1]),
    (CHINA, [9.07, 0.72, 7.2], [9.55, 0.88, 8.0]),
    (CHINA, [12.3, 0.02, 6.1], [13.9, 0.12, 6.9]),
    (CHINA, [9.5, 0.0, 9.3], [9.85, 0.42, 9.75]),
    // Hall: a bench, a mirror, a picture.
    (OAK, [12.3, 0.0, 5.55], [13.5, 0.45, 5.9]),
    (MIRROR, [9.2, 0.9, 5.92], [10.0, 1.95, 5.94]),
    (MUSTARD, [12.4, 1.3, 4.56], [13.3, 1.9, 4.59]),
];

fn setting() -> Scene {
    let light = |([x, y, z], power): ([f64; 3], f32)| {
        sphere_light([x as f32, y as f32, z as f32], [power, 0.82 * power, 0.58 * power])
    };
    Scene {
        materials: materials(),
        lights: LAMPS.map(light).into_iter().chain([environment([2.4, 3.0, 4.0], [1.1, 1.1, 1.1])]).collect(),
        cameras: vec![
            camera("living", [7.4, 1.6, 0.7], [1.8, 0.8, 4.6], 0.17),
            camera("kitchen", [8.5, 1.65, 4.0], [12.6, 0.9, 0.9], 0.18),
            camera("bedroom", [4.6, 1.65, 6.5], [1.0, 0.6, 9.2], 0.18),
        ],
        ..Scene::default()
    }
}

fn draw(canvas: &mut Canvas) {
    for ([x, z], length, is_along_z, openings) in WALLS {
        wall(canvas, &place(x, 0.0, z, if is_along_z { -0.25 } else { 0.0 }), length, openings);
    }
    canvas.block(WALL, &Frame::IDENTITY, [0.0, CEILING, 0.0], [14.0, CEILING + 0.2, 10.0]);
    canvas.block(PANEL, &Frame::IDENTITY, [10.4, 2.66, 1.8], [11.8, 2.69, 2.8]);
    canvas.flat(PLANK, &Frame::IDENTITY, [0.0, 0.0, 14.0, 10.0], 0.0);
    canvas.flat(TILE, &Frame::IDENTITY, [8.0, 0.0, 14.0, 4.5], 0.005);
    canvas.flat(TILE, &Frame::IDENTITY, [9.0, 6.0, 14.0, 10.0], 0.005);
    for (x, z, turns) in [(4.6, 6.0, -0.27), (8.95, 6.0, -0.3), (12.1, 6.0, -0.22), (14.0, 5.69, -0.25)] {
        let leaf = place(x, 0.0, z, turns);
        canvas.block(WHITE, &leaf, [-0.87, 0.01, -0.02], [-0.02, 2.06, 0.02]);
        canvas.block(BRASS, &leaf, [-0.8, 1.0, -0.07], [-0.67, 1.03, 0.07]);
    }
    for (x, z, turns) in [(2.2, 0.06, 0.0), (5.6, 0.06, 0.0), (2.5, 9.94, 0.5), (7.0, 9.94, 0.5)] {
        curtains(canvas, &place(x, 0.0, z, turns));
    }
    for ([x, y, z], _) in LAMPS {
        pendant(canvas, &place(x, y, z, 0.0), CEILING - y);
    }
    furnish(canvas);
}

fn furnish(canvas: &mut Canvas) {
    for (material, low, high) in FURNITURE {
        soft_block(canvas, material, &Frame::IDENTITY, low, high);
    }
    canvas.ring(CHINA, &Frame::IDENTITY, [[12.3, 0.02, 6.1], [13.9, 0.56, 6.9]], 0.08);
    sofa(canvas, &place(2.3, 0.0, 5.35, 0.5));
    sofa(canvas, &place(0.65, 0.0, 3.2, 0.25));
    table(canvas, WALNUT, &place(2.5, 0.0, 3.6, 0.0), [0.55, 0.4, 0.35]);
    table(canvas, OAK, &place(5.9, 0.0, 4.3, 0.0), [0.9, 0.74, 0.45]);
    table(canvas, OAK, &place(5.45, 0.0, 8.85, 0.25), [0.8, 0.74, 0.38]);
    for (x, z, turns) in [(5.4, 5.08, 0.49), (6.4, 5.1, 0.51), (5.4, 3.52, 0.01), (6.4, 3.48, -0.02)] {
        chair(canvas, &place(x, 0.0, z, turns));
    }
    for (x, z, turns) in [(6.3, 8.8, -0.28), (10.8, 3.35, 0.47), (11.6, 3.4, 0.52)] {
        chair(canvas, &place(x, 0.0, z, turns));
    }
    for (x, z, turns) in [(5.1, 5.93, 0.5), (6.15, 5.93, 0.5), (8.93, 8.4, -0.25)] {
        bookcase(canvas, &place(x, 0.0, z, turns));
    }
}

/// A wall along x of `frame` with skirting, and frames in its openings.
fn wall(canvas: &mut Canvas, frame: &Frame, length: f64, openings: &[Opening]) {
    let mut solid_from = -HALF_WALL;
    let end = length + HALF_WALL;
    // An opening of no width ends the wall.
    for &(from, to, [sill, head]) in openings.iter().chain([&(end, end, DOOR)]) {
        for (left, right, low, high) in
            [(solid_from, from, 0.0, CEILING), (from, to, 0.0, sill), (from, to, head, CEILING)]
        {
            if left < right && low < high {
                canvas.block(WALL, frame, [left, low, -HALF_WALL], [right, high, HALF_WALL]);
            }
        }
        canvas.block(WHITE, frame, [solid_from, 0.0, -HALF_WALL - 0.015], [from, 0.09, HALF_WALL + 0.015]);
        solid_from = to;
    }
    for &(from, to, [sill, head]) in openings {
        // Lying flat in a frame of its own: x along the wall, y through it, z downwards.
        let foot = if sill > 0.0 { sill } else { -0.2 };
        let (low, high) = ([from - 0.05, -0.08, -head - 0.05], [to + 0.05, 0.08, 0.05 - foot]);
        canvas.ring(WHITE, &(*frame * tilt(0.25)), [low, high], 0.08);
        if sill > 0.0 {
            let middle = 0.5 * (from + to);
            canvas.block(WHITE, frame, [middle - 0.04, sill, -0.03], [middle + 0.04, head, 0.03]);
            canvas.block(WHITE, frame, [from, sill + 0.9, -0.02], [to, sill + 0.94, 0.02]);
            canvas.block(WHITE, frame, [from - 0.1, sill - 0.03, -0.18], [to + 0.1, sill, 0.18]);
        }
    }
}

/// A rod with a curtain on each side of a window; z points into the room.
fn curtains(canvas: &mut Canvas, frame: &Frame) {
    let around = canvas.steps(10.0, 5);
    canvas.tube(BRASS, frame, &[-1.4, 1.4].map(|x| dvec3(x, 2.42, 0.12)), |_| 0.014, around);
    let cells = [canvas.steps(96.0, 16), canvas.steps(36.0, 4)];
    for side in [-1.1, 1.1] {
        canvas.sheet(CURTAIN, frame, cells, |u, v| {
            let (wave, _) = sin_cos(8.0 * u + 0.1 * v);
            let loose = 1.0 - 0.4 * v;
            dvec3(side + 0.28 * (2.0 * u - 1.0) * loose, 0.03 + 2.38 * v, 0.13 + 0.05 * wave * loose)
        });
    }
}

/// A shade on a cord around the sphere light at the origin; the cord ends in the ceiling, so many
/// metres above.
fn pendant(canvas: &mut Canvas, frame: &Frame, cord: f64) {
    let facets = [canvas.steps(96.0, 10), canvas.steps(8.0, 2)];
    canvas.revolve(BRASS, frame, &[&[[0.23, 0.04], [0.21, 0.08], [0.1, 0.13], [0.03, 0.16]]], facets);
    canvas.tube(BLACK, frame, &[0.14, cord].map(|y| dvec3(0.0, y, 0.0)), |_| 0.006, 6);
}

/// A block with softly rounded edges; sharp ones where the detail allows no better.
fn soft_block(canvas: &mut Canvas, material: u32, frame: &Frame, low: [f64; 3], high: [f64; 3]) {
    let radius = if [CHINA, SOFA, MUSTARD, RUST, LINEN].contains(&material) { 0.07 } else { 0.008 };
    match canvas.steps(7.0, 0) {
        0 => canvas.block(material, frame, low, high),
        steps => canvas.rounded_block(material, frame, [low, high], radius, steps),
    }
}

/// A sofa with two seats, looking along z.
fn sofa(canvas: &mut Canvas, frame: &Frame) {
    soft_block(canvas, SOFA, frame, [-0.9, 0.08, -0.5], [0.9, 0.3, 0.42]);
    soft_block(canvas, SOFA, frame, [-0.9, 0.2, -0.54], [0.9, 0.8, -0.3]);
    for x in [-1.1, 0.88] {
        soft_block(canvas, SOFA, frame, [x, 0.08, -0.52], [x + 0.22, 0.6, 0.44]);
    }
    for (x, cushion) in [(-0.88, MUSTARD), (0.0, RUST)] {
        soft_block(canvas, SOFA, frame, [x, 0.3, -0.34], [x + 0.88, 0.46, 0.45]);
        soft_block(canvas, cushion, frame, [x + 0.2, 0.46, -0.32], [x + 0.62, 0.86, -0.16]);
    }
}

/// A top on four legs; half its width, its height and half its depth.
fn table(canvas: &mut Canvas, material: u32, frame: &Frame, [x, top, z]: [f64; 3]) {
    soft_block(canvas, material, frame, [-x, top - 0.04, -z], [x, top, z]);
    for (x, z) in [(x - 0.06, z - 0.06), (x - 0.06, 0.06 - z), (0.06 - x, z - 0.06), (0.06 - x, 0.06 - z)] {
        soft_block(canvas, material, frame, [x - 0.025, 0.0, z - 0.025], [x + 0.025, top - 0.04, z + 0.025]);
    }
}

/// A chair that looks along z.
fn chair(canvas: &mut Canvas, frame: &Frame) {
    table(canvas, WALNUT, frame, [0.21, 0.45, 0.21]);
    soft_block(canvas, WALNUT, frame, [-0.2, 0.45, -0.21], [0.2, 0.92, -0.18]);
    soft_block(canvas, LINEN, frame, [-0.19, 0.45, -0.17], [0.19, 0.49, 0.2]);
}

/// A bookcase 1 m wide with its books; x along it, z out of it, its back at the origin.
fn bookcase(canvas: &mut Canvas, frame: &Frame) {
    canvas.ring(OAK, &(*frame * tilt(0.25)), [[-0.5, 0.0, -2.16], [0.5, 0.3, 0.0]], 0.025);
    canvas.block(OAK, frame, [-0.475, 0.0, 0.0], [0.475, 2.16, 0.01]);
    let mut dice = Dice::new(231);
    for board in 0..6 {
        let y = 0.355 * f64::from(board);
        canvas.block(OAK, frame, [-0.475, y, 0.01], [0.475, y + 0.025, 0.3]);
        let mut x = -0.47;
        while x < 0.42 {
            let (thickness, height) = (dice.between(0.018, 0.05), dice.between(0.2, 0.32));
            let cover = [RUST, BLUE, WALNUT, MUSTARD, LINEN][dice.below(5)];
            let depth = dice.between(0.16, 0.24);
            canvas.block(cover, frame, [x, y + 0.025, 0.02], [x + thickness, y + height, depth]);
            x += thickness + 0.002;
        }
    }
}
