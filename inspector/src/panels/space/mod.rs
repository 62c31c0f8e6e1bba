//! The scene in space, with rays, the curve of their order, capsules and table cells: what panels show it with.
//!
//! - [`options`]: what is shown, and how
//! - [`layers`]: from a selection to vertices, made anew only when it changes; `shown`: of which places
//! - `controls`: the row above the picture, the slider and the colour bar below
//! - `input`: pointer and keys

mod controls;
mod input;
pub mod layers;
pub mod options;
mod shown;

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use egui::Sense;
use formats::manifest::{Place, SceneArray};
use formats::reader::{Dump, Mapped};
use formats::unit_space::UnitSpace;

use self::layers::Layers;
use self::options::{MeshMode, Options, StandPoint};
use super::filter_box;
use crate::model::background::Background;
use crate::model::{Absent, Context, Recording};
use crate::output::count;
use crate::render::camera::Camera;
use crate::render::frame::{Cut, Frame, Layer, Paint, Stage};
use crate::render::geometry::{Geometry, mesh};
use crate::render::gpu::FrameCallback;
use crate::theme::Theme;

/// A view into space.
pub struct SpaceView {
    view: u64,
    format: wgpu::TextureFormat,
    /// What is shown, and how.
    pub options: Options,
    camera: Option<(usize, Camera)>,
    meshes: Background<usize, Result<Geometry, String>>,
    /// Why the last picture lacks surfaces.
    mesh_problem: Option<Absent>,
    layers: Layers,
}

impl SpaceView {
    /// For a window of this format.
    pub fn new(format: wgpu::TextureFormat) -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        Self {
            view: NEXT.fetch_add(1, Ordering::Relaxed),
            format,
            options: Options::default(),
            camera: None,
            meshes: Background::default(),
            mesh_problem: None,
            layers: Layers::default(),
        }
    }

    /// The camera, that of the options if the recording is another one.
    fn camera(&mut self, at: usize, recording: &Recording) -> Camera {
        match self.camera {
            Some((known, camera)) if known == at => camera,
            _ => {
                let camera = stand(self.options.stand_point, recording);
                self.camera = Some((at, camera));
                camera
            }
        }
    }

    /// The surfaces of the recording that is looked at.
    fn mesh(&mut self, context: &Context) -> Option<Geometry> {
        let (at, recording) = (context.selection.recording, context.recording()?);
        let (dump, unit) = (recording.dump.clone(), recording.unit());
        let found = self.meshes.of(at, context.waker(), move || read_mesh(&dump, &unit));
        let (mesh, problem) = match found {
            None => (None, Some(Absent::Awaited)),
            Some(Err(reason)) => (None, Some(reason.into())),
            Some(Ok(mesh)) => (Some(mesh.clone()), None),
        };
        self.mesh_problem = problem;
        mesh
    }

    fn frame(&mut self, theme: Theme, pixels: [u32; 2], context: &mut Context) -> Option<Frame> {
        let at = context.selection.recording;
        let camera = self.camera(at, context.recording()?);
        let mesh = match self.options.mesh {
            MeshMode::Hidden => None,
            MeshMode::Solid | MeshMode::Ghost => self.mesh(context),
        };
        let is_ghost = self.options.mesh == MeshMode::Ghost;
        let mesh = mesh.map(|geometry| Layer {
            geometry,
            part: None,
            stage: if is_ghost { Stage::Ghost } else { Stage::Solid },
            paint: Paint::Plain(theme.mesh()),
            opacity: if is_ghost { self.options.ghost_opacity } else { 1.0 },
            hidden_opacity: 0.0,
            width: 0.0,
        });
        let sides = context.recording()?.unit().sides;
        let cut = match self.options.cut {
            part if part >= 1.0 => Cut::NONE,
            part => Cut { normal: [0.0, 1.0, 0.0], offset: part * sides[1] },
        };
        let layers = self.layers.show(theme, &self.options, context);
        Some(Frame {
            camera,
            pixels,
            background: theme.background(),
            cut,
            layers: mesh.into_iter().chain(layers).collect(),
        })
    }
}

