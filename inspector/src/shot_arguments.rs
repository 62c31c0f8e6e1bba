//! The command line of `inspector shot`.

use std::ops::RangeInclusive;
use std::path::PathBuf;

use clap::builder::PossibleValuesParser;
use clap::{Args, ValueEnum, value_parser};
use formats::key::{KEY_BITS_MIN, LAYOUT_BITS};
use formats::ray::Kind;

use crate::analysis::GroupWidth;
use crate::cli::RayKind;
use crate::model::value::ColourBy;
use crate::model::what_if::Estimate;
use crate::panels::space::options::{MeshMode, StandPoint};
use crate::render::camera::Camera;
use crate::shot::{self, SceneChoice, Shot, VIEWS, WhatIf};

/// Bits that a key can have.
const KEY_BITS: RangeInclusive<i64> = KEY_BITS_MIN as i64..=LAYOUT_BITS as i64;

/// A picture of the window.
#[derive(Debug, Args)]
pub(crate) struct ShotArguments {
    /// The recordings: folders NAME.raydump, or NAME.raydump.partial.
    #[arg(value_name = "X.raydump", required_unless_present = "session")]
    dumps: Vec<PathBuf>,
    /// Shows what a session of the window says (File > Save session); other options change it.
    #[arg(long, value_name = "FILE")]
    session: Option<PathBuf>,
    /// Which of several recordings is looked at, counted from 0 [default: the last].
    #[arg(long, value_name = "N")]
    recording: Option<usize>,
    /// The file, a PNG.
    #[arg(long, value_name = "P.png")]
    out: PathBuf,
    /// What is drawn.
    #[arg(long, default_value = "window", value_parser = PossibleValuesParser::new(VIEWS.map(|(view, _)| view)))]
    view: String,
    /// The pass [default: the last that was kept].
    #[arg(long)]
    pass: Option<u32>,
    /// The bounce; 0 is the camera rays [default: 1].
    #[arg(long)]
    bounce: Option<u32>,
    /// The kind of rays [default: closest].
    #[arg(long, value_enum)]
    kind: Option<RayKind>,
    /// The order: a method, or unsorted [default: unsorted].
    #[arg(long)]
    method: Option<String>,
    /// Rays in a group [default: 64].
    #[arg(long, value_enum)]
    group_width: Option<GroupWidth>,
    /// Selects a group of the order, counted from 0.
    #[arg(long)]
    group: Option<usize>,
    /// Selects a ray by its canonical index.
    #[arg(long)]
    ray: Option<usize>,
    /// Selects a cell of the length table.
    #[arg(long)]
    cell: Option<u32>,
    /// Shows only the rays that meet a condition, such as 'hit && length < 0.1'.
    #[arg(long, value_name = "EXPR")]
    filter: Option<String>,
    /// Sorts the rays by another layout, such as '(ox oy oz)*4 (u v)*10', or by the method of this name, and
    /// looks at that order.
    #[arg(long, value_name = "LAYOUT")]
    what_if: Option<String>,
    /// Bits of the keys of --what-if [default: those of the recording].
    #[arg(long, value_name = "BITS", requires = "what_if", value_parser = value_parser!(u32).range(KEY_BITS))]
    what_if_bits: Option<u32>,
    /// Where --what-if has the length of a ray from [default: as the method has it, or one length].
    #[arg(long, value_name = "SOURCE", requires = "what_if", value_enum)]
    what_if_estimate: Option<Estimate>,
    /// The one length of all rays for --what-if, unit lengths [default: that of the recording].
    #[arg(long, value_name = "LENGTH", requires = "what_if", value_parser = parse_length)]
    what_if_length: Option<f32>,
    /// What rays in space are coloured by: place, group, key, key:ox and the like, length, ...
    #[arg(long, value_parser = |name: &str| ColourBy::try_from(name.to_owned()))]
    colour_by: Option<ColourBy>,
    /// Where the camera stands: recorded, overview, or its numbers as View > Copy gives them: target x, y,
    /// z, yaw, pitch, distance and, if wanted, the field of view (unit space, radians).
    #[arg(long, value_parser = parse_camera, allow_hyphen_values = true)]
    camera: Option<CameraChoice>,
    /// Changes one setting of what is drawn, as `Show command` in the window's panels prints them; of a
    /// window's panel as PANEL.NAME=VALUE. A name that does not exist lists all.
    #[arg(long = "set", value_name = "NAME=VALUE")]
    settings: Vec<String>,
    /// Most rays in space.
    #[arg(long, value_name = "N")]
    detail: Option<usize>,
    /// Most capsules in space.
    #[arg(long, value_name = "N")]
    capsules: Option<usize>,
    /// How the scene's surfaces are drawn.
    #[arg(long, value_enum)]
    mesh: Option<MeshChoice>,
    /// Where in the order the rays in space end, 0 to 1.
    #[arg(long)]
    until: Option<f32>,
    /// How much of the order before that is shown, 0 to 1.
    #[arg(long)]
    part: Option<f32>,
    /// Height above which surfaces are cut away, 0 to 1 of the scene's.
    #[arg(long)]
    cut: Option<f32>,
    /// Pixels across and down.
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = parse_size)]
    size: [u32; 2],
    /// Pixels to a point: 2 for screens of high resolution.
    #[arg(long, default_value_t = 1.0, value_parser = parse_scale)]
    scale: f32,
    /// Dark on light.
    #[arg(long)]
    light: bool,
    /// Frames whose times are taken, while the slider goes along the order.
    #[arg(long, default_value_t = 1)]
    frames: usize,
    /// Print one JSON object with times and memory.
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, Debug)]
enum CameraChoice {
    Stands(StandPoint),
    At(Camera),
}

