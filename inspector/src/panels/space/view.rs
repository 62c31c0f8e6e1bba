//! A view into space: what it shows, from where, and the picture that comes of it.

use std::collections::BTreeSet;
use std::sync::atomic::{AtomicU64, Ordering};

use formats::manifest::QueueId;
use formats::metrics::capsule::Segment;
use formats::ray::Kind;
use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::layers::{Layers, RayValues};
use super::meshes::{MeshForm, Meshes};
use super::options::{MeshMode, Side, SpaceOptions, StandPoint, VisitChoice};
use crate::colour_map::ColourMap;
use crate::model::colour_by::ColourBy;
use crate::model::{Absent, Context, Recording};
use crate::output::{count, counted, ordinal};
use crate::panels::data::Data;
use crate::render::camera::Camera;
use crate::render::gpu::errors::Refusal;
use crate::render::picture::{Cut, Layer, Paint, SpacePicture, Stage};
use crate::render::range::ValueRange;
use crate::theme::Theme;

/// What all views of a window are drawn on and with.
#[derive(Clone, Debug)]
pub struct ViewSetup {
    /// Format of the window.
    pub format: wgpu::TextureFormat,
    /// The surfaces that they show.
    pub meshes: Meshes,
}

impl From<wgpu::TextureFormat> for ViewSetup {
    fn from(format: wgpu::TextureFormat) -> Self {
        Self { format, meshes: Meshes::default() }
    }
}

/// A view into space.
pub struct SpaceView {
    pub(super) view: u64,
    pub(super) format: wgpu::TextureFormat,
    /// What is shown, and how.
    pub options: SpaceOptions,
    /// Where it is seen from; from the options' stand point if `None`.
    pub(crate) camera: Option<Camera>,
    /// The recording that the camera stands in; any if `None`.
    stands_in: Option<usize>,
    meshes: Meshes,
    /// Why the last picture lacks surfaces.
    pub(super) mesh_problem: Option<Absent>,
    pub(super) layers: Layers,
    /// The range of the colours, and what it is of: the same for all orders of a queue.
    locked: Option<(Locked, ValueRange)>,
    /// The opening of the recording that was last drawn.
    drawn: Option<u64>,
    /// What the GPU could not draw.
    pub(super) refusal: Refusal,
}

/// What a range of colours is of: content of a scene, queue, what colours stand for, and percentiles.
type Locked = ([u8; 32], QueueId, ColourBy, (f32, f32));

/// Of logarithms of ratios: from a quarter to four times, the same for all orders, no change in the middle.
pub(in crate::panels) const RATIOS: ValueRange = ValueRange { low: -2.0, high: 2.0 };

/// What sessions keep of a view.
#[derive(Default, Deserialize, Serialize)]
pub(crate) struct SpaceState {
    options: SpaceOptions,
    camera: Option<Camera>,
}

