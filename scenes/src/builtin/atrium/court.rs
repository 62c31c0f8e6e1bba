//! The court of the atrium: paving, fountain, curtains between the columns, potted plants.

use glam::dvec3;

use super::super::canvas::Canvas;
use super::super::numbers::{Dice, fractal_noise, sin_cos};
use super::super::shapes::{Frame, path, place, stretch};
use super::{BAY, COURT, HALF_WALL, Side, UPPER_FLOOR};
use super::{BLUE_CLOTH, CLAY, GREEN_CLOTH, LEAVES, LIGHT_TILE, LIMESTONE, MARBLE, RED_CLOTH, WATER, WOOD};

pub(super) fn draw(canvas: &mut Canvas) {
    paving(canvas);
    fountain(canvas);
    for (index, side) in Side::all().iter().enumerate() {
        for bay in 0..side.bays {
            let seed = index as u64 * 16 + u64::from(bay);
            let cloth = [RED_CLOTH, GREEN_CLOTH, BLUE_CLOTH][(bay as usize + index) % 3];
            match bay % 3 {
                1 => banner(canvas, cloth, &side.bay(bay, UPPER_FLOOR), seed),
                // The middle of the short sides stays open.
                _ if side.bays > 3 => curtain(canvas, cloth, &side.bay(bay, 0.0), seed),
                _ => {}
            }
        }
        for column in (1..side.bays).step_by(2) {
            let frame = side.frame * place(BAY * f64::from(column), 0.0, -0.85, 0.0);
            potted_plant(canvas, &frame, index as u64 * 16 + u64::from(column));
        }
    }
}

/// Square slabs in two colours, and the thresholds under the arcades.
fn paving(canvas: &mut Canvas) {
    let (half_x, half_z) = (COURT[0] + HALF_WALL, COURT[1] + HALF_WALL);
    let (columns, rows) = ((2.0 * half_x / 0.8) as u32, (2.0 * half_z / 0.8) as u32);
    let at = |column: u32, row: u32| {
        let x = 2.0 * half_x * f64::from(column) / f64::from(columns) - half_x;
        dvec3(x, 0.0, 2.0 * half_z * f64::from(row) / f64::from(rows) - half_z)
    };
    for column in 0..columns {
        for row in 0..rows {
            let rim = column == 0 || row == 0 || column + 1 == columns || row + 1 == rows;
            let light = rim || (column + row) % 2 == 0;
            let material = if light { LIMESTONE } else { LIGHT_TILE };
            let corners =
                [at(column, row + 1), at(column + 1, row + 1), at(column + 1, row), at(column, row)];
            canvas.patch(material, &Frame::IDENTITY, corners, [1, 1]);
        }
    }
}

/// A round basin with two bowls on a stem.
fn fountain(canvas: &mut Canvas) {
    let facets = [canvas.steps(64.0, 16), canvas.steps(4.0, 1)];
    let frame = place(2.0, 0.0, 0.0, 0.0);
    let step = [[1.75, 0.0], [1.75, 0.12], [1.45, 0.12]];
    let wall = [[1.3, 0.12], [1.38, 0.3], [1.3, 0.5]];
    let rim = [[1.3, 0.5], [1.42, 0.53], [1.42, 0.58], [1.2, 0.6], [1.16, 0.5]];
    let inside = [[1.16, 0.5], [1.1, 0.2]];
    canvas.revolve(MARBLE, &frame, &[&step[..2], &step[1..], &wall, &rim, &inside], facets);
    canvas.revolve(WATER, &frame, &[&[[1.15, 0.46], [0.0, 0.46]]], [facets[0], 1]);
    let stem = [[0.3, 0.2], [0.22, 0.5], [0.1, 0.8], [0.16, 1.1], [0.1, 1.25]];
    let bowl = [[0.1, 1.25], [0.5, 1.38], [0.72, 1.55], [0.74, 1.6]];
    let bowl_inside = [[0.74, 1.6], [0.66, 1.57], [0.3, 1.45]];
    let upper_stem = [[0.12, 1.4], [0.07, 1.65], [0.1, 1.9], [0.06, 2.0]];
    let upper_bowl = [[0.06, 2.0], [0.26, 2.08], [0.38, 2.2], [0.36, 2.22], [0.1, 2.12]];
    let finial = [[0.05, 2.1], [0.1, 2.22], [0.05, 2.34], [0.07, 2.42], [0.0, 2.56]];
    let pieces: [&[[f64; 2]]; 6] = [&stem, &bowl, &bowl_inside, &upper_stem, &upper_bowl, &finial];
    canvas.revolve(MARBLE, &frame, &pieces, facets);
    canvas.revolve(WATER, &frame, &[&[[0.68, 1.575], [0.08, 1.575]]], [facets[0], 1]);
}

