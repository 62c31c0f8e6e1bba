//! `apartment`: six furnished rooms, lit from inside.
//!
//! The floor plan, in metres; x runs to the right, z down:
//!
//! ```text
//!   0            8       14
//! 0 +------------+-------+
//!   |            | kit-  |
//!   |  living    | chen  |
//!   |            +-------+ 4.5
//!   |              hall  |
//! 6 +------+-----+-------+
//!   | bed- |     |       |
//!   | room |study| bath  |
//! 10+------+-----+-------+
//!   0      5     9       14
//! ```

mod bath;
mod bedroom;
mod decor;
mod kitchen;
mod living;
mod shell;
mod study;
mod table;

use super::BuiltinInfo;
use super::mesh::Canvas;
use super::setting::{Materials, Recipe, Setting, camera, sphere_light};
use crate::Environment;

pub(super) const RECIPE: Recipe = Recipe {
    info: BuiltinInfo {
        name: "apartment",
        description: "Six rooms with furniture, books, crockery, plants and a mirror, lit by lamps and a glowing panel.",
        default_triangles: 400_000,
        least_triangles: 75_000,
        most_triangles: 20_000_000,
    },
    setting,
    draw,
};

/// From floor to ceiling, metres.
const CEILING: f64 = 2.7;

/// Where the sphere lights are; each hangs or stands in a lamp of its own.
const DINING_LIGHT: [f64; 3] = [5.9, 1.62, 4.3];
const LIVING_LIGHT: [f64; 3] = [2.6, 2.3, 3.0];
const FLOOR_LAMP_LIGHT: [f64; 3] = [0.65, 1.52, 5.2];
const BEDROOM_LIGHT: [f64; 3] = [2.9, 2.3, 8.0];
const BEDSIDE_LIGHT: [f64; 3] = [0.45, 0.86, 9.3];
const STUDY_LIGHT: [f64; 3] = [7.0, 2.3, 7.8];
const DESK_LIGHT: [f64; 3] = [5.75, 1.14, 9.15];
const HALL_LIGHT: [f64; 3] = [10.5, 2.3, 5.25];
const BATH_LIGHT: [f64; 3] = [11.4, 2.3, 7.9];

struct Paint {
    wall: u32,
    ceiling: u32,
    planks: [u32; 3],
    white: u32,
    oak: u32,
    walnut: u32,
    black: u32,
    sofa: u32,
    cushions: [u32; 3],
    linen: u32,
    rug: u32,
    curtain: u32,
    books: [u32; 6],
    pages: u32,
    leaf: u32,
    soil: u32,
    clay: u32,
    china: u32,
    floor_tile: u32,
    wall_tile: u32,
    worktop: u32,
    steel: u32,
    chrome: u32,
    brass: u32,
    copper: u32,
    mirror: u32,
    screen: u32,
    bottle: u32,
    fruit: [u32; 2],
    shade: u32,
    panel: u32,
    pictures: [u32; 3],
}