impl SpaceView {
    /// On this setup.
    pub fn new(setup: &ViewSetup) -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        Self {
            view: NEXT.fetch_add(1, Ordering::Relaxed),
            format: setup.format,
            options: SpaceOptions::default(),
            camera: None,
            stands_in: None,
            meshes: setup.meshes.clone(),
            mesh_problem: None,
            layers: Layers::default(),
            locked: None,
            drawn: None,
            refusal: Refusal::default(),
        }
    }

    /// The camera, that of the options if the recording is another one.
    pub(super) fn camera_in(&mut self, at: usize, recording: &Recording) -> Camera {
        let stands_here = self.stands_in.is_none_or(|known| known == at);
        let camera = self.camera.filter(|_| stands_here);
        let path = self.layers.paths().and_then(|path| bounds(path.iter().map(|ray| ray.segment)));
        let is_awaited = self.options.stand_point == StandPoint::Path && path.is_none();
        let first = || {
            let mut camera = stand(self.options.stand_point, recording);
            if let Some((low, high)) = path.filter(|_| self.options.stand_point == StandPoint::Path) {
                camera.frame(low, high);
            }
            camera
        };
        let camera = camera.unwrap_or_else(first);
        if !is_awaited {
            self.place(at, camera);
        }
        camera
    }

    /// Puts the camera somewhere in a recording.
    pub(super) fn place(&mut self, at: usize, camera: Camera) {
        (self.camera, self.stands_in) = (Some(camera), Some(at));
    }

    /// Looks from there, in any recording.
    pub(crate) fn look_from(&mut self, camera: Option<Camera>) {
        (self.camera, self.stands_in) = (camera, None);
    }

    /// Shows as another view does, from the same place and in the same range of colours.
    pub(crate) fn follow(&mut self, other: &Self) {
        self.options.clone_from(&other.options);
        self.locked = other.locked;
        self.look_from(other.camera);
    }

    /// What is kept of it.
    pub(crate) fn kept(&self) -> SpaceState {
        SpaceState { options: self.options.clone(), camera: self.camera }
    }

    pub(crate) fn set_state(&mut self, state: SpaceState) {
        self.options = state.options;
        self.look_from(state.camera);
    }

    /// Colours rays by these numbers, or by what the options say.
    pub(crate) fn colour_by(&mut self, values: Option<RayValues>) {
        self.layers.ray_values = values;
    }

    /// The rays shown, with the numbers that they are coloured by.
    pub(crate) fn data(&self, context: &mut Context) -> Result<Data, String> {
        let order = context.order()?;
        let places: Vec<usize> = self.layers.shown_places(&self.options, order.len()).collect();
        let numbers = context.numbers(order.clone()).ok_or("no recording is open")?;
        let colour_by = self.options.colour_by;
        let values = colour_by.values(&numbers, places.iter().copied());
        let name = colour_by.name();
        let header =
            ["place", "ray", "path", &*name, "origin_x", "origin_y", "origin_z", "end_x", "end_y", "end_z"];
        let rows = places.into_iter().zip(values).map(move |(place, value)| {
            let ray = order.places.ray(place);
            let segment = order.queue.segment(ray);
            let mut row = vec![place.to_string(), ray.to_string(), order.queue.path_ids[ray].to_string()];
            row.push(if value.is_nan() { String::new() } else { value.to_string() });
            row.extend(segment.origin.iter().chain(&segment.end).map(f64::to_string));
            row
        });
        Ok(Data::new(&header, rows))
    }

    /// The scene's surfaces, as the options show them.
    fn surfaces(&mut self, theme: Theme, context: &Context) -> Option<Layer> {
        self.mesh_problem = None;
        // Marks that give each place its value paint surfaces themselves.
        let is_painted = self.options.ends && self.options.near_mean;
        let plain = theme.mesh();
        let base = if is_painted { Paint::Plain(plain) } else { Paint::Base { plain, faded: theme.faded() } };
        let (form, stage, opacity, paint) = match self.options.mesh {
            MeshMode::Hidden => return None,
            MeshMode::Solid => (MeshForm::Surfaces, Stage::Solid, 1.0, base),
            MeshMode::Ghost => (MeshForm::Surfaces, Stage::Ghost, self.options.ghost_opacity, base),
            MeshMode::Wire => {
                (MeshForm::Edges, Stage::Wire, self.options.ghost_opacity, Paint::Plain(theme.edges()))
            }
        };
        let mesh = self.meshes.of(context.recording()?, form, context.waker());
        let mesh = mesh.map_err(|absent| self.mesh_problem = Some(absent)).ok()?;
        Some(Layer { width: WIRE_WIDTH, ..Layer::of(&mesh, stage, paint, opacity) })
    }

    /// Rays in the last picture, and all rays of the queue.
    pub fn counts(&self) -> Option<(usize, usize)> {
        self.layers.counts()
    }

    /// What the ends of the colours of rays stand for.
    pub fn range(&self) -> Option<ValueRange> {
        self.layers.range
    }

    /// What is shown of what there is, in words.
    pub(super) fn showing(&self) -> String {
        let rays = self.layers.counts().filter(|_| self.options.shows_rays());
        let rays = rays.map(|(shown, all)| match self.layers.step() {
            (0 | 1, _) => format!("{} of {} rays", count(shown as u64), count(all as u64)),
            (step, of) => format!("every {} of {} rays", ordinal(step), count(of as u64)),
        });
        let jumps =
            self.layers.jump_count().map(|jumps| format!("the {} longest jumps", count(jumps as u64)));
        let capsules = self.layers.capsules_shown().map(|(choice, shown, all)| {
            let is_instead = choice != self.options.capsule_choice;
            let why = if is_instead { ", spread over the order as no group is selected" } else { "" };
            format!("{} of {} capsules{why}", count(shown as u64), count(all as u64))
        });
        let cells = self.layers.cells();
        let cells =
            cells.map(|(_, shown, all)| format!("{} of {} cells", count(shown as u64), count(all as u64)));
        let passing = self.layers.passing.filter(|_| rays.is_some());
        let passing = passing.map(|rays| format!("{} pass the filter", count(rays as u64)));
        let paths = self.layers.paths().map(|rays| {
            let shadow = rays.iter().filter(|ray| ray.queue.kind == Kind::Shadow).count();
            let paths: BTreeSet<u32> = rays.iter().map(|ray| ray.path).collect();
            let paths = counted(paths.len() as u64, "path", "paths");
            format!("{paths} of {} rays, {shadow} of them to lights (thin)", rays.len())
        });
        let visits = self.layers.visits().map(|(visits, _)| {
            if self.options.visits == VisitChoice::Group {
                let (private, of_group) = visits.private();
                return format!("{of_group} boxes that the group enters, {private} of them by one ray alone");
            }
            let (shared, of_ray) = visits.shared();
            format!("{of_ray} boxes that the ray enters, {shared} of them with others of its group")
        });
        let is_instead = self.layers.curve_end().is_some_and(|end| end != self.options.curve_end);
        let curve =
            is_instead.then(|| "a curve through what they hit, as they start in one place".to_owned());
        let parts: Vec<String> =
            [rays, passing, curve, jumps, capsules, cells, paths, visits].into_iter().flatten().collect();
        if parts.is_empty() {
            "showing the scene alone".to_owned()
        } else {
            format!("showing {}", parts.join(", "))
        }
    }

    /// The layers, coloured in the range that the first order of the queue had.
    fn layers_in_range(&mut self, theme: Theme, context: &mut Context) -> Vec<Layer> {
        let scene =
            context.recording().map_or([0; 32], |open| open.dump.manifest().header.scene.content_hash);
        let SpaceOptions { colour_by, percentiles, .. } = self.options;
        let of: Locked = (scene, context.selection.queue, colour_by, percentiles);
        let is_free = self.options.range.is_none() && self.layers.ray_values.is_none();
        let known = self.locked.filter(|(known, _)| is_free && *known == of).map(|(_, range)| range);
        let mut options = self.options.clone();
        options.range = known.map(|range| (range.low, range.high)).or(options.range);
        options.map = self.map();
        let layers = self.layers.show(theme, &options, context);
        if !is_free || known.is_some() || self.layers.problem.is_some() {
            return layers;
        }
        let Some(range) = self.layers.range else { return layers };
        let range = if self.logarithm() == Some(2.0) { RATIOS } else { range };
        self.locked = Some((of, range));
        options.range = Some((range.low, range.high));
        self.layers.show(theme, &options, context)
    }

    /// The base, where colours stand for logarithms.
    pub(super) fn logarithm(&self) -> Option<f32> {
        match (&self.layers.ray_values, self.options.colour_by) {
            (Some(values), _) => values.logarithm,
            (None, ColourBy::Quantity(quantity)) => quantity.logarithm(),
            (None, ColourBy::Field(_)) => None,
        }
    }

    /// The colours: of ratios always those with no change in their middle.
    pub(super) fn map(&self) -> ColourMap {
        if self.logarithm() == Some(2.0) { ColourMap::BlueRed } else { self.options.map }
    }

    pub(super) fn space_picture(
        &mut self,
        theme: Theme,
        pixels: [u32; 2],
        context: &mut Context,
    ) -> Option<SpacePicture> {
        let at = context.selection.recording;
        let camera = self.camera_in(at, context.recording()?);
        let mesh = self.surfaces(theme, context);
        let cut = cut(&self.options, context.recording()?.unit().sides);
        let layers = self.layers_in_range(theme, context);
        let recording = context.recording()?;
        // The first picture of a recording is a whole one: a software GPU takes half a second for millions of
        // triangles, and would take it twice.
        let awaits = |problem: Option<&Absent>| problem == Some(&Absent::Awaited);
        let is_awaited = awaits(self.mesh_problem.as_ref()) || awaits(self.layers.problem.as_ref());
        if is_awaited && self.drawn != Some(recording.opening) {
            return None;
        }
        self.drawn = Some(recording.opening);
        Some(SpacePicture {
            camera,
            pixels,
            background: theme.background(),
            cut,
            room: room(recording.unit().sides, stand(StandPoint::Recorded, recording).eye(), camera.eye()),
            layers: mesh.into_iter().chain(layers).collect(),
        })
    }
}

