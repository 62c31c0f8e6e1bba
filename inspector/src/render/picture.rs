//! All of a picture in space, as data: from where, what, how. Two equal ones look the same.

use std::ops::Range;

use bytemuck::{Pod, Zeroable};

use super::camera::Camera;
use super::geometry::Geometry;
use super::range::ValueRange;
use crate::colour_map::ColourMap;
use crate::theme::ShaderColour;

/// How a layer is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Surfaces that hide what is behind them.
    Solid,
    /// Surfaces that one looks through.
    Ghost,
    /// Edges of surfaces.
    Wire,
    /// Lines; what is hidden by surfaces is drawn fainter.
    Lines,
    /// Heads at the ends of lines.
    Arrows,
    /// Marks at the second points of lines; the number of a second point says which (see
    /// [`Mark`](super::geometry::Mark)).
    Marks,
    /// Translucent boxes.
    Boxes,
    /// Translucent capsules.
    Capsules,
    /// Lines in front of everything.
    OnTop,
}

/// What gives a layer its colour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Paint {
    /// One colour.
    Plain(ShaderColour),
    /// The values of its vertices.
    Values(ColourMap, ValueRange),
    /// The colours of surfaces.
    Base {
        /// Of what has none.
        plain: ShaderColour,
        /// What they fade to, and how much of them is left, in place of alpha.
        faded: ShaderColour,
    },
}

/// One thing that is drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// Its vertices.
    pub geometry: Geometry,
    /// Which of its lines or capsules, all if `None`.
    pub part: Option<Range<u32>>,
    /// How.
    pub stage: Stage,
    /// Its colour.
    pub paint: Paint,
    /// 0 to 1.
    pub opacity: f32,
    /// Opacity of what surfaces hide, for lines.
    pub hidden_opacity: f32,
    /// Of lines and marks, pixels.
    pub width: f32,
}

impl Layer {
    /// All of a geometry, hidden by surfaces, with lines of no width.
    pub fn of(geometry: &Geometry, stage: Stage, paint: Paint, opacity: f32) -> Self {
        let geometry = geometry.clone();
        Self { geometry, part: None, stage, paint, opacity, hidden_opacity: 0.0, width: 0.0 }
    }
}

/// What is cut away: all points with `normal · p > offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cut {
    /// Direction of what is cut away.
    pub normal: [f32; 3],
    /// Where.
    pub offset: f32,
}

impl Cut {
    /// Nothing is cut away.
    pub const NONE: Self = Self { normal: [0.0; 3], offset: 1.0 };
}

/// All of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct SpacePicture {
    /// From where.
    pub camera: Camera,
    /// Pixels across and down, at least 1.
    pub pixels: [u32; 2],
    /// Behind everything.
    pub background: ShaderColour,
    /// What is cut away of surfaces.
    pub cut: Cut,
    /// The sides of a room that is seen from outside: its walls before its middle are not drawn.
    pub room: Option<[f32; 3]>,
    /// What is drawn.
    pub layers: Vec<Layer>,
}

/// What shaders know of a layer; 160 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct LayerUniform {
    /// From unit space to clip space.
    pub clip_from_unit: [[f32; 4]; 4],
    /// Where the camera stands.
    pub eye: [f32; 4],
    /// One colour for all; by value where its alpha is 0.
    pub plain: [f32; 4],
    /// What is cut away: normal and offset.
    pub cut: [f32; 4],
    /// The sides of a room, and 1 if its walls are not drawn.
    pub room: [f32; 4],
    /// What surfaces' own colours fade to, and how much of them is left: 0 for `plain`.
    pub faded: [f32; 4],
    /// Pixels across and down.
    pub viewport: [f32; 2],
    /// Of lines, pixels.
    pub width: f32,
    /// 0 to 1.
    pub opacity: f32,
    /// Value of the first colour.
    pub low: f32,
    /// Value of the last colour.
    pub high: f32,
    /// Row of the colour map.
    pub map: u32,
    /// Points from one line, mark or box to the next.
    pub points_each: u32,
}

impl LayerUniform {
    /// Of a layer of a picture, drawn with this opacity.
    pub fn of(picture: &SpacePicture, layer: &Layer, opacity: f32) -> Self {
        let [width, height] = picture.pixels.map(|pixels| pixels as f32);
        let unused = ValueRange { low: 0.0, high: 1.0 };
        let (plain, faded, map, range) = match layer.paint {
            Paint::Plain(colour) => (colour, [0.0; 4], 0, unused),
            Paint::Values(map, range) => ([0.0; 4], [0.0; 4], map.row() as u32, range),
            Paint::Base { plain, faded } => (plain, faded, 0, unused),
        };
        // Rays and what is computed of them are never cut: they are what one looks for inside.
        let cut = match layer.stage {
            Stage::Solid | Stage::Ghost | Stage::Wire => picture.cut,
            _ => Cut::NONE,
        };
        let [x, y, z] = cut.normal;
        let room = picture.room.map_or([0.0; 4], |[width, height, depth]| [width, height, depth, 1.0]);
        Self {
            clip_from_unit: picture.camera.clip_from_unit(width / height).to_cols_array_2d(),
            eye: picture.camera.eye().extend(1.0).to_array(),
            plain,
            cut: [x, y, z, cut.offset],
            room,
            faded,
            viewport: [width, height],
            width: layer.width,
            opacity,
            low: range.low,
            high: range.high,
            map,
            points_each: layer.geometry.shape().points_each(),
        }
    }
}
