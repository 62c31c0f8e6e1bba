//! `city`: a grid of streets with towers in its middle, and blocks of flats around them.
//!
//! Each [`Plot`] is a square with a block of buildings and half of the streets around it. More
//! triangles make a larger city; few make each plot coarser too.

use glam::{DVec2, dvec2, dvec3};

use super::canvas::Canvas;
use super::foliage::sprig_texture;
use super::numbers::{Dice, value_noise};
use super::setting::{Recipe, camera, cut_out, environment, glossy, matt, metal, palette};
use super::shapes::{Frame, path, place, stretch, tilt};
use crate::Scene;

pub(super) const RECIPE: Recipe = Recipe {
    name: "city",
    description: "Streets with towers and flats, parked cars, lamps and trees with cut-out leaves, under an open sky.",
    triangles: [14_000, 1_000_000, 50_000_000],
    setting,
    draw,
};

/// From the middle of one street to the next, metres.
const PITCH: f64 = 72.0;
/// Half the edge of the raised block between the streets, pavement included.
const HALF_BLOCK: f64 = 28.0;
/// Half the edge of what can be built on.
const HALF_LOT: f64 = 24.5;
/// Height of the kerb.
const KERB: f64 = 0.15;

palette! {
    ASPHALT = matt("asphalt", [0.09, 0.09, 0.095]);
    PAVING = matt("paving", [0.42, 0.4, 0.37]);
    LAWN = matt("lawn", [0.15, 0.25, 0.07]);
    ROAD_MARKING = matt("road marking", [0.75, 0.75, 0.7]);
    GLASS = glossy("window glass", [0.04, 0.06, 0.08], 0.05);
    CONCRETE = matt("concrete", [0.52, 0.5, 0.46]);
    BRICK = matt("brick", [0.42, 0.17, 0.11]);
    SANDSTONE = matt("sandstone", [0.6, 0.48, 0.33]);
    STEEL = metal("steel", [0.55, 0.56, 0.58], 0.35);
    WHITE = glossy("white paint", [0.78, 0.77, 0.74], 0.5);
    RED_CAR = glossy("red car", [0.5, 0.03, 0.03], 0.15);
    BLUE_CAR = glossy("blue car", [0.04, 0.1, 0.35], 0.15);
    SILVER_CAR = metal("silver car", [0.7, 0.71, 0.73], 0.25);
    YELLOW_CAR = glossy("yellow car", [0.75, 0.5, 0.03], 0.15);
    TYRE = matt("tyre", [0.03, 0.03, 0.03]);
    BARK = matt("bark", [0.2, 0.14, 0.09]);
    LEAVES = cut_out("leaves", 0);
}

fn setting() -> Scene {
    Scene {
        materials: materials(),
        textures: vec![sprig_texture()],
        lights: vec![environment([0.8, 1.15, 1.8], [0.55, 0.5, 0.45])],
        cameras: vec![
            camera("skyline", [-235.0, 150.0, 290.0], [20.0, 22.0, -20.0], 0.11),
            camera("avenue", [38.6, 2.4, 104.0], [36.0, 13.0, 0.0], 0.16),
            camera("crossing", [30.5, 7.0, 43.5], [60.0, 9.0, -20.0], 0.18),
        ],
        ..Scene::default()
    }
}

/// A square of the grid.
struct Plot {
    frame: Frame,
    dice: Dice,
    /// How much to put on it, in (0, 1].
    richness: f64,
    /// How far from the middle of the city, in plots.
    distance: f64,
}

impl Plot {
    /// Whether something that a rich plot has is there on this one.
    fn keeps(&self, canvas: &mut Canvas) -> bool {
        canvas.round(2.0 * self.richness) > 0
    }

    /// A number of things after scaling it by the richness, at least `least`.
    fn steps(&self, canvas: &mut Canvas, at_full_richness: f64, least: u32) -> u32 {
        canvas.round(at_full_richness * self.richness).max(least)
    }
}

fn draw(canvas: &mut Canvas) {
    // A smaller city has fewer plots and less on each of them.
    let richness = canvas.detail.sqrt().clamp(0.02, 1.0);
    let plots = (180.0 * canvas.detail / richness).max(9.0) as u32;
    let reach = PITCH * (f64::from(plots).sqrt() + 16.0);
    canvas.flat(LAWN, &Frame::IDENTITY, [-reach, -reach, reach, reach], -0.3);
    let rings = (f64::from(plots).sqrt() / 2.0).ceil() as i64;
    let mut cells: Vec<[i64; 2]> =
        (-rings..=rings).flat_map(|row| (-rings..=rings).map(move |column| [column, row])).collect();
    cells.sort_by_key(|[column, row]| column.abs().max(row.abs()));
    for [column, row] in cells.into_iter().take(plots as usize) {
        let (x, z) = (column as f64, row as f64);
        let mut plot = Plot {
            frame: place(PITCH * x, 0.0, PITCH * z, 0.0),
            dice: Dice::of_cell(501, column, row),
            richness,
            distance: (x * x + z * z).sqrt(),
        };
        street(canvas, &mut plot);
        let zone = plot.distance + 0.8 * value_noise(507, 0.7 * x, 0.7 * z);
        if zone < 1.9 {
            towers(canvas, &mut plot);
        } else {
            flats(canvas, &mut plot);
        }
    }
}

