//! The covered walks of the atrium: floors, vaults, outer walls with doors and windows, the roof.

use glam::{DVec3, dvec3};

use super::super::canvas::Canvas;
use super::super::numbers::{Dice, sin_cos};
use super::super::shapes::{Frame, Shading, path, place, tilt};
use super::{BAY, CORNICE, DEPTH, HALF_WALL, Side, UPPER_FLOOR};
use super::{BRONZE, DARK_TILE, LIGHT_TILE, LIMESTONE, MARBLE, PLASTER, ROOF_TILE, WOOD};

/// Height at which vaults spring, and how far they rise.
const SPRINGING: f64 = 3.0;
const RISE: f64 = 1.4;
/// Height of the outer wall.
const WALL_TOP: f64 = 10.6;

pub(super) fn draw(canvas: &mut Canvas, side: &Side, seed: u64) {
    floors(canvas, side);
    outer_wall(canvas, side);
    for bay in 0..side.bays {
        let frame = side.bay(bay, 0.0);
        vault(canvas, &(frame * place(0.0, 0.0, 0.5 * DEPTH, 0.0)), [0.5 * BAY, 0.5 * DEPTH]);
        wall_bay(canvas, &frame, bay);
        upper_bay(canvas, &frame);
    }
    // The square bay at the corner where this side begins.
    let corner = side.frame * place(-0.5 * DEPTH, 0.0, 0.5 * DEPTH, 0.0);
    vault(canvas, &corner, [0.5 * DEPTH, 0.5 * DEPTH]);
    for rib in 0..=side.bays {
        transverse_rib(canvas, &(side.frame * place(BAY * f64::from(rib), 0.0, 0.0, 0.0)));
    }
    roof(canvas, side, seed);
}

/// The ground floor's paving and the slab of the upper floor, corners included once.
fn floors(canvas: &mut Canvas, side: &Side) {
    let length = side.length();
    let tiles = (length / 0.75) as u32;
    let tile = length / f64::from(tiles);
    let rows = (DEPTH / 0.75) as u32;
    let row = (DEPTH - HALF_WALL) / f64::from(rows);
    for z in 0..rows {
        for x in 0..tiles + 4 {
            // Four more columns of tiles pave the corner.
            let (left, width) = if x < tiles {
                (tile * f64::from(x), tile)
            } else {
                (-DEPTH + 0.25 * DEPTH * f64::from(x - tiles), 0.25 * DEPTH)
            };
            let near = HALF_WALL + row * f64::from(z);
            let material = if (x + z) % 2 == 0 { DARK_TILE } else { LIGHT_TILE };
            let corners = [(0.0, row), (width, row), (width, 0.0), (0.0, 0.0)];
            let corners = corners.map(|(dx, dz)| dvec3(left + dx, 0.0, near + dz));
            canvas.patch(material, &side.frame, corners, [1, 1]);
        }
    }
    canvas.block(LIGHT_TILE, &side.frame, [-DEPTH, 4.75, -HALF_WALL], [length, UPPER_FLOOR, DEPTH]);
}

/// A groined vault over a rectangle, seen from below; the frame stands in its middle.
fn vault(canvas: &mut Canvas, frame: &Frame, half: [f64; 2]) {
    let cells = [2 * canvas.steps(7.0, 2), canvas.steps(9.0, 2)];
    for web in 0..4 {
        // Each web is the part of a cylinder between the centre and one edge.
        let (sine, cosine) = sin_cos(0.25 * f64::from(web));
        canvas.surface(PLASTER, frame, cells, [true, false], Shading::Smooth, |u, v| {
            let along = (2.0 * u - 1.0) * v;
            let y = SPRINGING + RISE * (1.0 - along * along).max(0.0).sqrt();
            let x = along * cosine + v * sine;
            let z = v * cosine - along * sine;
            dvec3(x * half[0], y, z * half[1])
        });
    }
}

/// The arch that carries the vaults across the aisle, over a column.
fn transverse_rib(canvas: &mut Canvas, frame: &Frame) {
    let (along, around) = (canvas.steps(22.0, 6), canvas.steps(8.0, 4));
    let arch = path(along, |t| {
        let (sine, cosine) = sin_cos(0.5 * t);
        dvec3(0.0, SPRINGING + RISE * sine, 0.5 * DEPTH * (1.0 - cosine))
    });
    canvas.tube(LIMESTONE, frame, &arch, |_| 0.12, around);
}

