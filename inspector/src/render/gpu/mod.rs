//! Pictures in space on a GPU: drawn with depth and smooth edges into a texture, then copied into the
//! window by a paint callback of egui. A picture equal to the last one is only copied.
//!
//! - [`shaders`]: the modules, composed of the WGSL files
//! - `pipelines`: one for each way of drawing, made when it is first used
//! - `uploads`: vertices that the GPU has already
//! - `target`: the picture of one view
//! - [`errors`]: what a GPU does not do

pub mod errors;
mod pipelines;
pub mod shaders;
mod target;
mod uploads;

use std::collections::BTreeMap;
use std::sync::Arc;

use egui_wgpu::{CallbackResources, CallbackTrait, ScreenDescriptor};

use serde::Serialize;

use self::errors::Refusal;
use self::pipelines::{Drawing, Lines, Pipelines, Seen};
use self::target::Target;
use self::uploads::Uploads;
use super::geometry::Shape;
use super::picture::{Layer, LayerUniform, SpacePicture, Stage};
use crate::model::background::Waker;

/// Layers that a picture may have, each drawn up to twice.
const DRAWS_MAX: usize = 32;
/// Bytes from one layer's uniform to the next: what every adapter allows.
const UNIFORM_STRIDE: u64 = 256;

/// A picture as a paint callback.
pub struct PictureCallback {
    /// Which view it is of; each keeps its picture.
    pub view: u64,
    /// Format of the window.
    pub format: wgpu::TextureFormat,
    /// What is seen.
    pub picture: Arc<SpacePicture>,
    /// Where the view reads what of it could not be drawn, and who draws the window again then.
    pub refusal: (Refusal, Waker),
}

impl PictureCallback {
    /// The shape that paints it into a rectangle of the window.
    pub fn shape(self, rect: egui::Rect) -> egui::Shape {
        egui::Shape::Callback(egui_wgpu::Callback::new_paint_callback(rect, self))
    }
}

/// What is kept on the GPU between pictures.
struct Resources {
    pipelines: Pipelines,
    uploads: Uploads,
    views: BTreeMap<u64, DrawnView>,
}

struct DrawnView {
    target: Target,
    uniforms: wgpu::Buffer,
    layers: wgpu::BindGroup,
    drawn: Option<Arc<SpacePicture>>,
    counts: DrawCounts,
}

/// What views in space last drew: each of them, when its picture last changed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct DrawCounts {
    /// Draw calls.
    pub draw_calls: u64,
    /// Vertices that were drawn, as often as they were.
    pub vertices: u64,
    /// Bytes of vertices, indices and uniforms that went to the GPU.
    pub uploaded_bytes: u64,
}

impl DrawCounts {
    /// Of all views.
    pub fn of(resources: &CallbackResources) -> Self {
        let views = resources.get::<Resources>().into_iter().flat_map(|resources| resources.views.values());
        views.fold(Self::default(), |sum, DrawnView { counts, .. }| Self {
            draw_calls: sum.draw_calls + counts.draw_calls,
            vertices: sum.vertices + counts.vertices,
            uploaded_bytes: sum.uploaded_bytes + counts.uploaded_bytes,
        })
    }
}

/// Has a window ask for what its pictures take: no OpenGL, which the recorder does without too and which it
/// takes time to look for, and buffers as large as the GPU allows.
pub fn set_up(setup: &mut egui_wgpu::WgpuSetup) {
    if let egui_wgpu::WgpuSetup::CreateNew(setup) = setup {
        setup.instance_descriptor.backends &= wgpu::Backends::PRIMARY;
        let by_itself = setup.device_descriptor.clone();
        setup.device_descriptor = Arc::new(move |adapter| {
            let mut device = by_itself(adapter);
            let (asked, offered) = (&mut device.required_limits, adapter.limits());
            asked.max_buffer_size = offered.max_buffer_size;
            asked.max_storage_buffer_binding_size = offered.max_storage_buffer_binding_size;
            device
        });
    }
}

/// A layer, the opacity it is drawn with, and whether only where surfaces hide it.
struct Draw<'a> {
    layer: &'a Layer,
    opacity: f32,
    is_hidden: bool,
}

impl Draw<'_> {
    fn drawing(&self) -> Drawing {
        let Layer { geometry, stage, .. } = self.layer;
        let seen = match stage {
            Stage::OnTop => Seen::OnTop,
            _ if self.is_hidden => Seen::Behind,
            _ => Seen::InFront,
        };
        match (geometry.shape(), stage) {
            (Shape::Mesh(_), Stage::Ghost) => Drawing::Ghost,
            (Shape::Mesh(_), _) => Drawing::Solid,
            (Shape::Segments(_), Stage::Wire) => Drawing::Lines(Lines::Edges, seen),
            (Shape::Segments(_), Stage::Arrows) => Drawing::Lines(Lines::Arrows, seen),
            (Shape::Segments(_), Stage::Marks) => Drawing::Lines(Lines::Marks, seen),
            (Shape::Strip(_) | Shape::Segments(_), _) => Drawing::Lines(Lines::Plain, seen),
            (Shape::Boxes(_), _) => Drawing::Boxes,
            (Shape::Capsules(_), _) => Drawing::Capsules,
        }
    }
}

