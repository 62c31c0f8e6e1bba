//! The covered walks of the atrium: floors, vaults, outer walls with doors and windows, the roof.

use glam::{DAffine3, DVec3, dvec3};

use super::super::mesh::Canvas;
use super::super::numbers::{Dice, sin_cos};
use super::super::shapes::{
    Shading, block, fan, patch, place, revolve, ring, rounded_block, sheet, tilt, tube,
};
use super::{BAY, CORNICE, DEPTH, HALF_WALL, Lantern, Paint, Side, UPPER_FLOOR};

/// Height at which vaults spring, and how far they rise.
const SPRINGING: f64 = 3.0;
const RISE: f64 = 1.4;
/// Height of the outer wall.
const WALL_TOP: f64 = 10.6;

pub(super) fn draw(canvas: &mut Canvas, paint: &Paint, side: &Side, seed: u64) {
    floors(canvas, paint, side);
    outer_wall(canvas, paint, side);
    for bay in 0..side.bays {
        let frame = side.bay(bay, 0.0);
        let centre = frame * place(0.0, 0.0, 0.5 * DEPTH, 0.0);
        vault(canvas, paint, &centre, [0.5 * BAY, 0.5 * DEPTH]);
        wall_bay(canvas, paint, &frame, bay);
        upper_bay(canvas, paint, &frame);
    }
    // The square bay at the corner where this side begins.
    let corner = side.frame * place(-0.5 * DEPTH, 0.0, 0.5 * DEPTH, 0.0);
    vault(canvas, paint, &corner, [0.5 * DEPTH, 0.5 * DEPTH]);
    for rib in 0..=side.bays {
        transverse_rib(canvas, paint, &(side.frame * place(BAY * f64::from(rib), 0.0, 0.0, 0.0)));
    }
    roof(canvas, paint, side, seed);
}

/// The ground floor's paving and the slab of the upper floor, corners included once.
fn floors(canvas: &mut Canvas, paint: &Paint, side: &Side) {
    let tiles = (side.length() / 0.75) as u32;
    let tile = side.length() / f64::from(tiles);
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
            let material = if (x + z) % 2 == 0 { paint.dark_tile } else { paint.light_tile };
            let corners = [(0.0, row), (width, row), (width, 0.0), (0.0, 0.0)];
            let corners = corners.map(|(dx, dz)| side.point(dvec3(left + dx, 0.0, near + dz)));
            patch(canvas, material, corners, [1, 1]);
        }
    }
    let (low, high) = (dvec3(-DEPTH, 4.75, -HALF_WALL), dvec3(side.length(), UPPER_FLOOR, DEPTH));
    block(canvas, paint.light_tile, &side.frame, low, high);
}

/// A groined vault over a rectangle, seen from below; the frame stands in its middle.
fn vault(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3, half: [f64; 2]) {
    let cells = [2 * canvas.steps(7.0, 2), canvas.steps(9.0, 2)];
    for web in 0..4 {
        // Each web is the part of a cylinder between the centre and one edge.
        let quarter = 0.25 * f64::from(web);
        let (sine, cosine) = sin_cos(quarter);
        fan(canvas, paint.plaster, cells, Shading::Smooth, |u, v| {
            let along = (2.0 * u - 1.0) * v;
            let y = SPRINGING + RISE * (1.0 - along * along).max(0.0).sqrt();
            let x = along * cosine + v * sine;
            let z = v * cosine - along * sine;
            frame.transform_point3(dvec3(x * half[0], y, z * half[1]))
        });
    }
}

/// The arch that carries the vaults across the aisle, over a column.
fn transverse_rib(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3) {
    let along = canvas.steps(22.0, 6);
    let around = canvas.steps(8.0, 4);
    let path: Vec<DVec3> = (0..=along)
        .map(|step| {
            let (sine, cosine) = sin_cos(0.5 * f64::from(step) / f64::from(along));
            let z = 0.5 * DEPTH * (1.0 - cosine);
            frame.transform_point3(dvec3(0.0, SPRINGING + RISE * sine, z))
        })
        .collect();
    tube(canvas, paint.limestone, &path, |_| 0.12, around);
}

