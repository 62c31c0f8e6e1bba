//! A view into space: what it shows, from where, and the frame that comes of it.

use std::sync::atomic::{AtomicU64, Ordering};

use serde::{Deserialize, Serialize};

use super::layers::{Layers, RayValues};
use super::meshes::{MeshForm, Meshes};
use super::options::{MeshMode, Options, Side, StandPoint};
use crate::model::{Absent, Context, Recording};
use crate::output::count;
use crate::panels::data::Data;
use crate::render::camera::Camera;
use crate::render::frame::{Cut, Frame, Layer, Paint, Stage};
use crate::render::geometry::Geometry;
use crate::render::gpu::errors::Refusal;
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
    pub options: Options,
    pub(super) camera: Option<(usize, Camera)>,
    /// Where the camera goes next, in any recording.
    placed: Option<Camera>,
    meshes: Meshes,
    /// Why the last picture lacks surfaces.
    pub(super) mesh_problem: Option<Absent>,
    pub(super) layers: Layers,
    /// The opening of the recording that was last drawn.
    drawn: Option<u64>,
    /// What the GPU could not draw.
    pub(super) refusal: Refusal,
}

/// What sessions keep of a view.
#[derive(Deserialize, Serialize)]
pub(crate) struct SpaceState {
    options: Options,
    camera: Option<Camera>,
}

impl SpaceView {
    /// On this setup.
    pub fn new(setup: &ViewSetup) -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        Self {
            view: NEXT.fetch_add(1, Ordering::Relaxed),
            format: setup.format,
            options: Options::default(),
            camera: None,
            placed: None,
            meshes: setup.meshes.clone(),
            mesh_problem: None,
            layers: Layers::default(),
            drawn: None,
            refusal: Refusal::default(),
        }
    }

    /// The camera, that of the options if the recording is another one.
    pub(super) fn camera(&mut self, at: usize, recording: &Recording) -> Camera {
        match self.camera {
            Some((known, camera)) if known == at && self.placed.is_none() => camera,
            _ => {
                let placed = self.placed.take();
                let camera = placed.unwrap_or_else(|| stand(self.options.stand_point, recording));
                self.camera = Some((at, camera));
                camera
            }
        }
    }

    /// What is kept of it.
    pub(crate) fn state(&self) -> serde_json::Value {
        serde_json::to_value(self.kept()).unwrap_or_default()
    }

    /// The same, to be kept with more.
    pub(crate) fn kept(&self) -> SpaceState {
        let camera = self.placed.or(self.camera.map(|(_, camera)| camera));
        SpaceState { options: self.options.clone(), camera }
    }

    /// Shows what was kept.
    pub(crate) fn set_state(&mut self, state: SpaceState) {
        self.options = state.options;
        self.placed = state.camera;
    }

    /// Puts the camera somewhere, in any recording.
    pub fn place(&mut self, camera: Camera) {
        self.placed = Some(camera);
    }

    /// Colours rays by these numbers, or by what the options say.
    pub(crate) fn colour_by(&mut self, values: Option<RayValues>) {
        self.layers.colour_by(values);
    }

    /// The rays shown, with the numbers that they are coloured by.
    pub(crate) fn data(&self, context: &mut Context) -> Result<Data, String> {
        let order = context.order().map_err(|reason| reason.to_string())?;
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

    /// The surfaces of the selected recording, or their edges.
    fn mesh(&mut self, context: &Context, form: MeshForm) -> Option<Geometry> {
        match self.meshes.of(context.recording()?, form, context.waker()) {
            Ok(mesh) => {
                self.mesh_problem = None;
                Some(mesh)
            }
            Err(absent) => {
                self.mesh_problem = Some(absent);
                None
            }
        }
    }

    /// The scene's surfaces, as the options show them.
    fn surfaces(&mut self, theme: Theme, context: &Context) -> Option<Layer> {
        let (form, stage, opacity, colour) = match self.options.mesh {
            MeshMode::Hidden => {
                self.mesh_problem = None;
                return None;
            }
            MeshMode::Solid => (MeshForm::Surfaces, Stage::Solid, 1.0, theme.mesh()),
            MeshMode::Ghost => (MeshForm::Surfaces, Stage::Ghost, self.options.ghost_opacity, theme.mesh()),
            MeshMode::Wire => (MeshForm::Edges, Stage::Wire, self.options.ghost_opacity, theme.edges()),
        };
        let geometry = self.mesh(context, form)?;
        let (part, paint) = (None, Paint::Plain(colour));
        Some(Layer { geometry, part, stage, paint, opacity, hidden_opacity: 0.0, width: WIRE_WIDTH })
    }

    /// Rays in the last picture, and all rays of the queue.
    pub fn counts(&self) -> Option<(usize, usize)> {
        self.layers.counts()
    }

    /// Where the camera stands, if it stands anywhere yet.
    pub(crate) fn pose(&self) -> Option<(usize, Camera)> {
        self.camera
    }

    /// Puts the camera where that of another view stands.
    pub(crate) fn set_pose(&mut self, pose: Option<(usize, Camera)>) {
        self.camera = pose;
    }

    /// What is shown of what there is, in words.
    pub(super) fn showing(&self) -> String {
        let of = |(shown, all): (usize, usize), what| {
            format!("{} of {} {what}", count(shown as u64), count(all as u64))
        };
        let rays =
            self.layers.counts().filter(|_| self.options.shows_rays()).map(|counts| of(counts, "rays"));
        let capsules = self.layers.capsule_counts().map(|counts| of(counts, "capsules"));
        let cells = self.layers.cells().map(|(_, shown)| format!("{} cells", count(shown as u64)));
        let passing = self.layers.passing().filter(|_| rays.is_some());
        let passing = passing.map(|rays| format!("{} pass the filter", count(rays as u64)));
        let parts: Vec<String> = rays.into_iter().chain(passing).chain(capsules).chain(cells).collect();
        if parts.is_empty() {
            "showing the scene alone".to_owned()
        } else {
            format!("showing {}", parts.join(", "))
        }
    }

    pub(super) fn frame(&mut self, theme: Theme, pixels: [u32; 2], context: &mut Context) -> Option<Frame> {
        let at = context.selection.recording;
        let camera = self.camera(at, context.recording()?);
        let mesh = self.surfaces(theme, context);
        let cut = cut(&self.options, context.recording()?.unit().sides);
        let layers = self.layers.show(theme, &self.options, context);
        let recording = context.recording()?;
        // The first picture of a recording is a whole one: a software GPU takes half a second for millions of
        // triangles, and would take it twice.
        let awaits = |problem: Option<&Absent>| problem == Some(&Absent::Awaited);
        let is_awaited = awaits(self.mesh_problem.as_ref()) || awaits(self.layers.problem());
        if is_awaited && self.drawn != Some(recording.opening) {
            return None;
        }
        self.drawn = Some(recording.opening);
        Some(Frame {
            camera,
            pixels,
            background: theme.background(),
            cut,
            layers: mesh.into_iter().chain(layers).collect(),
        })
    }
}

/// Width of the edges of surfaces, pixels.
const WIRE_WIDTH: f32 = 1.0;

/// The clipping plane in unit space.
pub fn cut(options: &Options, sides: [f32; 3]) -> Cut {
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

/// The camera of a stand point.
pub(super) fn stand(point: StandPoint, recording: &Recording) -> Camera {
    let unit = recording.unit();
    match point {
        StandPoint::Recorded => Camera::recorded(&recording.dump.manifest().header.camera, &unit),
        StandPoint::Overview => Camera::overview(unit.sides),
    }
}