/// The ground of a plot; the markings of its streets; lamps, trees and cars along them.
fn street(canvas: &mut Canvas, plot: &mut Plot) {
    let half = 0.5 * PITCH;
    canvas.flat(ASPHALT, &plot.frame, [-half, -half, half, half], 0.0);
    canvas.block(PAVING, &plot.frame, [-HALF_BLOCK, 0.0, -HALF_BLOCK], [HALF_BLOCK, KERB, HALF_BLOCK]);
    for side in 0..4_usize {
        // x along the street, z towards its middle.
        let frame = plot.frame * place(0.0, 0.0, 0.0, 0.25 * side as f64);
        if side < 2 && plot.keeps(canvas) {
            for dash in 0..9 {
                let x = 5.5 * f64::from(dash) - 23.5;
                canvas.flat(ROAD_MARKING, &frame, [x, half - 0.08, x + 2.5, half + 0.08], 0.012);
            }
            for stripe in 0..10 {
                let z = HALF_BLOCK + 0.4 + 1.6 * f64::from(stripe);
                canvas.flat(ROAD_MARKING, &frame, [-27.5, z, -24.5, z + 0.8], 0.012);
            }
        }
        for x in [-14.0, 14.0] {
            if plot.keeps(canvas) {
                let lamp = frame * place(x, KERB, HALF_BLOCK - 0.6, 0.0);
                let mast = [(0.0, 0.0), (6.2, 0.0), (7.0, 0.35), (7.3, 1.0), (7.35, 2.0)];
                canvas.tube(STEEL, &lamp, &mast.map(|(y, z)| dvec3(0.0, y, z)), |t| 0.1 - 0.05 * t, 5);
                canvas.block(STEEL, &lamp, [-0.16, 7.26, 1.6], [0.16, 7.4, 2.4]);
            }
        }
        for x in [-21.0, -7.0, 7.0, 21.0] {
            let z = HALF_BLOCK - 1.0;
            if plot.dice.chance(0.6) {
                tree(canvas, plot, [[x, z], [z, -x], [-x, -z], [-z, x]][side]);
            }
        }
        for space in 0..7 {
            let taken = plot.dice.chance(0.4) && plot.keeps(canvas);
            let turns = if plot.dice.chance(0.5) { 0.5 } else { 0.0 };
            let colour = [RED_CAR, BLUE_CAR, WHITE, SILVER_CAR, YELLOW_CAR][plot.dice.below(5)];
            if taken {
                let x = f64::from(space) * 6.4 - 19.2;
                car(canvas, plot, &(frame * place(x, 0.0, HALF_BLOCK + 1.3, turns)), colour);
            }
        }
    }
}

/// A parked car, along x.
fn car(canvas: &mut Canvas, plot: &Plot, frame: &Frame, colour: u32) {
    let steps = plot.steps(canvas, 1.0, 1);
    canvas.rounded_block(colour, frame, [[-2.1, 0.28, -0.86], [2.1, 0.88, 0.86]], 0.2, steps);
    canvas.rounded_block(GLASS, frame, [[-1.5, 0.7, -0.76], [1.0, 1.38, 0.76]], 0.3, steps);
    canvas.block(colour, frame, [-1.2, 1.36, -0.6], [0.7, 1.41, 0.6]);
    let around = plot.steps(canvas, 10.0, 5);
    let tyre = [[0.0, -0.12], [0.32, -0.12], [0.32, 0.12], [0.0, 0.12]];
    for (x, z) in [(-1.3, 0.72), (1.3, 0.72), (-1.3, -0.72), (1.3, -0.72)] {
        let axle = *frame * place(x, 0.32, z, 0.0) * tilt(0.25);
        canvas.revolve(TYRE, &axle, &[&tyre[..2], &tyre[1..3], &tyre[2..]], [around, 1]);
    }
}

/// A tree on a plot, at this x and z, if the plot is rich enough.
fn tree(canvas: &mut Canvas, plot: &mut Plot, [x, z]: [f64; 2]) {
    let frame = plot.frame * place(x, KERB, z, plot.dice.unit());
    let height = plot.dice.between(5.0, 8.0);
    let seed = plot.dice.bits();
    if !plot.keeps(canvas) {
        return;
    }
    let around = plot.steps(canvas, 6.0, 3);
    let trunk = path(3, |t| dvec3(0.02 * height * t * t, 0.8 * height * t, 0.0));
    canvas.tube(BARK, &frame, &trunk, |t| (0.035 - 0.025 * t) * height, around);
    let count = plot.steps(canvas, 75.0, 8);
    let size = 0.23 * height * (75.0 / f64::from(count)).sqrt();
    let (wide, high) = (0.28 * height, 0.33 * height);
    let crown = frame * place(0.0, 0.66 * height, 0.0, 0.0) * stretch(wide, high, wide);
    canvas.leaves(LEAVES, &crown, count, size, seed);
}

