//! The arcades of the atrium: columns, arches, cornices, balustrades.

use glam::{DVec3, dvec3};

use super::super::canvas::Canvas;
use super::super::numbers::sin_cos;
use super::super::shapes::{Frame, Shading, path, place};
use super::{BAY, CORNICE, HALF_WALL, LIMESTONE, MARBLE, Side, UPPER_FLOOR};

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

pub(super) fn draw(canvas: &mut Canvas, side: &Side) {
    for storey in [&GROUND, &UPPER] {
        corner_pier(canvas, &(side.frame * place(0.0, storey.floor, 0.0, 0.0)), storey);
        for column in 1..side.bays {
            let frame = side.frame * place(BAY * f64::from(column), storey.floor, 0.0, 0.0);
            draw_column(canvas, &frame, storey);
        }
        for bay in 0..side.bays {
            arch(canvas, &side.bay(bay, storey.floor), storey);
        }
    }
    for bay in 0..side.bays {
        balustrade(canvas, &side.bay(bay, UPPER_FLOOR));
    }
    string_course(canvas, side, UPPER_FLOOR - 0.25);
    string_course(canvas, side, CORNICE);
}

/// A square course of stone about the y axis.
fn course(canvas: &mut Canvas, frame: &Frame, half: f64, bottom: f64, top: f64) {
    canvas.block(LIMESTONE, frame, [-half, bottom, -half], [half, top, half]);
}

/// The square pier at the corner where a side begins.
fn corner_pier(canvas: &mut Canvas, frame: &Frame, storey: &Storey) {
    let Storey { springing, top, .. } = *storey;
    course(canvas, frame, 0.4, 0.0, 0.2);
    course(canvas, frame, 0.36, 0.2, 0.42);
    course(canvas, frame, 0.3, 0.42, springing - 0.3);
    course(canvas, frame, 0.34, springing - 0.3, springing - 0.16);
    course(canvas, frame, 0.38, springing - 0.16, springing);
    course(canvas, frame, HALF_WALL + 0.03, springing, top);
}

/// A column on its plinth, up to the springing of the arches.
fn draw_column(canvas: &mut Canvas, frame: &Frame, storey: &Storey) {
    let Storey { girth, springing: height, .. } = *storey;
    course(canvas, frame, 0.34 * girth, 0.0, 0.15);
    course(canvas, frame, 0.37 * girth, height - 0.13, height - 0.05);
    course(canvas, frame, 0.4 * girth, height - 0.05, height);
    let facets = [canvas.steps(26.0, 8), canvas.steps(2.0, 1)];
    let scaled = |[radius, height]: [f64; 2]| [radius * girth, height];
    let base = [[0.3, 0.15], [0.335, 0.2], [0.3, 0.26]].map(scaled);
    let hollow = [[0.28, 0.26], [0.25, 0.31], [0.27, 0.36]].map(scaled);
    let upper_base = [[0.27, 0.36], [0.295, 0.4], [0.25, 0.45]].map(scaled);
    canvas.revolve(MARBLE, frame, &[&base, &hollow, &upper_base], facets);
    let neck = height - 0.6;
    shaft(canvas, frame, storey, neck);
    let collar = [[0.215, neck], [0.25, neck + 0.03], [0.215, neck + 0.06]].map(scaled);
    let bell = [[0.205, neck + 0.06], [0.21, neck + 0.2], [0.25, neck + 0.36], [0.36, neck + 0.47]];
    canvas.revolve(MARBLE, frame, &[&collar, &bell.map(scaled)], facets);
    capital_leaves(canvas, &(*frame * place(0.0, neck + 0.08, 0.0, 0.0)), girth);
}

/// The shaft of a column, a little thinner at its top; fluted where the detail allows.
fn shaft(canvas: &mut Canvas, frame: &Frame, storey: &Storey, top: f64) {
    let facets = canvas.steps(4.0, 1);
    let fluted = facets > 1 && storey.flutes > 0;
    let plain = canvas.steps(24.0, 8);
    let around = if fluted { storey.flutes * facets } else { plain };
    let rows = canvas.steps(6.0, 1);
    let depth = if fluted { 0.06 } else { 0.0 };
    canvas.sheet(MARBLE, frame, [around, rows], |u, v| {
        let (sine, cosine) = sin_cos(u);
        let (_, wave) = sin_cos(u * f64::from(storey.flutes));
        // Flutes run out towards both ends.
        let run_out = (12.0 * v * (1.0 - v)).min(1.0);
        let taper = 1.0 - 0.14 * v * v;
        let radius = 0.25 * storey.girth * taper * (1.0 - depth * run_out * (0.5 - 0.5 * wave));
        dvec3(radius * cosine, 0.45 + (top - 0.45) * v, -radius * sine)
    });
}

