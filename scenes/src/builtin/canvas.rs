//! What built-in scenes are drawn on: a scene that grows, or only a count of its triangles.

use glam::{DVec2, DVec3};

use super::numbers::Dice;
use crate::Scene;

/// One corner of a triangle, before it is rounded to single precision.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Vertex {
    /// Place in world space, metres.
    pub(super) position: DVec3,
    /// Unit normal, or zero where the face normal is meant.
    pub(super) normal: DVec3,
    /// Texture coordinates, v down.
    pub(super) uv: DVec2,
}

impl Scene {
    /// Appends a vertex and gives its index.
    pub(super) fn push_vertex(&mut self, vertex: Vertex) -> u32 {
        let index = self.positions.len() as u32;
        self.positions.push(vertex.position.as_vec3().to_array());
        self.normals.push(vertex.normal.as_vec3().to_array());
        self.uvs.push(vertex.uv.as_vec2().to_array());
        index
    }

    /// Appends a triangle, counter-clockwise seen from outside.
    pub(super) fn push_triangle(&mut self, material: u32, corners: [u32; 3]) {
        self.triangles.push(corners);
        self.triangle_materials.push(material);
    }
}

/// A place to draw a scene on, at some level of detail.
///
/// A scene is drawn several times: first on canvases that only count, then on one that keeps. So how
/// many triangles a stroke has must be known before it is drawn, and random numbers that later
/// strokes depend on must not be taken inside it.
#[derive(Debug)]
pub(super) struct Canvas {
    /// The level of detail, 0 for the coarsest scene.
    pub(super) detail: f64,
    dither: Dice,
    /// How many triangles were drawn.
    pub(super) triangle_count: u64,
    /// What was drawn; none on a canvas that only counts.
    pub(super) scene: Option<Scene>,
}

impl Canvas {
    /// `detail` is 0 for the coarsest scene and 1 for about the default. What is drawn is kept in `scene`, or
    /// only counted if there is none.
    pub(super) fn new(detail: f64, scene: Option<Scene>) -> Self {
        Self { detail, dither: Dice::new(0x5EED), triangle_count: 0, scene }
    }

    /// Into how many steps to cut something that wants `at_default` of them at detail 1: at least
    /// `least`, growing in proportion to the detail.
    pub(super) fn steps(&mut self, at_default: f64, least: u32) -> u32 {
        self.round(at_default * self.detail).max(least)
    }

    /// A whole number near `wanted` (≥ 0), its fraction rounded up or down at random, once per call:
    /// so the triangles of a whole scene grow smoothly with its detail although every count is an
    /// integer.
    pub(super) fn round(&mut self, wanted: f64) -> u32 {
        (wanted + self.dither.unit()).floor() as u32
    }

    /// Draws `triangle_count` triangles by calling `stroke`, or counts them.
    pub(super) fn draw(&mut self, triangle_count: u64, stroke: impl FnOnce(&mut Scene)) {
        self.triangle_count += triangle_count;
        if let Some(scene) = &mut self.scene {
            stroke(scene);
            debug_assert_eq!(scene.triangles.len() as u64, self.triangle_count);
        }
    }
}
