//! What the scene view shows, and how.

use serde::{Deserialize, Serialize};

use crate::colour_map::ColourMap;
use crate::model::colour_by::ColourBy;
use crate::render::geometry::RayEnd;

/// How the scene's surfaces are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum MeshMode {
    /// Not at all.
    Hidden,
    /// They hide what is behind them.
    #[default]
    Solid,
    /// One looks through them.
    Ghost,
    /// Their edges alone.
    Wire,
}

/// Which capsules are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum CapsuleChoice {
    /// That of the selected group.
    #[default]
    Selected,
    /// Those with the largest area.
    Worst,
    /// Some, spread evenly along the order.
    Spread,
}

/// Which boxes of the hierarchy are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum VisitChoice {
    /// None.
    #[default]
    Hidden,
    /// Those that the selected ray enters; the middle one while none is selected.
    Ray,
    /// Those that any ray of its group enters.
    Group,
}

/// Where the camera stands at first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum StandPoint {
    /// Where the recording's camera stood.
    #[default]
    Recorded,
    /// Outside of the scene, which is seen as a whole.
    Overview,
    /// Outside, near enough for the path that is shown.
    Path,
}

/// An axis of unit space.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Axis {
    /// The first.
    X,
    /// Upwards.
    #[default]
    Y,
    /// The third.
    Z,
}

/// Which side of the clipping plane stays.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Side {
    /// The one towards 0.
    #[default]
    Below,
    /// The other.
    Above,
}

/// What dragging in the picture does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Navigation {
    /// Turns around the target.
    #[default]
    Orbit,
    /// Turns the head; keys fly.
    Fly,
}

/// What is shown, and how. Sessions and `shot --set` know the fields by these names.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SpaceOptions {
    /// The scene's surfaces.
    pub mesh: MeshMode,
    /// Opacity of surfaces that one looks through, 0 to 1.
    pub ghost_opacity: f32,
    /// The axis that the clipping plane stands on.
    pub clip_axis: Axis,
    /// Where on it surfaces are cut, part of the scene's extent along it; 1 (0 for [`Side::Above`]) for no cut.
    pub clip_at: f32,
    /// Which side of it stays.
    pub clip_keeps: Side,
    /// The curve of the order.
    pub curve: bool,
    /// Through which ends of the rays it goes.
    pub curve_end: RayEnd,
    /// How many of the order's longest jumps are drawn over the curve.
    pub jumps: usize,
    /// The rays.
    pub rays: bool,
    /// Where rays end: a disc at a surface, a ring where nothing was hit, a cross at an occluder.
    pub ends: bool,
    /// Heads at the ends of the rays, if rays are shown.
    pub arrows: bool,
    /// The path of the selected ray through all bounces; that of the middle one while none is selected.
    pub path: bool,
    /// The paths of its whole group with it.
    pub path_group: bool,
    /// Boxes of the hierarchy that were visited.
    pub visits: VisitChoice,
    /// How far below the root they are at most.
    pub visit_levels: u32,
    /// Touched cells of the length table as boxes.
    pub cells: bool,
    /// How many of them at most, those of most rays first.
    pub cell_count: usize,
    /// Capsules.
    pub capsules: bool,
    /// Which of them.
    pub capsule_choice: CapsuleChoice,
    /// How many of them at most.
    pub capsule_count: usize,
    /// Opacity of cells, 0 to 1, by which capsules are drawn, too: nearly clear but at their outlines.
    pub capsule_opacity: f32,
    /// Most rays that are shown.
    pub detail: usize,
    /// Where in the order the rays shown end, 0 to 1.
    pub until: f32,
    /// How much of the order before that is shown, 0 to 1.
    pub window: f32,
    /// Whether `until` moves by itself.
    #[serde(skip)]
    pub is_playing: bool,
    /// What colours stand for.
    pub colour_by: ColourBy,
    /// Whether that is the mean over rays that end near each other.
    pub near_mean: bool,
    /// The colours.
    pub map: ColourMap,
    /// Percentiles of the values at the ends of the colours.
    pub percentiles: (f32, f32),
    /// Values at the ends of the colours, in place of those percentiles.
    pub range: Option<(f32, f32)>,
    /// Width of lines, points.
    pub line_width: f32,
    /// Opacity of what surfaces hide.
    pub hidden_opacity: f32,
    /// The camera of a recording that was not shown yet.
    pub stand_point: StandPoint,
    /// What dragging does.
    pub navigation: Navigation,
}

/// Rays that are shown unless told otherwise: more of them are a ball in which no order can be seen.
const DETAIL: usize = 1200;

impl SpaceOptions {
    /// Whether rays are shown, by themselves or by their curve or ends.
    pub fn shows_rays(&self) -> bool {
        self.curve || self.rays || self.ends
    }
}

impl Default for SpaceOptions {
    fn default() -> Self {
        Self {
            mesh: MeshMode::default(),
            ghost_opacity: 0.25,
            clip_axis: Axis::default(),
            clip_at: 1.0,
            clip_keeps: Side::default(),
            curve: true,
            curve_end: RayEnd::default(),
            jumps: 200,
            rays: false,
            ends: false,
            arrows: false,
            path: false,
            path_group: false,
            visits: VisitChoice::default(),
            visit_levels: 32,
            cells: false,
            cell_count: 400,
            capsules: false,
            capsule_choice: CapsuleChoice::default(),
            capsule_count: 12,
            capsule_opacity: 0.16,
            detail: DETAIL,
            until: 1.0,
            window: 1.0,
            is_playing: false,
            colour_by: ColourBy::default(),
            near_mean: false,
            map: ColourMap::Turbo,
            percentiles: (2.0, 98.0),
            range: None,
            line_width: 1.5,
            hidden_opacity: 0.12,
            stand_point: StandPoint::default(),
            navigation: Navigation::default(),
        }
    }
}
