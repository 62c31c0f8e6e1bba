//! `city`: a grid of streets with towers in its middle, flats around them and houses at its rim.
//!
//! Each [`Plot`] is a square with a block of buildings and half of the streets around it. More
//! triangles make a larger city; few make each plot coarser too.

mod building;
mod house;
mod street;

use glam::{DAffine3, dvec3};

use super::BuiltinInfo;
use super::foliage::{Leaves, sprig_texture};
use super::mesh::Canvas;
use super::numbers::{Dice, value_noise};
use super::setting::{Materials, Recipe, Setting, camera};
use super::shapes::{patch, place, stretch, tube};
use crate::Environment;

pub(super) const RECIPE: Recipe = Recipe {
    info: BuiltinInfo {
        name: "city",
        description: "Streets with towers, flats and houses, parked cars, lamps and trees with cut-out leaves, under an open sky.",
        default_triangles: 1_000_000,
        least_triangles: 25_000,
        most_triangles: 50_000_000,
    },
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

struct Paint {
    asphalt: u32,
    paving: u32,
    lawn: u32,
    road_marking: u32,
    glass: u32,
    concrete: u32,
    brick: u32,
    sandstone: u32,
    steel: u32,
    white: u32,
    roof: u32,
    roof_tile: u32,
    cars: [u32; 5],
    tyre: u32,
    bark: u32,
    leaves: u32,
}

impl Paint {
    fn new(materials: &mut Materials) -> Self {
        Self {
            asphalt: materials.matt("asphalt", [0.09, 0.09, 0.095]),
            paving: materials.matt("paving", [0.42, 0.4, 0.37]),
            lawn: materials.matt("lawn", [0.15, 0.25, 0.07]),
            road_marking: materials.matt("road marking", [0.75, 0.75, 0.7]),
            glass: materials.glossy("window glass", [0.04, 0.06, 0.08], 0.05),
            concrete: materials.matt("concrete", [0.52, 0.5, 0.46]),
            brick: materials.matt("brick", [0.42, 0.17, 0.11]),
            sandstone: materials.matt("sandstone", [0.6, 0.48, 0.33]),
            steel: materials.metal("steel", [0.55, 0.56, 0.58], 0.35),
            white: materials.glossy("white paint", [0.78, 0.77, 0.74], 0.5),
            roof: materials.matt("roofing felt", [0.2, 0.19, 0.18]),
            roof_tile: materials.matt("roof tile", [0.4, 0.14, 0.09]),
            cars: [
                materials.glossy("red car", [0.5, 0.03, 0.03], 0.15),
                materials.glossy("blue car", [0.04, 0.1, 0.35], 0.15),
                materials.glossy("white car", [0.75, 0.75, 0.75], 0.15),
                materials.metal("silver car", [0.7, 0.71, 0.73], 0.25),
                materials.glossy("yellow car", [0.75, 0.5, 0.03], 0.15),
            ],
            tyre: materials.matt("tyre", [0.03, 0.03, 0.03]),
            bark: materials.matt("bark", [0.2, 0.14, 0.09]),
            leaves: materials.cut_out("leaves", [1.0; 3], 0),
        }
    }
}

fn setting() -> Setting {
    let mut materials = Materials::default();
    Paint::new(&mut materials);
    Setting {
        materials: materials.0,
        textures: vec![sprig_texture()],
        lights: Vec::new(),
        environment: Some(Environment { zenith: [0.8, 1.15, 1.8], nadir: [0.55, 0.5, 0.45] }),
        cameras: vec![
            camera("skyline", [-235.0, 150.0, 290.0], [20.0, 22.0, -20.0], 0.11),
            camera("avenue", [38.6, 2.4, 104.0], [36.0, 13.0, 0.0], 0.16),
            camera("crossing", [30.5, 7.0, 43.5], [60.0, 9.0, -20.0], 0.18),
        ],
    }
}

/// A square of the grid.
struct Plot {
    column: i64,
    row: i64,
    frame: DAffine3,
    dice: Dice,
    /// How much to put on it, in (0, 1].
    richness: f64,
    /// Which share of its lots has buildings: the youngest plot is still growing.
    built_up: f64,
}

impl Plot {
    /// The plots in the order in which the city grows: outwards in square rings.
    fn nth(index: u32, richness: f64, built_up: f64) -> Self {
        let (column, row) = spiral(i64::from(index));
        Self {
            column,
            row,
            frame: place(PITCH * column as f64, 0.0, PITCH * row as f64, 0.0),
            dice: Dice::of_cell(501, column, row),
            richness,
            built_up,
        }
    }

    /// The same plot with dice of its own: what is drawn with them can throw them as often as its
    /// detail wants, and nothing drawn later changes.
    fn part(&mut self) -> Self {
        Self { dice: Dice::new(self.dice.bits()), ..*self }
    }

    /// How far from the middle of the city, in plots.
    fn distance(&self) -> f64 {
        let (column, row) = (self.column as f64, self.row as f64);
        (column * column + row * row).sqrt()
    }

    /// Whether nothing was built yet on this one of so many lots.
    fn is_vacant(&self, lot: u32, lots: u32) -> bool {
        (f64::from(lot) + 0.5) / f64::from(lots) > self.built_up
    }

    /// Whether something that a rich plot has is there on this one.
    fn keeps(&self, canvas: &mut Canvas) -> bool {
        canvas.round(2.0 * self.richness) > 0
    }

    /// Rounds a number of things up or down at random after scaling it by the richness.
    fn steps(&self, canvas: &mut Canvas, at_full_richness: f64, least: u32) -> u32 {
        canvas.round(at_full_richness * self.richness).max(least)
    }
}

/// The place of the n-th square of a spiral around the origin.
fn spiral(index: i64) -> (i64, i64) {
    let mut ring = 0;
    while (2 * ring + 1) * (2 * ring + 1) <= index {
        ring += 1;
    }
    if ring == 0 {
        return (0, 0);
    }
    let along = index - (2 * ring - 1) * (2 * ring - 1);
    let (side, offset) = (along / (2 * ring), along % (2 * ring) - ring);
    match side {
        0 => (ring, offset),
        1 => (-offset, ring),
        2 => (-ring, -offset),
        _ => (offset, -ring),
    }
}

fn draw(canvas: &mut Canvas) {
    let paint = Paint::new(&mut Materials::default());
    // A smaller city has fewer plots and less on each of them.
    let richness = canvas.detail().sqrt().clamp(0.02, 1.0);
    let area = (140.0 * canvas.detail() / richness).max(9.0);
    let plots = area.ceil() as u32;
    let reach = PITCH * (f64::from(plots).sqrt() + 16.0);
    let corners = [(-1.0, 1.0), (1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)];
    let ground = corners.map(|(x, z)| dvec3(reach * x, -0.3, reach * z));
    patch(canvas, paint.lawn, ground, [1, 1]);
    for index in 0..plots {
        let built_up = (area - f64::from(index)).min(1.0);
        let mut plot = Plot::nth(index, richness, built_up);
        street::draw(canvas, &paint, &mut plot);
        build_up(canvas, &paint, &mut plot);
    }
}

/// Fills the block of a plot with what stands in this part of the city.
fn build_up(canvas: &mut Canvas, paint: &Paint, plot: &mut Plot) {
    let distance = plot.distance() + 0.8 * value_noise(507, plot.column as f64 * 0.7, plot.row as f64 * 0.7);
    let park = plot.dice.chance(0.09) && plot.distance() > 0.5;
    if park {
        street::park(canvas, paint, plot);
    } else if distance < 1.9 {
        building::tower_block(canvas, paint, plot);
    } else if distance < 4.0 {
        building::flats_block(canvas, paint, plot);
    } else {
        house::row(canvas, paint, plot);
    }
}

/// A tree of this height, if the plot is rich enough; its frame stands on the ground.
fn tree(canvas: &mut Canvas, paint: &Paint, plot: &mut Plot, frame: &DAffine3, height: f64) {
    let plot = &mut plot.part();
    if !plot.keeps(canvas) {
        return;
    }
    let lean = plot.dice.between(-0.04, 0.04) * height;
    let path = [0.0, 0.3, 0.55, 0.8]
        .map(|t| frame.transform_point3(dvec3(lean * t * t, height * t, 0.5 * lean * t)));
    let around = plot.steps(canvas, 6.0, 3);
    tube(canvas, paint.bark, &path, |t| (0.035 - 0.025 * t) * height, around);
    let count = plot.steps(canvas, 75.0, 8);
    let size = 0.23 * height * (75.0 / f64::from(count)).sqrt();
    let (wide, high) = (0.28 * height, 0.33 * height);
    let crown = *frame * place(lean * 0.5, 0.66 * height, 0.2 * lean, 0.0) * stretch(wide, high, wide);
    Leaves { material: paint.leaves, count, size }.draw(canvas, &crown, &mut plot.dice);
}