impl CallbackTrait for PictureCallback {
    fn prepare(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        _screen: &ScreenDescriptor,
        encoder: &mut wgpu::CommandEncoder,
        resources: &mut CallbackResources,
    ) -> Vec<wgpu::CommandBuffer> {
        let resources = resources.entry::<Resources>().or_insert_with(|| Resources {
            pipelines: Pipelines::new(device, queue, self.format),
            uploads: Uploads::new(device),
            views: BTreeMap::new(),
        });
        let Resources { pipelines, uploads, views } = resources;
        let view =
            views.entry(self.view).or_insert_with(|| DrawnView::new(device, pipelines, self.picture.pixels));
        if view.target.pixels != self.picture.pixels {
            view.target = Target::new(device, pipelines, self.picture.pixels);
            view.drawn = None;
        }
        if view.drawn.as_ref().is_some_and(|drawn| **drawn == *self.picture) {
            return Vec::new();
        }
        let (mut uploaded, mut refused) = (0, None);
        for layer in &self.picture.layers {
            match uploads.add(device, pipelines, &layer.geometry) {
                Ok(bytes) => uploaded += bytes,
                Err(reason) => refused = Some(reason),
            }
        }
        let (refusal, waker) = &self.refusal;
        refusal.set(refused, waker);
        let draws = draws(&self.picture);
        draws.iter().for_each(|draw| pipelines.make(device, draw.drawing()));
        view.counts = view.draw(queue, encoder, (pipelines, uploads), &self.picture, &draws);
        view.counts.uploaded_bytes += uploaded;
        view.drawn = Some(self.picture.clone());
        let used = views.values().filter_map(|view| view.drawn.as_ref());
        uploads
            .keep(used.flat_map(|picture| picture.layers.iter().map(|layer| layer.geometry.id())).collect());
        Vec::new()
    }

    fn paint(
        &self,
        info: egui::PaintCallbackInfo,
        pass: &mut wgpu::RenderPass<'static>,
        resources: &CallbackResources,
    ) {
        let Some(resources) = resources.get::<Resources>() else { return };
        let Some(view) = resources.views.get(&self.view) else { return };
        let port = info.viewport_in_pixels();
        let (left, top) = (port.left_px as f32, port.top_px as f32);
        pass.set_viewport(left, top, port.width_px as f32, port.height_px as f32, 0.0, 1.0);
        pass.set_pipeline(&resources.pipelines.copy);
        pass.set_bind_group(0, &view.target.picture, &[]);
        pass.draw(0..3, 0..1);
    }
}

impl DrawnView {
    fn new(device: &wgpu::Device, pipelines: &Pipelines, pixels: [u32; 2]) -> Self {
        let uniforms = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("view::uniforms"),
            size: UNIFORM_STRIDE * DRAWS_MAX as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let layers = pipelines.layer_bindings(device, &uniforms);
        let target = Target::new(device, pipelines, pixels);
        Self { target, uniforms, layers, drawn: None, counts: DrawCounts::default() }
    }

    fn draw(
        &self,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
        (pipelines, uploads): (&Pipelines, &Uploads),
        picture: &SpacePicture,
        draws: &[Draw<'_>],
    ) -> DrawCounts {
        let mut counts = DrawCounts::default();
        let mut bytes = vec![0u8; UNIFORM_STRIDE as usize * draws.len()];
        for (draw, bytes) in draws.iter().zip(bytes.chunks_mut(UNIFORM_STRIDE as usize)) {
            let uniform = LayerUniform::of(picture, draw.layer, draw.opacity);
            bytes[..size_of::<LayerUniform>()].copy_from_slice(bytemuck::bytes_of(&uniform));
        }
        queue.write_buffer(&self.uniforms, 0, &bytes);
        counts.uploaded_bytes = bytes.len() as u64;
        let mut pass = self.target.pass(encoder, picture.background);
        for (at, draw) in draws.iter().enumerate() {
            pass.set_bind_group(0, &self.layers, &[at as u32 * UNIFORM_STRIDE as u32]);
            let (calls, vertices) = uploads.draw(&mut pass, pipelines, (draw.layer, draw.drawing()), picture);
            counts.draw_calls += calls;
            counts.vertices += vertices;
        }
        counts
    }
}

/// In which order stages are drawn, and whether only where surfaces hide them: what hides, what is hidden, what is
/// seen, what is seen through.
const DRAWN: [(Stage, bool); 12] = [
    (Stage::Solid, false),
    (Stage::Wire, false),
    (Stage::Lines, true),
    (Stage::Arrows, true),
    (Stage::Marks, true),
    (Stage::Lines, false),
    (Stage::Arrows, false),
    (Stage::Marks, false),
    (Stage::Ghost, false),
    (Stage::Boxes, false),
    (Stage::Capsules, false),
    (Stage::OnTop, false),
];

/// The draws of a picture in their order.
fn draws(picture: &SpacePicture) -> Vec<Draw<'_>> {
    let of_stage = |&(stage, is_hidden): &(Stage, bool)| {
        let layers = picture.layers.iter().filter(move |layer| layer.stage == stage);
        layers.map(move |layer| {
            let opacity = layer.opacity * if is_hidden { layer.hidden_opacity } else { 1.0 };
            Draw { layer, opacity, is_hidden }
        })
    };
    let is_seen = |draw: &Draw<'_>| draw.opacity > 0.0 && !draw.layer.geometry.shape().is_empty();
    DRAWN.iter().flat_map(of_stage).filter(is_seen).take(DRAWS_MAX).collect()
}