impl Paint {
    fn new(materials: &mut Materials) -> Self {
        Self {
            wall: materials.matt("wall", [0.78, 0.75, 0.69]),
            ceiling: materials.matt("ceiling", [0.84, 0.83, 0.8]),
            planks: [
                materials.glossy("light plank", [0.46, 0.31, 0.18], 0.35),
                materials.glossy("plank", [0.41, 0.26, 0.14], 0.35),
                materials.glossy("dark plank", [0.36, 0.22, 0.12], 0.35),
            ],
            white: materials.glossy("white lacquer", [0.8, 0.79, 0.76], 0.3),
            oak: materials.glossy("oak", [0.5, 0.34, 0.19], 0.5),
            walnut: materials.glossy("walnut", [0.24, 0.14, 0.08], 0.4),
            black: materials.glossy("black plastic", [0.03, 0.03, 0.035], 0.3),
            sofa: materials.matt("sofa cloth", [0.16, 0.24, 0.27]),
            cushions: [
                materials.matt("mustard cloth", [0.62, 0.41, 0.08]),
                materials.matt("rust cloth", [0.5, 0.17, 0.08]),
                materials.matt("cream cloth", [0.74, 0.68, 0.56]),
            ],
            linen: materials.matt("linen", [0.78, 0.77, 0.74]),
            rug: materials.matt("rug", [0.45, 0.14, 0.1]),
            curtain: materials.matt("curtain", [0.62, 0.55, 0.43]),
            books: [
                materials.matt("red book", [0.42, 0.08, 0.06]),
                materials.matt("blue book", [0.08, 0.15, 0.36]),
                materials.matt("green book", [0.1, 0.27, 0.14]),
                materials.glossy("black book", [0.05, 0.05, 0.06], 0.35),
                materials.matt("ochre book", [0.55, 0.4, 0.14]),
                materials.glossy("white book", [0.75, 0.74, 0.7], 0.4),
            ],
            pages: materials.matt("pages", [0.76, 0.72, 0.6]),
            leaf: materials.glossy("house plant", [0.09, 0.26, 0.07], 0.45),
            soil: materials.matt("soil", [0.1, 0.07, 0.05]),
            clay: materials.matt("clay", [0.56, 0.29, 0.18]),
            china: materials.glossy("china", [0.84, 0.83, 0.8], 0.12),
            floor_tile: materials.glossy("floor tile", [0.32, 0.33, 0.34], 0.2),
            wall_tile: materials.glossy("wall tile", [0.58, 0.7, 0.7], 0.12),
            worktop: materials.glossy("granite", [0.1, 0.1, 0.11], 0.15),
            steel: materials.metal("brushed steel", [0.6, 0.6, 0.62], 0.32),
            chrome: materials.metal("chrome", [0.76, 0.77, 0.78], 0.08),
            brass: materials.metal("brass", [0.85, 0.63, 0.3], 0.28),
            copper: materials.metal("copper", [0.93, 0.55, 0.4], 0.22),
            mirror: materials.metal("mirror", [0.93, 0.94, 0.94], 0.0),
            screen: materials.glossy("screen", [0.02, 0.02, 0.025], 0.06),
            bottle: materials.glossy("bottle glass", [0.04, 0.16, 0.07], 0.05),
            fruit: [
                materials.glossy("apple", [0.55, 0.09, 0.05], 0.3),
                materials.glossy("orange", [0.8, 0.36, 0.05], 0.45),
            ],
            shade: materials.matt("lampshade", [0.8, 0.7, 0.52]),
            panel: materials.lamp("ceiling panel", [14.0, 13.6, 12.6]),
            pictures: [
                materials.matt("blue picture", [0.14, 0.3, 0.48]),
                materials.matt("red picture", [0.55, 0.2, 0.12]),
                materials.matt("sand picture", [0.64, 0.55, 0.38]),
            ],
        }
    }
}

fn setting() -> Setting {
    let mut materials = Materials::default();
    Paint::new(&mut materials);
    let lamp = |[x, y, z]: [f64; 3], power: f32| {
        let intensity = [power, 0.82 * power, 0.58 * power];
        sphere_light([x as f32, y as f32, z as f32], intensity)
    };
    Setting {
        materials: materials.0,
        textures: Vec::new(),
        lights: vec![
            lamp(DINING_LIGHT, 12.0),
            lamp(LIVING_LIGHT, 16.0),
            lamp(FLOOR_LAMP_LIGHT, 8.0),
            lamp(BEDROOM_LIGHT, 12.0),
            lamp(BEDSIDE_LIGHT, 4.0),
            lamp(STUDY_LIGHT, 11.0),
            lamp(DESK_LIGHT, 3.0),
            lamp(HALL_LIGHT, 9.0),
            lamp(BATH_LIGHT, 11.0),
        ],
        environment: Some(Environment { zenith: [2.4, 3.0, 4.0], nadir: [1.1, 1.1, 1.1] }),
        cameras: vec![
            camera("living", [7.4, 1.6, 0.7], [1.8, 0.8, 4.6], 0.17),
            camera("kitchen", [8.5, 1.65, 4.0], [12.6, 0.9, 0.9], 0.18),
            camera("bedroom", [4.6, 1.65, 6.5], [1.0, 0.6, 9.2], 0.18),
        ],
    }
}

fn draw(canvas: &mut Canvas) {
    let paint = Paint::new(&mut Materials::default());
    shell::draw(canvas, &paint);
    living::draw(canvas, &paint);
    kitchen::draw(canvas, &paint);
    bedroom::draw(canvas, &paint);
    study::draw(canvas, &paint);
    bath::draw(canvas, &paint);
    shell::furnish_hall(canvas, &paint);
}