/// The wall behind the aisles, both storeys, with its skirting and the mouldings on top.
fn outer_wall(canvas: &mut Canvas, side: &Side) {
    let end = side.length() + DEPTH;
    let corners = [(end, 0.0), (-DEPTH, 0.0), (-DEPTH, WALL_TOP), (end, WALL_TOP)];
    let cells = [canvas.steps(12.0, 1), canvas.steps(5.0, 1)];
    canvas.patch(PLASTER, &side.frame, corners.map(|(x, y)| dvec3(x, y, DEPTH)), cells);
    let [a, b, c, d] = corners.map(|(x, y)| dvec3(x, y, DEPTH + 0.3));
    canvas.patch(PLASTER, &side.frame, [b, a, d, c], [1, 1]);
    for (low, high, reach) in
        [(0.0, 0.35, 0.05), (UPPER_FLOOR, UPPER_FLOOR + 0.2, 0.04), (WALL_TOP, WALL_TOP + 0.25, 0.12)]
    {
        let (near, far) = (DEPTH - reach, DEPTH + 0.3 + reach);
        canvas.block(LIMESTONE, &side.frame, [-DEPTH, low, near], [end, high, far]);
    }
}

/// Half a pillar and, in turn, a door or an alcove with a vase, in the ground floor's wall.
fn wall_bay(canvas: &mut Canvas, frame: &Frame, bay: u32) {
    let on_wall = *frame * place(0.0, 0.0, DEPTH, 0.5);
    let left = -0.5 * BAY;
    for (half, low, high, depth) in
        [(0.24, 0.0, 0.5, 0.16), (0.2, 0.5, SPRINGING - 0.2, 0.12), (0.26, SPRINGING - 0.2, SPRINGING, 0.18)]
    {
        canvas.block(LIMESTONE, &on_wall, [left - half, low, 0.0], [left + half, high, depth]);
    }
    if bay.is_multiple_of(2) {
        door(canvas, &on_wall);
    } else {
        vase_on_pedestal(canvas, &(on_wall * place(0.0, 0.0, 0.45, 0.0)));
    }
}

/// A panelled double door in a stone frame; z points out of the wall.
fn door(canvas: &mut Canvas, frame: &Frame) {
    // Lying flat in its own frame: the ring's height is the door frame's depth.
    let upright = *frame * tilt(0.25);
    canvas.ring(LIMESTONE, &upright, [[-0.75, 0.0, -2.45], [0.75, 0.14, 0.15]], 0.15);
    let steps = canvas.steps(2.0, 1);
    for leaf in [-1.0, 1.0] {
        let centre = 0.3 * leaf;
        canvas.block(WOOD, frame, [centre - 0.29, 0.0, 0.0], [centre + 0.29, 2.3, 0.05]);
        for (bottom, top) in [(0.12, 0.72), (0.82, 1.42), (1.52, 2.18)] {
            let panel = [[centre - 0.21, bottom, 0.02], [centre + 0.21, top, 0.09]];
            canvas.rounded_block(WOOD, frame, panel, 0.03, steps);
        }
        let knob = *frame * place(0.06 * leaf, 1.1, 0.05, 0.0) * tilt(0.25);
        let turned = [[0.012, 0.0], [0.012, 0.03], [0.035, 0.05], [0.03, 0.08], [0.0, 0.09]];
        canvas.revolve(BRONZE, &knob, &[&turned], [4 * steps + 4, steps]);
    }
}

fn vase_on_pedestal(canvas: &mut Canvas, frame: &Frame) {
    canvas.block(MARBLE, frame, [-0.22, 0.0, -0.22], [0.22, 0.9, 0.22]);
    canvas.block(MARBLE, frame, [-0.27, 0.9, -0.27], [0.27, 0.98, 0.27]);
    let facets = [canvas.steps(28.0, 8), canvas.steps(4.0, 1)];
    let foot = [[0.12, 0.98], [0.1, 1.02], [0.05, 1.08]];
    let belly = [[0.05, 1.08], [0.19, 1.25], [0.2, 1.4], [0.09, 1.58], [0.13, 1.66]];
    canvas.revolve(BRONZE, frame, &[&foot, &belly], facets);
}