/// The wall behind the aisles, both storeys, with its skirting and the mouldings on top.
fn outer_wall(canvas: &mut Canvas, paint: &Paint, side: &Side) {
    let length = side.length();
    let corners = [(length + DEPTH, 0.0), (-DEPTH, 0.0), (-DEPTH, WALL_TOP), (length + DEPTH, WALL_TOP)];
    let cells = [canvas.steps(12.0, 1), canvas.steps(5.0, 1)];
    let inside = corners.map(|(x, y)| side.point(dvec3(x, y, DEPTH)));
    patch(canvas, paint.plaster, inside, cells);
    let [a, b, c, d] = corners.map(|(x, y)| side.point(dvec3(x, y, DEPTH + 0.3)));
    patch(canvas, paint.plaster, [b, a, d, c], [1, 1]);
    for (low_y, high_y, reach) in
        [(0.0, 0.35, 0.05), (UPPER_FLOOR, UPPER_FLOOR + 0.2, 0.04), (WALL_TOP, WALL_TOP + 0.25, 0.12)]
    {
        let low = dvec3(-DEPTH, low_y, DEPTH - reach);
        let high = dvec3(length + DEPTH, high_y, DEPTH + 0.3 + reach);
        block(canvas, paint.limestone, &side.frame, low, high);
    }
}

/// Half a pillar and, in turn, a door or an alcove with a vase, in the ground floor's wall.
fn wall_bay(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3, bay: u32) {
    let on_wall = *frame * place(0.0, 0.0, DEPTH, 0.5);
    let mut slab = |half: f64, low_y: f64, high_y: f64, depth: f64| {
        let left = -0.5 * BAY;
        let (low, high) = (dvec3(left - half, low_y, 0.0), dvec3(left + half, high_y, depth));
        block(canvas, paint.limestone, &on_wall, low, high);
    };
    slab(0.24, 0.0, 0.5, 0.16);
    slab(0.2, 0.5, SPRINGING - 0.2, 0.12);
    slab(0.26, SPRINGING - 0.2, SPRINGING, 0.18);
    if bay.is_multiple_of(2) {
        door(canvas, paint, &on_wall);
    } else {
        vase_on_pedestal(canvas, paint, &(on_wall * place(0.0, 0.0, 0.45, 0.0)));
    }
}

/// A panelled double door in a stone frame; z points out of the wall.
fn door(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3) {
    let upright = *frame * tilt(0.25);
    // Lying flat in its own frame: the ring's height is the door frame's depth.
    let (low, high) = (dvec3(-0.75, 0.0, -2.45), dvec3(0.75, 0.14, 0.15));
    ring(canvas, paint.limestone, &upright, [low, high], 0.15);
    let steps = canvas.steps(2.0, 1);
    for leaf in [-1.0, 1.0] {
        let centre = 0.3 * leaf;
        let (low, high) = (dvec3(centre - 0.29, 0.0, 0.0), dvec3(centre + 0.29, 2.3, 0.05));
        block(canvas, paint.wood, frame, low, high);
        for (bottom, top) in [(0.12, 0.72), (0.82, 1.42), (1.52, 2.18)] {
            let low = dvec3(centre - 0.21, bottom, 0.02);
            let high = dvec3(centre + 0.21, top, 0.09);
            rounded_block(canvas, paint.wood, frame, [low, high], 0.03, steps);
        }
        let knob = *frame * place(0.06 * leaf, 1.1, 0.05, 0.0) * tilt(0.25);
        let turned = [[0.012, 0.0], [0.012, 0.03], [0.035, 0.05], [0.03, 0.08], [0.0, 0.09]];
        revolve(canvas, paint.bronze, &knob, &[&turned], [4 * steps + 4, steps]);
    }
}

fn vase_on_pedestal(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3) {
    block(canvas, paint.marble, frame, dvec3(-0.22, 0.0, -0.22), dvec3(0.22, 0.9, 0.22));
    block(canvas, paint.marble, frame, dvec3(-0.27, 0.9, -0.27), dvec3(0.27, 0.98, 0.27));
    let facets = [canvas.steps(28.0, 8), canvas.steps(4.0, 1)];
    let foot = [[0.12, 0.98], [0.1, 1.02], [0.05, 1.08]];
    let belly = [[0.05, 1.08], [0.19, 1.25], [0.2, 1.4], [0.09, 1.58], [0.13, 1.66]];
    revolve(canvas, paint.bronze, frame, &[&foot, &belly], facets);
}