/// The camera of a stand point.
fn stand(point: StandPoint, recording: &Recording) -> Camera {
    let unit = recording.unit();
    match point {
        StandPoint::Recorded => Camera::recorded(&recording.dump.manifest().header.camera, &unit),
        StandPoint::Overview => Camera::overview(unit.sides),
    }
}

fn read_mesh(dump: &Dump, unit: &UnitSpace) -> Result<Geometry, String> {
    let text = |error: formats::reader::ReadError| error.to_string();
    let positions: Mapped<[f32; 3]> = dump.array(&Place::Scene(SceneArray::Positions)).map_err(text)?;
    let triangles: Mapped<[u32; 3]> = dump.array(&Place::Scene(SceneArray::Triangles)).map_err(text)?;
    Ok(mesh(unit, &positions, &triangles).into())
}

impl SpaceView {
    /// What is shown, to be changed.
    pub(super) fn controls(&mut self, ui: &mut egui::Ui, context: &mut Context) {
        controls::above(ui, self, context);
    }

    /// The picture with the slider and the colour bar below it, in all the room that there is.
    pub(super) fn picture_and_slider(&mut self, ui: &mut egui::Ui, context: &mut Context) {
        let below = controls::height_below(ui);
        self.picture(ui, context, ui.available_size() - egui::vec2(0.0, below));
        controls::below(ui, self);
    }

    /// The picture alone. Pointer and keys move the camera and choose rays.
    pub(super) fn picture(&mut self, ui: &mut egui::Ui, context: &mut Context, size: egui::Vec2) {
        let (rect, response) =
            ui.allocate_exact_size(size.max(egui::vec2(16.0, 16.0)), Sense::click_and_drag());
        let scale = ui.ctx().pixels_per_point();
        let pixels = [rect.width(), rect.height()].map(|side| (side * scale).round().max(1.0) as u32);
        input::take(ui, &response, self, context);
        if let Some(frame) = self.frame(Theme::of(ui.ctx()), pixels, context) {
            let callback = FrameCallback { view: self.view, format: self.format, frame: Arc::new(frame) };
            ui.painter().add(callback.shape(rect));
        }
        let text = self.showing();
        let filter = filter_box::problem(context).map(|error| Absent::from(format!("filter: {error}")));
        let problem = self.layers.problem().or(self.mesh_problem.as_ref()).or(filter.as_ref());
        controls::overlay(ui, rect, &text, problem);
    }

    /// The slider along the order and the colour bar.
    pub(super) fn slider(&mut self, ui: &mut egui::Ui) {
        controls::below(ui, self);
    }

    /// Height of the slider and the colour bar.
    pub(super) fn slider_height(ui: &egui::Ui) -> f32 {
        controls::height_below(ui)
    }

    /// Rays in the last picture, and all rays of the queue.
    pub fn counts(&self) -> Option<(usize, usize)> {
        self.layers.counts()
    }

    /// Where the camera stands, if it stands anywhere yet.
    pub(super) fn pose(&self) -> Option<(usize, Camera)> {
        self.camera
    }

    /// Puts the camera where that of another view stands.
    pub(super) fn set_pose(&mut self, pose: Option<(usize, Camera)>) {
        self.camera = pose;
    }

    /// What is shown of what there is, in words.
    fn showing(&self) -> String {
        let of = |(shown, all): (usize, usize), what| {
            format!("{} of {} {what}", count(shown as u64), count(all as u64))
        };
        let rays =
            self.layers.counts().filter(|_| self.options.shows_rays()).map(|counts| of(counts, "rays"));
        let capsules = self.layers.capsule_counts().map(|counts| of(counts, "capsules"));
        let passing = self.layers.passing().filter(|_| rays.is_some());
        let passing = passing.map(|rays| format!("{} pass the filter", count(rays as u64)));
        let parts: Vec<String> = rays.into_iter().chain(passing).chain(capsules).collect();
        if parts.is_empty() {
            "showing the scene alone".to_owned()
        } else {
            format!("showing {}", parts.join(", "))
        }
    }
}