/// The upper storey over one bay: a shuttered window and the beams and boards of the ceiling.
fn upper_bay(canvas: &mut Canvas, frame: &Frame) {
    let on_wall = *frame * place(0.0, UPPER_FLOOR, DEPTH, 0.5);
    let upright = on_wall * tilt(0.25);
    canvas.ring(LIMESTONE, &upright, [[-0.62, 0.0, -2.5], [0.62, 0.12, -0.7]], 0.1);
    for centre in [-0.26, 0.26] {
        canvas.ring(WOOD, &upright, [[centre - 0.25, 0.01, -2.39], [centre + 0.25, 0.06, -0.81]], 0.05);
        let slats = canvas.steps(22.0, 5);
        for slat in 0..slats {
            let y = 0.87 + 1.46 * (f64::from(slat) + 0.5) / f64::from(slats);
            let slat_frame = on_wall * place(centre, y, 0.035, 0.0) * tilt(0.09);
            let reach = 0.8 / f64::from(slats);
            canvas.block(WOOD, &slat_frame, [-0.21, -reach, -0.005], [0.21, reach, 0.005]);
        }
    }
    for beam in 0..3 {
        let x = BAY * (f64::from(beam) / 3.0 - 0.5);
        canvas.block(WOOD, frame, [x - 0.09, CORNICE - 0.05, 0.0], [x + 0.09, CORNICE + 0.17, DEPTH]);
    }
}

/// A lantern that hangs around a sphere light: cap, dish and six bars.
pub(super) fn lantern(canvas: &mut Canvas, frame: &Frame, chain: f64) {
    let around = canvas.steps(12.0, 6);
    canvas.tube(BRONZE, frame, &[0.2, chain].map(|y| dvec3(0.0, y, 0.0)), |_| 0.012, 5);
    let cap = [[0.19, 0.14], [0.12, 0.18], [0.03, 0.24], [0.0, 0.26]];
    let dish = [[0.0, -0.18], [0.1, -0.16], [0.14, -0.13]];
    canvas.revolve(BRONZE, frame, &[&cap, &dish], [around, 2]);
    for bar in 0..6 {
        let (sine, cosine) = sin_cos(f64::from(bar) / 6.0);
        let ends = [(0.13, -0.14), (0.17, 0.15)].map(|(reach, y)| dvec3(reach * cosine, y, reach * sine));
        canvas.tube(BRONZE, frame, &ends, |_| 0.008, 4);
    }
}

/// Boards and, above, rows of half-round tiles that slope from the outer wall to the court. The
/// corners are cut along the diagonal, where two sides meet.
fn roof(canvas: &mut Canvas, side: &Side, seed: u64) {
    const EAVES: f64 = -0.65;
    const EAVES_HEIGHT: f64 = CORNICE + 0.32;
    let slope = (WALL_TOP - EAVES_HEIGHT) / (DEPTH - EAVES);
    let length = side.length();
    let at = |x: f64, z: f64| dvec3(x, EAVES_HEIGHT + slope * (z - EAVES), z);
    let boards = [at(-EAVES, EAVES), at(length + EAVES, EAVES), at(length + DEPTH, DEPTH), at(-DEPTH, DEPTH)];
    canvas.patch(WOOD, &side.frame, boards, [1, 1]);
    let [a, b, c, d] = boards.map(|corner| corner + DVec3::Y * 0.05);
    canvas.patch(ROOF_TILE, &side.frame, [b, a, d, c], [1, 1]);

    let rows = ((length + 2.0 * DEPTH) / 0.24) as u32;
    for row in 0..rows {
        let x = -DEPTH + (f64::from(row) + 0.5) * (length + 2.0 * DEPTH) / f64::from(rows);
        // How far beyond the row of columns this row lies; it starts there.
        let beyond = (-x).max(x - length);
        let start = EAVES.max(beyond);
        let longest = ((DEPTH - start) / 0.36).ceil().max(1.0);
        let tiles = canvas.steps(longest, 1).min(longest as u32);
        let around = canvas.steps(4.5, 2);
        let mut dice = Dice::of_cell(seed, i64::from(row), 0);
        for tile in 0..tiles {
            let tile_length = (DEPTH - start) / f64::from(tiles);
            let near = start + tile_length * f64::from(tile);
            let askew = dice.between(-0.012, 0.012);
            canvas.sheet(ROOF_TILE, &side.frame, [around, 1], |u, v| {
                let (sine, cosine) = sin_cos(0.5 * u);
                // Each tile's lower end lies on the one below it.
                let radius = 0.11 - 0.02 * v;
                let point = at(x + askew - radius * cosine, near + tile_length * 1.1 * v);
                point + DVec3::Y * (radius * sine + 0.06 - 0.02 * v)
            });
        }
    }
}