/// A curtain in an arch of the ground floor, drawn to one side and tied.
fn curtain(canvas: &mut Canvas, cloth: u32, frame: &Frame, seed: u64) {
    let cells = [canvas.steps(72.0, 12), canvas.steps(26.0, 5)];
    let mut dice = Dice::of_cell(31, seed as i64, 0);
    let hand = if dice.chance(0.5) { 1.0 } else { -1.0 };
    let phase = dice.unit();
    let folds = dice.between(7.0, 9.0).round();
    canvas.sheet(cloth, frame, cells, |u, v| {
        // Widest at the rod, narrowest at the tie, a little wider again at the floor.
        let tie = (v - 0.38).abs();
        let spread = if v > 0.38 { 0.13 + 2.3 * tie * tie } else { 0.13 + 0.5 * tie * tie };
        let (wave, _) = sin_cos(folds * u + phase + 0.12 * v);
        let depth = (0.018 + 0.06 * spread) * wave;
        let sway = 0.02 * fractal_noise(seed, 4.0 * u, 3.0 * v, 2);
        let x = hand * (1.16 - 2.32 * spread.min(1.0) * if hand > 0.0 { 1.0 - u } else { u });
        dvec3(x, 0.04 + 2.9 * v, depth + sway)
    });
    canvas.tube(cloth, frame, &[-1.2, 1.2].map(|x| dvec3(x, 2.95, 0.0)), |_| 0.02, 6);
}

/// A long cloth that hangs over the balustrade into the court.
fn banner(canvas: &mut Canvas, cloth: u32, frame: &Frame, seed: u64) {
    let cells = [canvas.steps(40.0, 8), canvas.steps(30.0, 6)];
    canvas.sheet(cloth, frame, cells, |u, v| {
        let across = 1.0 - 2.0 * u;
        // From the lower end of the cloth up to the rail and a little over it.
        let (y, z) = if v < 0.9 { (-1.9 + 2.89 * v / 0.9, -0.52) } else { (0.99, -0.52 + 6.5 * (v - 0.9)) };
        let hang = 1.0 - v;
        let (wave, _) = sin_cos(3.0 * u + 0.1 * f64::from(seed as u32));
        let billow = 0.05 * hang * wave + 0.05 * hang * fractal_noise(seed, 3.0 * u, 3.0 * v, 3);
        // The lower end is cut to a point.
        let point = if v == 0.0 { -0.35 * (1.0 - across.abs()) } else { 0.0 };
        dvec3(0.75 * across, y + point, z + billow)
    });
}

/// A clay pot with a bush: stems, and leaves cut out of a texture.
fn potted_plant(canvas: &mut Canvas, frame: &Frame, seed: u64) {
    let facets = [canvas.steps(28.0, 8), canvas.steps(3.0, 1)];
    let foot = [[0.0, 0.02], [0.2, 0.0], [0.21, 0.04]];
    let belly = [[0.21, 0.04], [0.3, 0.25], [0.31, 0.42], [0.26, 0.52]];
    let rim = [[0.26, 0.52], [0.32, 0.54], [0.31, 0.59], [0.25, 0.58]];
    canvas.revolve(CLAY, frame, &[&foot, &belly, &rim], facets);
    canvas.revolve(WOOD, frame, &[&[[0.25, 0.54], [0.0, 0.56]]], [facets[0], 1]);
    let mut dice = Dice::of_cell(41, seed as i64, 0);
    for _ in 0..7 {
        let (sine, cosine) = sin_cos(dice.unit());
        let reach = dice.between(0.15, 0.4);
        let top = dice.between(1.0, 1.5);
        let stem = path(5, |t| {
            let out = 0.05 + reach * t * t;
            dvec3(out * cosine, 0.5 + (top - 0.5) * t, out * sine)
        });
        canvas.tube(WOOD, frame, &stem, |t| 0.014 - 0.009 * t, 5);
    }
    let count = canvas.steps(320.0, 40);
    let size = 0.24 * (320.0 / f64::from(count)).sqrt();
    let crown = *frame * place(0.0, 1.2, 0.0, 0.0) * stretch(0.52, 0.55, 0.52);
    canvas.leaves(LEAVES, &crown, count, size, dice.bits());
}
