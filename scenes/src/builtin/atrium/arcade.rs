//! The arcades of the atrium: columns, arches, cornices, balustrades.

use glam::{DAffine3, DVec3, dvec3};

use super::super::mesh::Canvas;
use super::super::numbers::sin_cos;
use super::super::shapes::{Shading, block, place, revolve, sheet, tube};
use super::{BAY, CORNICE, HALF_WALL, Paint, Side, UPPER_FLOOR};

/// What differs between the two storeys.
struct Storey {
    /// Height of the floor.
    floor: f64,
    /// Height of the springing of the arches above the floor.
    springing: f64,
    /// Half the clear width of an arch.
    reach: f64,
    /// Height of the wall above the floor.
    top: f64,
    /// Thickness of the columns relative to those of the ground floor.
    girth: f64,
    /// Flutes around a shaft; 0 for a plain one.
    flutes: u32,
}

const GROUND: Storey = Storey { floor: 0.0, springing: 3.0, reach: 1.2, top: 4.75, girth: 1.0, flutes: 16 };
const UPPER: Storey = Storey {
    floor: UPPER_FLOOR,
    springing: 2.4,
    reach: 1.28,
    top: CORNICE - UPPER_FLOOR,
    girth: 0.75,
    flutes: 0,
};

pub(super) fn draw(canvas: &mut Canvas, paint: &Paint, side: &Side) {
    for storey in [&GROUND, &UPPER] {
        corner_pier(canvas, paint, side, storey);
        for column in 1..side.bays {
            let frame = side.frame * place(BAY * f64::from(column), storey.floor, 0.0, 0.0);
            draw_column(canvas, paint, &frame, storey);
        }
        for bay in 0..side.bays {
            arch(canvas, paint, &side.bay(bay, storey.floor), storey);
        }
    }
    for bay in 0..side.bays {
        balustrade(canvas, paint, &side.bay(bay, UPPER_FLOOR));
    }
    string_course(canvas, paint, side, UPPER_FLOOR - 0.25);
    string_course(canvas, paint, side, CORNICE);
}

/// The square pier at the corner where this side begins.
fn corner_pier(canvas: &mut Canvas, paint: &Paint, side: &Side, storey: &Storey) {
    let frame = side.frame * place(0.0, storey.floor, 0.0, 0.0);
    let mut course = |half: f64, bottom: f64, top: f64| {
        let (low, high) = (dvec3(-half, bottom, -half), dvec3(half, top, half));
        block(canvas, paint.limestone, &frame, low, high);
    };
    course(0.4, 0.0, 0.2);
    course(0.36, 0.2, 0.42);
    course(0.3, 0.42, storey.springing - 0.3);
    course(0.34, storey.springing - 0.3, storey.springing - 0.16);
    course(0.38, storey.springing - 0.16, storey.springing);
    course(HALF_WALL + 0.03, storey.springing, storey.top);
}

/// A column on its plinth, up to the springing of the arches.
fn draw_column(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3, storey: &Storey) {
    let girth = storey.girth;
    let height = storey.springing;
    let plinth = |canvas: &mut Canvas, half: f64, bottom: f64, top: f64| {
        let (low, high) = (dvec3(-half, bottom, -half), dvec3(half, top, half));
        block(canvas, paint.limestone, frame, low, high);
    };
    plinth(canvas, 0.34 * girth, 0.0, 0.15);
    plinth(canvas, 0.37 * girth, height - 0.13, height - 0.05);
    plinth(canvas, 0.4 * girth, height - 0.05, height);
    let facets = [canvas.steps(26.0, 8), canvas.steps(2.0, 1)];
    let scaled = |points: &[[f64; 2]]| -> Vec<[f64; 2]> {
        points.iter().map(|[radius, height]| [radius * girth, *height]).collect()
    };
    let base = scaled(&[[0.3, 0.15], [0.335, 0.2], [0.3, 0.26]]);
    let hollow = scaled(&[[0.28, 0.26], [0.25, 0.31], [0.27, 0.36]]);
    let upper_base = scaled(&[[0.27, 0.36], [0.295, 0.4], [0.25, 0.45]]);
    revolve(canvas, paint.marble, frame, &[&base, &hollow, &upper_base], facets);
    let neck = height - 0.6;
    shaft(canvas, paint.marble, frame, storey, neck);
    let collar = scaled(&[[0.215, neck], [0.25, neck + 0.03], [0.215, neck + 0.06]]);
    let bell = scaled(&[[0.205, neck + 0.06], [0.21, neck + 0.2], [0.25, neck + 0.36], [0.36, neck + 0.47]]);
    revolve(canvas, paint.marble, frame, &[&collar, &bell], facets);
    capital_leaves(canvas, paint, &(*frame * place(0.0, neck + 0.08, 0.0, 0.0)), girth);
}

