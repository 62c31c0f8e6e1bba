//! Scenes that need no file: generated, deterministic, of any size.
//!
//! The same name and count give the same bits on every machine. Each scene draws on a [`Canvas`] at
//! some level of detail; [`build`] searches for the level that gives the wanted number of
//! triangles.

mod apartment;
mod atrium;
mod canvas;
mod city;
mod cornell;
mod foliage;
mod hairball;
mod numbers;
mod setting;
mod shapes;
mod terrain;

use canvas::Canvas;
use setting::Recipe;

use crate::bvh::BYTES_PER_TRIANGLE;
use crate::memory::{self, Shortage};
use crate::shown::shown;
use crate::{Light, Scene};

/// What there is to know about a built-in scene before it is built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BuiltinInfo {
    /// Name to choose it by.
    pub name: &'static str,
    /// One sentence.
    pub description: &'static str,
    /// How many triangles it has, within 5 %, if none are asked for.
    pub default_triangles: u64,
    /// The coarsest it can be; a smaller count gives this one.
    pub least_triangles: u64,
    /// The finest it is made for; a larger count is refused.
    pub most_triangles: u64,
}

/// Why a built-in scene was not built.
#[derive(Debug, thiserror::Error, PartialEq, Eq)]
#[expect(missing_docs, reason = "each message says what it and its fields mean")]
pub enum BuiltinError {
    #[error("there is no built-in scene \"{}\"; there are: {known}", shown(name))]
    UnknownName { name: String, known: String },
    #[error(
        "builtin:{name} cannot have {asked} triangles, expected {least} to {most}; ask for another count"
    )]
    TriangleCount { name: &'static str, asked: u64, least: u64, most: u64 },
    #[error("builtin:{name} with {asked} triangles: {source}; ask for fewer")]
    Memory { name: &'static str, asked: u64, source: Shortage },
}

static RECIPES: [Recipe; 6] =
    [cornell::RECIPE, atrium::RECIPE, apartment::RECIPE, city::RECIPE, hairball::RECIPE, terrain::RECIPE];

/// All built-in scenes.
pub fn list() -> [BuiltinInfo; RECIPES.len()] {
    RECIPES.each_ref().map(|&Recipe { name, description, triangles: [least, default, most], .. }| {
        BuiltinInfo {
            name,
            description,
            default_triangles: default,
            least_triangles: least,
            most_triangles: most,
        }
    })
}

/// Builds a built-in scene with about this many triangles: within 5 %, but never fewer than the
/// scene's `least_triangles` (a notice in the scene says so). `None` gives its default.
///
/// # Errors
/// If no scene has this name, or if `triangles` is 0 or more than the scene's `most_triangles`,
/// which keeps every index in 32 bits.
pub fn build(name: &str, triangles: Option<u64>) -> Result<Scene, BuiltinError> {
    let (recipe, asked) = recipe_for(name, triangles)?;
    let (name, least) = (recipe.name, recipe.triangles[0]);
    let mut canvas = Canvas::new(detail_for(recipe, asked.max(least)), Some((recipe.setting)()));
    (recipe.draw)(&mut canvas);
    let mut scene = Scene { name: name.into(), ..canvas.scene.unwrap_or_default() };
    finish(&mut scene);
    if asked < least {
        scene.notices.push(format!(
            "builtin:{name} cannot do with {asked} triangles and has {}, about its fewest",
            scene.triangles.len()
        ));
    }
    Ok(scene)
}

/// Refuses what [`build`] would refuse, without building it.
///
/// # Errors
/// As [`build`].
pub fn check(name: &str, triangles: u64) -> Result<(), BuiltinError> {
    recipe_for(name, Some(triangles)).map(drop)
}

/// The recipe of a name, and how many triangles are asked of it.
fn recipe_for(name: &str, triangles: Option<u64>) -> Result<(&'static Recipe, u64), BuiltinError> {
    let Some(recipe) = RECIPES.iter().find(|recipe| recipe.name == name) else {
        let known = RECIPES.each_ref().map(|recipe| recipe.name).join(", ");
        return Err(BuiltinError::UnknownName { name: name.into(), known });
    };
    let (name, [least, default, most]) = (recipe.name, recipe.triangles);
    let asked = triangles.unwrap_or(default);
    if asked == 0 || asked > most {
        return Err(BuiltinError::TriangleCount { name, asked, least, most });
    }
    memory::check(asked * BYTES_PER_TRIANGLE, memory::free()).map_err(|source| BuiltinError::Memory {
        name,
        asked,
        source,
    })?;
    Ok((recipe, asked))
}

/// The level of detail at which a scene has as close to `wanted` triangles as can be found.
fn detail_for(recipe: &Recipe, wanted: u64) -> f64 {
    let count_at = |detail: f64| {
        let mut canvas = Canvas::new(detail, None);
        (recipe.draw)(&mut canvas);
        canvas.triangle_count
    };
    // Each a level of detail and its count; the wanted one lies between them.
    let mut low = (0.0, count_at(0.0));
    let mut high = (1.0, count_at(1.0));
    while high.1 < wanted {
        low = high;
        high = (2.0 * high.0, count_at(2.0 * high.0));
    }
    let mut nearest = if wanted.abs_diff(low.1) < wanted.abs_diff(high.1) { low } else { high };
    // Close enough that nobody can tell; more of the search would be for nothing.
    let is_close = |count: u64| count.abs_diff(wanted) <= wanted / 400;
    for step in 0..24 {
        if is_close(nearest.1) {
            return nearest.0;
        }
        // The count is nearly linear in the detail; where it is not, halving always gets on.
        let share = match step % 3 {
            2 => 0.5,
            _ => wanted.saturating_sub(low.1) as f64 / high.1.abs_diff(low.1).max(1) as f64,
        };
        let middle = low.0 + (high.0 - low.0) * share.clamp(0.01, 0.99);
        let found = (middle, count_at(middle));
        if found.1.abs_diff(wanted) < nearest.1.abs_diff(wanted) {
            nearest = found;
        }
        if found.1 < wanted {
            low = found;
        } else {
            high = found;
        }
    }
    // The count jumps where a whole part of the scene comes or goes, and rounding at random makes
    // it waver: somewhere around the jump is a level that does better than the jump itself.
    for step in 0..60 {
        if is_close(nearest.1) {
            break;
        }
        let detail = low.0 * (0.88 + 0.004 * f64::from(step));
        let count = count_at(detail);
        if count.abs_diff(wanted) < nearest.1.abs_diff(wanted) {
            nearest = (detail, count);
        }
    }
    nearest.0
}

/// Removes arrays that nothing in a scene uses, and adds one light for every run of neighbouring triangles of
/// one emissive material.
///
/// Lamps of the same material that are drawn one after the other would become one light: give each its own
/// draw order, or mean it.
fn finish(scene: &mut Scene) {
    if scene.normals.iter().all(|normal| *normal == [0.0; 3]) {
        scene.normals = Vec::new();
    }
    if scene.textures.is_empty() {
        scene.uvs = Vec::new();
    }
    let mut first_triangle = 0;
    for run in scene.triangle_materials.chunk_by(|a, b| a == b) {
        let triangle_count = run.len() as u32;
        if scene.materials[run[0] as usize].is_emissive() {
            scene.lights.push(Light::Emissive { first_triangle, triangle_count });
        }
        first_triangle += triangle_count;
    }
    // An environment comes last.
    scene.lights.sort_by_key(|light| matches!(light, Light::Environment(_)));
}
