//! `atrium`: an open court between two storeys of arcades.
//!
//! The court lies along x, its centre at the origin. Around it run four [`Side`]s, each drawn in a
//! frame of its own: x along the row of columns, y up, z from the columns towards the outer wall.

mod aisle;
mod arcade;
mod court;

use super::canvas::Canvas;
use super::foliage::sprig_texture;
use super::setting::{Recipe, camera, cut_out, environment, glossy, matt, metal, palette, sphere_light};
use super::shapes::{Frame, place};
use crate::Scene;

pub(super) const RECIPE: Recipe = Recipe {
    name: "atrium",
    description: "An open court between two storeys of columns and arches, with vaults, curtains, a fountain and plants; sky and sphere lights.",
    triangles: [80_000, 262_144, 20_000_000],
    setting,
    draw,
};

/// From column to column, metres.
const BAY: f64 = 3.0;
/// From the columns to the outer wall.
const DEPTH: f64 = 3.6;
/// Half the court's extent along x and z, to the middle of the columns.
const COURT: [f64; 2] = [12.0, 4.5];
/// Height of the upper floor.
const UPPER_FLOOR: f64 = 5.0;
/// Height of the cornice above the upper arches.
const CORNICE: f64 = 9.2;
/// Half the thickness of the arcade walls.
const HALF_WALL: f64 = 0.25;

palette! {
    LIMESTONE = matt("limestone", [0.62, 0.54, 0.42]);
    MARBLE = glossy("marble", [0.74, 0.7, 0.64], 0.35);
    PLASTER = matt("plaster", [0.72, 0.58, 0.42]);
    DARK_TILE = glossy("dark tile", [0.22, 0.17, 0.14], 0.25);
    LIGHT_TILE = glossy("light tile", [0.6, 0.54, 0.45], 0.3);
    WOOD = glossy("oak", [0.3, 0.18, 0.09], 0.6);
    ROOF_TILE = matt("roof tile", [0.55, 0.24, 0.13]);
    BRONZE = metal("bronze", [0.65, 0.45, 0.25], 0.35);
    WATER = glossy("water", [0.05, 0.12, 0.13], 0.03);
    CLAY = matt("clay", [0.58, 0.31, 0.19]);
    LEAVES = cut_out("leaves", 0);
    RED_CLOTH = matt("red cloth", [0.55, 0.07, 0.05]);
    GREEN_CLOTH = matt("green cloth", [0.1, 0.3, 0.12]);
    BLUE_CLOTH = matt("blue cloth", [0.08, 0.14, 0.42]);
}

fn setting() -> Scene {
    let warm = [24.0, 19.0, 12.0];
    let light = |(frame, _): (Frame, f64)| sphere_light(frame.translation.as_vec3().to_array(), warm);
    Scene {
        materials: materials(),
        textures: vec![sprig_texture()],
        lights: lanterns()
            .map(light)
            .into_iter()
            .chain([environment([1.5, 2.0, 2.9], [0.6, 0.54, 0.48])])
            .collect(),
        cameras: vec![
            camera("court", [-10.9, 1.7, 1.6], [6.0, 3.9, -0.9], 0.17),
            camera("gallery", [9.6, 6.9, 6.4], [-4.0, 4.0, -2.6], 0.17),
            camera("aisle", [-14.2, 1.7, 7.3], [2.0, 2.2, 5.2], 0.17),
        ],
        ..Scene::default()
    }
}

/// One side of the court.
struct Side {
    frame: Frame,
    bays: u32,
}

impl Side {
    /// The four sides, counter-clockwise seen from above; each begins at a corner of the court.
    fn all() -> [Self; 4] {
        let [x, z] = COURT;
        let long = (2.0 * x / BAY) as u32;
        let short = (2.0 * z / BAY) as u32;
        [(-x, z, long, 0.0), (x, z, short, 0.25), (x, -z, long, 0.5), (-x, -z, short, 0.75)]
            .map(|(x, z, bays, turns)| Self { frame: place(x, 0.0, z, turns), bays })
    }

    fn length(&self) -> f64 {
        BAY * f64::from(self.bays)
    }

    /// The frame of a bay: its origin is the middle of the bay on the row of columns.
    fn bay(&self, bay: u32, height: f64) -> Frame {
        self.frame * place(BAY * (f64::from(bay) + 0.5), height, 0.0, 0.0)
    }
}

/// Two lanterns in the lower and one in the upper walk along each of the long sides: a frame that stands where
/// the light is, and how far above the chain is fixed, metres.
fn lanterns() -> [(Frame, f64); 6] {
    let [front, _, back, _] = Side::all();
    let lower = |side: &Side, bay| (side.bay(bay, 3.27), 1.1);
    let upper = |side: &Side, bay| (side.bay(bay, UPPER_FLOOR + 3.0), 2.0);
    [lower(&front, 1), lower(&front, 6), lower(&back, 1), lower(&back, 6), upper(&front, 4), upper(&back, 4)]
        .map(|(bay, chain)| (bay * place(0.0, 0.0, 0.5 * DEPTH, 0.0), chain))
}

fn draw(canvas: &mut Canvas) {
    for (index, side) in Side::all().iter().enumerate() {
        arcade::draw(canvas, side);
        aisle::draw(canvas, side, index as u64);
    }
    for (frame, chain) in lanterns() {
        aisle::lantern(canvas, &frame, chain);
    }
    court::draw(canvas);
}