/// The shaft of a column, a little thinner at its top; fluted where the detail allows.
fn shaft(canvas: &mut Canvas, material: u32, frame: &DAffine3, storey: &Storey, top: f64) {
    let facets = canvas.steps(4.0, 1);
    let fluted = facets > 1 && storey.flutes > 0;
    let plain = canvas.steps(24.0, 8);
    let around = if fluted { storey.flutes * facets } else { plain };
    let rows = canvas.steps(6.0, 1);
    let depth = if fluted { 0.06 } else { 0.0 };
    sheet(canvas, material, [around, rows], Shading::Smooth, |u, v| {
        let (sine, cosine) = sin_cos(u);
        let (_, wave) = sin_cos(u * f64::from(storey.flutes));
        // Flutes run out towards both ends.
        let run_out = (12.0 * v * (1.0 - v)).min(1.0);
        let taper = 1.0 - 0.14 * v * v;
        let radius = 0.25 * storey.girth * taper * (1.0 - depth * run_out * (0.5 - 0.5 * wave));
        let y = 0.45 + (top - 0.45) * v;
        frame.transform_point3(dvec3(radius * cosine, y, -radius * sine))
    });
}

/// Two rows of curled leaves around the bell of a capital.
fn capital_leaves(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3, girth: f64) {
    let cells = [2 * canvas.steps(1.5, 1), canvas.steps(5.0, 2)];
    for row in 0..2 {
        let (height, root) = [(0.2, 0.0), (0.3, 0.06)][row];
        for leaf in 0..8 {
            let turns = (f64::from(leaf) + 0.5 * row as f64) / 8.0;
            let frame = *frame * place(0.0, root, 0.0, turns);
            sheet(canvas, paint.marble, cells, Shading::Smooth, |u, v| {
                let across = 2.0 * u - 1.0;
                // Wide in the middle, pointed at the top, where it curls outwards and down.
                let width = 0.085 * girth * (1.0 - v * v * v) + 0.004;
                let curl = (v - 0.65).max(0.0);
                let out = girth * (0.225 + 0.04 * v + 0.45 * curl - 0.012 * across * across);
                let y = height * (v - 1.6 * curl * curl);
                frame.transform_point3(dvec3(across * width, y, out))
            });
        }
    }
}

/// The wall above one bay, with its arched opening; the frame stands on the storey's floor.
fn arch(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3, storey: &Storey) {
    // A multiple of four, so that the corners of the wall are met.
    let around = 4 * canvas.steps(6.0, 2);
    let rows = canvas.steps(2.0, 1);
    let on_arch = |u: f64, reach: f64| {
        let (sine, cosine) = sin_cos(0.5 * u);
        dvec3(-reach * cosine, storey.springing + reach * sine, 0.0)
    };
    let on_edge = |u: f64| {
        let rise = storey.top - storey.springing;
        let half = 0.5 * BAY;
        let x = (4.0 * u - 2.0).clamp(-1.0, 1.0) * half;
        let y = (4.0 * u).min(4.0 - 4.0 * u).min(1.0) * rise;
        dvec3(x, storey.springing + y, 0.0)
    };
    for (face, outward) in [(-HALF_WALL, false), (HALF_WALL, true)] {
        sheet(canvas, paint.limestone, [around, rows], Shading::Flat, |u, v| {
            let u = if outward { u } else { 1.0 - u };
            let (inner, outer) = (on_arch(u, storey.reach), on_edge(u));
            frame.transform_point3(inner + (outer - inner) * v + DVec3::Z * face)
        });
        moulding(canvas, paint, frame, face, |u| on_arch(u, storey.reach + 0.09));
    }
    sheet(canvas, paint.limestone, [around, rows], Shading::Smooth, |u, v| {
        let depth = HALF_WALL * (2.0 * v - 1.0);
        frame.transform_point3(on_arch(u, storey.reach) + DVec3::Z * depth)
    });
    keystone(canvas, paint, frame, storey);
}