fn parse_camera(text: &str) -> Result<CameraChoice, String> {
    match text {
        "recorded" => Ok(CameraChoice::Stands(StandPoint::Recorded)),
        "overview" => Ok(CameraChoice::Stands(StandPoint::Overview)),
        numbers => {
            numbers.parse().map(CameraChoice::At).map_err(|error| format!("recorded, overview, or {error}"))
        }
    }
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum MeshChoice {
    Solid,
    Ghost,
    Hidden,
    Wire,
}

/// The largest side of a picture that every adapter can draw.
const LARGEST_SIDE: u32 = 8192;

fn parse_length(text: &str) -> Result<f32, String> {
    let length = text.parse::<f32>().ok().filter(|length| length.is_finite() && *length >= 0.0);
    length.ok_or_else(|| "expected unit lengths, 0 or more, such as 0.25".to_owned())
}

fn parse_size(text: &str) -> Result<[u32; 2], String> {
    let sides =
        text.split_once('x').and_then(|(width, height)| Some([width.parse().ok()?, height.parse().ok()?]));
    match sides {
        Some(sides) if sides.iter().all(|side| (64..=LARGEST_SIDE).contains(side)) => Ok(sides),
        _ => Err(format!("expected WIDTHxHEIGHT, 64 to {LARGEST_SIDE} each, such as 1280x720")),
    }
}

impl ShotArguments {
    pub(crate) fn run(&self) -> anyhow::Result<()> {
        let kind = self.kind.map(|kind| match kind {
            RayKind::Closest => Kind::Closest,
            RayKind::Shadow => Kind::Shadow,
        });
        let scene = SceneChoice {
            colour_by: self.colour_by,
            stand_point: match self.camera {
                Some(CameraChoice::Stands(point)) => Some(point),
                _ => None,
            },
            camera: match self.camera {
                Some(CameraChoice::At(camera)) => Some(camera),
                _ => None,
            },
            detail: self.detail,
            capsules: self.capsules,
            mesh: self.mesh.map(|mesh| match mesh {
                MeshChoice::Solid => MeshMode::Solid,
                MeshChoice::Ghost => MeshMode::Ghost,
                MeshChoice::Hidden => MeshMode::Hidden,
                MeshChoice::Wire => MeshMode::Wire,
            }),
            until: self.until,
            part: self.part,
            cut: self.cut,
        };
        let shot = Shot {
            view: self.view.clone(),
            session: self.session.clone(),
            recording: self.recording,
            settings: self.settings.clone(),
            pass: self.pass,
            bounce: self.bounce,
            kind,
            method: self.method.clone(),
            group_width: self.group_width,
            group: self.group,
            ray: self.ray,
            cell: self.cell,
            filter: self.filter.clone(),
            what_if: self.what_if.clone().map(|order| WhatIf {
                order,
                key_bits: self.what_if_bits,
                estimate: self.what_if_estimate,
                length: self.what_if_length,
            }),
            scene,
            size: self.size,
            scale: self.scale,
            is_light: self.light,
            frames: self.frames,
        };
        shot::run(&self.dumps, &shot, &self.out, self.json)
    }
}

fn parse_scale(text: &str) -> Result<f32, String> {
    let scale = text.parse().ok().filter(|scale| (0.5..=4.0).contains(scale));
    scale.ok_or_else(|| "expected 0.5 to 4".to_owned())
}