/// The upper storey over one bay: a shuttered window and the beams and boards of the ceiling.
fn upper_bay(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3) {
    let on_wall = *frame * place(0.0, UPPER_FLOOR, DEPTH, 0.5);
    let upright = on_wall * tilt(0.25);
    let (low, high) = (dvec3(-0.62, 0.0, -2.5), dvec3(0.62, 0.12, -0.7));
    ring(canvas, paint.limestone, &upright, [low, high], 0.1);
    for shutter in [-1.0, 1.0] {
        let centre = 0.26 * shutter;
        let (low, high) = (dvec3(centre - 0.25, 0.01, -2.39), dvec3(centre + 0.25, 0.06, -0.81));
        ring(canvas, paint.wood, &upright, [low, high], 0.05);
        let slats = canvas.steps(22.0, 5);
        for slat in 0..slats {
            let y = 0.87 + 1.46 * (f64::from(slat) + 0.5) / f64::from(slats);
            let slat_frame = on_wall * place(centre, y, 0.035, 0.0) * tilt(0.09);
            let reach = 0.8 / f64::from(slats);
            let (low, high) = (dvec3(-0.21, -reach, -0.005), dvec3(0.21, reach, 0.005));
            block(canvas, paint.wood, &slat_frame, low, high);
        }
    }
    for beam in 0..3 {
        let x = BAY * (f64::from(beam) / 3.0 - 0.5);
        let (low, high) = (dvec3(x - 0.09, CORNICE - 0.05, 0.0), dvec3(x + 0.09, CORNICE + 0.17, DEPTH));
        block(canvas, paint.wood, frame, low, high);
    }
}

/// A lantern that hangs around a sphere light: cap, dish and six bars.
pub(super) fn lantern(canvas: &mut Canvas, paint: &Paint, lantern: &Lantern) {
    let frame = &lantern.frame;
    let around = canvas.steps(12.0, 6);
    let chain = [0.2, lantern.chain].map(|y| frame.transform_point3(dvec3(0.0, y, 0.0)));
    tube(canvas, paint.bronze, &chain, |_| 0.012, 5);
    let cap = [[0.19, 0.14], [0.12, 0.18], [0.03, 0.24], [0.0, 0.26]];
    let dish = [[0.0, -0.18], [0.1, -0.16], [0.14, -0.13]];
    revolve(canvas, paint.bronze, frame, &[&cap, &dish], [around, 2]);
    for bar in 0..6 {
        let (sine, cosine) = sin_cos(f64::from(bar) / 6.0);
        let path = [(0.13, -0.14), (0.17, 0.15)]
            .map(|(reach, y)| frame.transform_point3(dvec3(reach * cosine, y, reach * sine)));
        tube(canvas, paint.bronze, &path, |_| 0.008, 4);
    }
}

/// Boards and, above, rows of half-round tiles that slope from the outer wall to the court. The
/// corners are cut along the diagonal, where two sides meet.
fn roof(canvas: &mut Canvas, paint: &Paint, side: &Side, seed: u64) {
    const EAVES: f64 = -0.65;
    const EAVES_HEIGHT: f64 = CORNICE + 0.32;
    let slope = (WALL_TOP - EAVES_HEIGHT) / (DEPTH - EAVES);
    let length = side.length();
    let at = |x: f64, z: f64| side.point(dvec3(x, EAVES_HEIGHT + slope * (z - EAVES), z));
    let boards = [at(-EAVES, EAVES), at(length + EAVES, EAVES), at(length + DEPTH, DEPTH), at(-DEPTH, DEPTH)];
    patch(canvas, paint.wood, boards, [1, 1]);
    let [a, b, c, d] = boards.map(|corner| corner + DVec3::Y * 0.05);
    patch(canvas, paint.roof_tile, [b, a, d, c], [1, 1]);

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
            sheet(canvas, paint.roof_tile, [around, 1], Shading::Smooth, |u, v| {
                let (sine, cosine) = sin_cos(0.5 * u);
                // Each tile's lower end lies on the one below it.
                let radius = 0.11 - 0.02 * v;
                let point = at(x + askew - radius * cosine, near + tile_length * 1.1 * v);
                point + DVec3::Y * (radius * sine + 0.06 - 0.02 * v)
            });
        }
    }
}