/// Width of the edges of surfaces, pixels.
const WIRE_WIDTH: f32 = 1.0;

/// The clipping plane in unit space.
pub fn cut(options: &SpaceOptions, sides: [f32; 3]) -> Cut {
    let axis = options.clip_axis as usize;
    let direction = match options.clip_keeps {
        Side::Below if options.clip_at >= 1.0 => return Cut::NONE,
        Side::Above if options.clip_at <= 0.0 => return Cut::NONE,
        Side::Below => 1.0,
        Side::Above => -1.0,
    };
    let mut normal = [0.0; 3];
    normal[axis] = direction;
    Cut { normal, offset: direction * options.clip_at * sides[axis] }
}

/// The sides of a scene that was recorded from inside, where it is seen from outside: one looks into it.
pub fn room(sides: [f32; 3], recorded: Vec3, eye: Vec3) -> Option<[f32; 3]> {
    let is_inside = |eye: Vec3| (0..3).all(|axis| (0.0..=sides[axis]).contains(&eye[axis]));
    (is_inside(recorded) && !is_inside(eye)).then_some(sides)
}

/// The lowest and the highest corner of the box around some rays; `None` for none.
pub(super) fn bounds(segments: impl Iterator<Item = Segment>) -> Option<(Vec3, Vec3)> {
    let points = segments.flat_map(|segment| {
        [segment.origin, segment.end].map(|point| Vec3::from(point.map(|along| along as f32)))
    });
    points.map(|point| (point, point)).reduce(|(low, high), (from, to)| (low.min(from), high.max(to)))
}

/// The camera of a stand point.
pub(super) fn stand(point: StandPoint, recording: &Recording) -> Camera {
    let unit = recording.unit();
    match point {
        StandPoint::Recorded => Camera::recorded(&recording.dump.manifest().header.camera, &unit),
        StandPoint::Overview | StandPoint::Path => Camera::overview(unit.sides),
    }
}