/// A building, or one tier of a tower: glass behind walls.
struct Building {
    /// Half the footprint.
    half: DVec2,
    /// Height of its foot.
    foot: f64,
    floors: u32,
    floor_height: f64,
    /// Share of the height of a floor that is wall.
    solid: f64,
    wall: u32,
}

/// Gives the height at which the walls end.
fn draw_building(canvas: &mut Canvas, plot: &Plot, frame: &Frame, building: &Building) -> f64 {
    let Building { half, foot, floors, floor_height, solid, wall } = *building;
    let top = foot + f64::from(floors) * floor_height;
    canvas.block(GLASS, frame, [-half.x, foot, -half.y], [half.x, top, half.y]);
    let ledges = plot.steps(canvas, f64::from(floors), 1).min(floors);
    for ledge in 0..ledges {
        let low = foot + (top - foot) * f64::from(ledge) / f64::from(ledges);
        let high = low + solid * floor_height;
        canvas.band(wall, frame, [-half, half], &[[0.0, low], [0.22, low], [0.22, high], [0.0, high]]);
    }
    for side in 0..4 {
        let (out, width) = if side % 2 == 0 { (half.y, half.x) } else { (half.x, half.y) };
        let facade = *frame * place(0.0, 0.0, 0.0, 0.25 * f64::from(side)) * place(0.0, 0.0, out, 0.0);
        let bays = plot.steps(canvas, width / 1.5, 1);
        for rib in 0..=bays {
            let (x, reach) = (width * (2.0 * f64::from(rib) / f64::from(bays) - 1.0), 0.9 * solid);
            canvas.block(wall, &facade, [x - reach, foot, -0.1], [x + reach, top, 0.25]);
        }
    }
    canvas.block(ASPHALT, frame, [-half.x, top, -half.y], [half.x, top + 0.1, half.y]);
    let parapet = [[0.0, top], [0.3, top], [0.3, top + 0.9], [0.0, top + 0.9], [0.0, top + 0.1]];
    canvas.band(wall, frame, [-half, half], &parapet);
    canvas.block(CONCRETE, frame, [1.0, top, -1.5], [3.5, top + 2.6, 1.5]);
    top
}

/// One large tower, or four smaller ones, that step back as they rise.
fn towers(canvas: &mut Canvas, plot: &mut Plot) {
    let four = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let (lots, edge) = if plot.dice.chance(0.4) { (&[(0.0, 0.0)][..], 17.0) } else { (&four[..], 9.5) };
    for (x, z) in lots {
        let frame = plot.frame * place(0.52 * HALF_LOT * x, 0.0, 0.52 * HALF_LOT * z, 0.0);
        let half = edge * dvec2(plot.dice.between(0.85, 1.15), plot.dice.between(0.85, 1.15));
        let tiers = 1 + plot.dice.below(4) as u32;
        let height = plot.dice.between(0.2, 1.0) * 38.0 * (1.0 - plot.distance / 4.0).max(0.2);
        let floors = ((8.0 + height) as u32 / tiers).max(3);
        let wall = [CONCRETE, STEEL, SANDSTONE, WHITE][plot.dice.below(4)];
        let mut tier = Building { half, foot: KERB, floors, floor_height: 3.5, solid: 0.25, wall };
        for _ in 0..tiers {
            tier.foot = draw_building(canvas, plot, &frame, &tier);
            tier.half *= plot.dice.between(0.7, 0.88);
        }
        if plot.dice.chance(0.5) {
            let spire = [1.0, 1.25].map(|t| dvec3(0.0, tier.foot * t, 0.0));
            canvas.tube(STEEL, &frame, &spire, |t| 0.45 - 0.4 * t, 6);
        }
    }
}

/// Four blocks of flats around a lawn with trees.
fn flats(canvas: &mut Canvas, plot: &mut Plot) {
    for side in 0..4 {
        let turned = plot.frame * place(0.0, 0.0, 0.0, 0.25 * f64::from(side));
        let half = dvec2(plot.dice.between(13.0, 16.0), 6.5);
        let floors = 4 + plot.dice.below(5) as u32;
        let wall = [BRICK, SANDSTONE, WHITE, CONCRETE][plot.dice.below(4)];
        let house = Building { half, foot: KERB, floors, floor_height: 3.1, solid: 0.48, wall };
        draw_building(canvas, plot, &(turned * place(-7.0, 0.0, HALF_LOT - 7.5, 0.0)), &house);
    }
    canvas.flat(LAWN, &plot.frame, [-9.0, -9.0, 9.0, 9.0], KERB + 0.02);
    for _ in 0..5 {
        let (x, z) = (plot.dice.between(-7.0, 7.0), plot.dice.between(-7.0, 7.0));
        tree(canvas, plot, [x, z]);
    }
}