/// A round bar along an arch, on one face of its wall.
fn moulding(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3, face: f64, on_arch: impl Fn(f64) -> DVec3) {
    let along = canvas.steps(26.0, 6);
    let around = canvas.steps(7.0, 4);
    let path: Vec<DVec3> = (0..=along)
        .map(|step| {
            let point = on_arch(f64::from(step) / f64::from(along));
            frame.transform_point3(point + DVec3::Z * face)
        })
        .collect();
    tube(canvas, paint.limestone, &path, |_| 0.05, around);
}

fn keystone(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3, storey: &Storey) {
    let crown = storey.springing + storey.reach;
    let depth = HALF_WALL + 0.09;
    let (low, high) = (dvec3(-0.11, crown - 0.04, -depth), dvec3(0.11, crown + 0.26, depth));
    block(canvas, paint.limestone, frame, low, high);
}

/// Rail, foot and turned balusters between two columns of the upper storey.
fn balustrade(canvas: &mut Canvas, paint: &Paint, frame: &DAffine3) {
    let mut bar = |half_width: f64, bottom: f64, top: f64| {
        let half = 0.5 * BAY - 0.2;
        let (low, high) = (dvec3(-half, bottom, -half_width), dvec3(half, top, half_width));
        block(canvas, paint.limestone, frame, low, high);
    };
    bar(0.13, 0.0, 0.12);
    bar(0.14, 0.85, 0.92);
    bar(0.11, 0.92, 0.97);
    const BALUSTERS: u32 = 8;
    for baluster in 0..BALUSTERS {
        let x = (f64::from(baluster) + 0.5) / f64::from(BALUSTERS) - 0.5;
        let frame = *frame * place(x * (BAY - 0.4), 0.12, 0.0, 0.0);
        let facets = [canvas.steps(11.0, 5), canvas.steps(2.0, 1)];
        let foot: [[f64; 2]; 2] = [[0.07, 0.0], [0.07, 0.06]];
        let belly = [[0.045, 0.06], [0.05, 0.12], [0.085, 0.24], [0.05, 0.44], [0.035, 0.58]];
        let head = [[0.035, 0.58], [0.06, 0.62], [0.045, 0.66], [0.07, 0.73]];
        revolve(canvas, paint.marble, &frame, &[&foot, &belly, &head], facets);
    }
}

/// A band of mouldings with a row of small brackets along the court, its foot at `height`.
fn string_course(canvas: &mut Canvas, paint: &Paint, side: &Side, height: f64) {
    let length = side.length();
    for (reach, bottom, top) in [(0.33, 0.0, 0.08), (0.36, 0.08, 0.12), (0.46, 0.22, 0.3)] {
        // The court is on the side of negative z; neighbouring sides meet in a mitre's stead.
        let low = dvec3(reach, height + bottom, -reach);
        let high = dvec3(length - reach, height + top, HALF_WALL);
        block(canvas, paint.limestone, &side.frame, low, high);
    }
    let brackets = (length / 0.3) as u32;
    for bracket in 1..brackets {
        let x = length * f64::from(bracket) / f64::from(brackets);
        let low = dvec3(x - 0.06, height + 0.12, -0.42);
        let high = dvec3(x + 0.06, height + 0.22, -HALF_WALL);
        block(canvas, paint.limestone, &side.frame, low, high);
    }
}