/// Two rows of curled leaves around the bell of a capital.
fn capital_leaves(canvas: &mut Canvas, frame: &Frame, girth: f64) {
    let cells = [2 * canvas.steps(1.5, 1), canvas.steps(5.0, 2)];
    for (height, root, shift) in [(0.2, 0.0, 0.0), (0.3, 0.06, 0.5)] {
        for leaf in 0..8 {
            let frame = *frame * place(0.0, root, 0.0, (f64::from(leaf) + shift) / 8.0);
            canvas.sheet(MARBLE, &frame, cells, |u, v| {
                let across = 2.0 * u - 1.0;
                // Wide in the middle, pointed at the top, where it curls outwards and down.
                let width = 0.085 * girth * (1.0 - v * v * v) + 0.004;
                let curl = (v - 0.65).max(0.0);
                let out = girth * (0.225 + 0.04 * v + 0.45 * curl - 0.012 * across * across);
                dvec3(across * width, height * (v - 1.6 * curl * curl), out)
            });
        }
    }
}

/// The wall above one bay, with its arched opening; the frame stands on the storey's floor.
fn arch(canvas: &mut Canvas, frame: &Frame, storey: &Storey) {
    // A multiple of four, so that the corners of the wall are met.
    let cells = [4 * canvas.steps(6.0, 2), canvas.steps(2.0, 1)];
    let on_arch = |u: f64, reach: f64| {
        let (sine, cosine) = sin_cos(0.5 * u);
        dvec3(-reach * cosine, storey.springing + reach * sine, 0.0)
    };
    let on_edge = |u: f64| {
        let rise = storey.top - storey.springing;
        let x = (4.0 * u - 2.0).clamp(-1.0, 1.0) * (0.5 * BAY);
        let y = (4.0 * u).min(4.0 - 4.0 * u).min(1.0) * rise;
        dvec3(x, storey.springing + y, 0.0)
    };
    for (face, outward) in [(-HALF_WALL, false), (HALF_WALL, true)] {
        canvas.surface(LIMESTONE, frame, cells, [false; 2], Shading::Flat, |u, v| {
            let u = if outward { u } else { 1.0 - u };
            let (inner, outer) = (on_arch(u, storey.reach), on_edge(u));
            inner + (outer - inner) * v + DVec3::Z * face
        });
        // A round bar along the arch.
        let (along, around) = (canvas.steps(26.0, 6), canvas.steps(7.0, 4));
        let bar = path(along, |t| on_arch(t, storey.reach + 0.09) + DVec3::Z * face);
        canvas.tube(LIMESTONE, frame, &bar, |_| 0.05, around);
    }
    canvas.sheet(LIMESTONE, frame, cells, |u, v| {
        on_arch(u, storey.reach) + DVec3::Z * (HALF_WALL * (2.0 * v - 1.0))
    });
    // The keystone.
    let (crown, depth) = (storey.springing + storey.reach, HALF_WALL + 0.09);
    canvas.block(LIMESTONE, frame, [-0.11, crown - 0.04, -depth], [0.11, crown + 0.26, depth]);
}

/// Rail, foot and turned balusters between two columns of the upper storey.
fn balustrade(canvas: &mut Canvas, frame: &Frame) {
    const BALUSTERS: u32 = 8;
    let half = 0.5 * BAY - 0.2;
    for (reach, bottom, top) in [(0.13, 0.0, 0.12), (0.14, 0.85, 0.92), (0.11, 0.92, 0.97)] {
        canvas.block(LIMESTONE, frame, [-half, bottom, -reach], [half, top, reach]);
    }
    for baluster in 0..BALUSTERS {
        let x = (f64::from(baluster) + 0.5) / f64::from(BALUSTERS) - 0.5;
        let frame = *frame * place(x * (BAY - 0.4), 0.12, 0.0, 0.0);
        let facets = [canvas.steps(11.0, 5), canvas.steps(2.0, 1)];
        let foot = [[0.07, 0.0], [0.07, 0.06]];
        let belly = [[0.045, 0.06], [0.05, 0.12], [0.085, 0.24], [0.05, 0.44], [0.035, 0.58]];
        let head = [[0.035, 0.58], [0.06, 0.62], [0.045, 0.66], [0.07, 0.73]];
        canvas.revolve(MARBLE, &frame, &[&foot, &belly, &head], facets);
    }
}

/// A band of mouldings with a row of small brackets along the court, its foot at `height`.
fn string_course(canvas: &mut Canvas, side: &Side, height: f64) {
    let length = side.length();
    for (reach, bottom, top) in [(0.33, 0.0, 0.08), (0.36, 0.08, 0.12), (0.46, 0.22, 0.3)] {
        // The court is on the side of negative z; neighbouring sides meet in a mitre's stead.
        let low = [reach, height + bottom, -reach];
        canvas.block(LIMESTONE, &side.frame, low, [length - reach, height + top, HALF_WALL]);
    }
    let brackets = (length / 0.3) as u32;
    for bracket in 1..brackets {
        let x = length * f64::from(bracket) / f64::from(brackets);
        let low = [x - 0.06, height + 0.12, -0.42];
        canvas.block(LIMESTONE, &side.frame, low, [x + 0.06, height + 0.22, -HALF_WALL]);
    }
}
