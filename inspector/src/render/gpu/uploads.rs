//! Vertices that the GPU has: uploaded when a geometry is first drawn, dropped when none draws it.

use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use wgpu::util::DeviceExt;
use wgpu::{BufferUsages, Device};

use super::super::frame::Stage;
use super::super::geometry::{Geometry, Shape, capsule_template};
use super::pipelines::{LinePipelines, Pipelines};

pub(super) struct Uploads {
    uploaded: BTreeMap<u64, Uploaded>,
    capsule_corners: wgpu::Buffer,
    capsule_indices: wgpu::Buffer,
    capsule_index_count: u32,
}

/// Vertices, indices where there are any, and how many there are to draw.
struct Uploaded {
    vertices: wgpu::Buffer,
    indices: Option<wgpu::Buffer>,
    count: u32,
}

fn buffer(device: &Device, label: &str, bytes: &[u8], usage: BufferUsages) -> wgpu::Buffer {
    device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: Some(label),
        contents: bytes,
        usage,
    })
}

impl Uploads {
    pub(super) fn new(device: &Device) -> Self {
        let (corners, indices) = capsule_template();
        let corners = bytemuck::cast_slice(&corners);
        Self {
            uploaded: BTreeMap::new(),
            capsule_corners: buffer(device, "capsules::corners", corners, BufferUsages::VERTEX),
            capsule_indices: buffer(
                device,
                "capsules::indices",
                bytemuck::cast_slice(&indices),
                BufferUsages::INDEX,
            ),
            capsule_index_count: indices.len() as u32,
        }
    }

    /// Uploads a geometry unless the GPU has it; the bytes that it took.
    pub(super) fn add(&mut self, device: &Device, geometry: &Geometry) -> u64 {
        match self.uploaded.entry(geometry.id()) {
            Entry::Occupied(_) => 0,
            Entry::Vacant(place) => {
                let uploaded = place.insert(upload(device, geometry.shape()));
                uploaded.vertices.size() + uploaded.indices.as_ref().map_or(0, wgpu::Buffer::size)
            }
        }
    }

    /// Drops all but these.
    pub(super) fn keep(&mut self, used: BTreeSet<u64>) {
        self.uploaded.retain(|id, _| used.contains(id));
    }

    /// Draws a geometry, or a part of its lines, boxes or capsules; how many vertices that are.
    pub(super) fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        pipelines: &Pipelines,
        geometry: &Geometry,
        (stage, is_hidden): (Stage, bool),
        part: Option<Range<u32>>,
    ) -> u64 {
        let Some(uploaded) = self.uploaded.get(&geometry.id()) else { return 0 };
        let all = 0..uploaded.count;
        let part = part.map_or(all.clone(), |part| part.start.min(all.end)..part.end.min(all.end));
        if part.is_empty() {
            return 0;
        }
        let instances = part.len() as u64;
        match geometry.shape() {
            Shape::Mesh { .. } => {
                let Some(indices) = &uploaded.indices else { return 0 };
                let is_ghost = stage == Stage::Ghost;
                pass.set_pipeline(if is_ghost { &pipelines.ghost } else { &pipelines.solid });
                pass.set_vertex_buffer(0, uploaded.vertices.slice(..));
                pass.set_index_buffer(indices.slice(..), wgpu::IndexFormat::Uint32);
                pass.draw_indexed(all, 0, 0..1);
                u64::from(uploaded.count)
            }
            Shape::Strip(_) => {
                lines(pass, (&pipelines.strips, 4), (stage, is_hidden), &uploaded.vertices, part);
                4 * instances
            }
            Shape::Segments(_) => {
                let (of, corners) = match stage {
                    Stage::Arrows => (&pipelines.arrows, 3),
                    Stage::Marks => (&pipelines.marks, 4),
                    _ => (&pipelines.segments, 4),
                };
                lines(pass, (of, corners), (stage, is_hidden), &uploaded.vertices, part);
                u64::from(corners) * instances
            }
            Shape::Boxes(_) => {
                pass.set_pipeline(&pipelines.boxes);
                pass.set_vertex_buffer(0, uploaded.vertices.slice(..));
                pass.set_vertex_buffer(1, uploaded.vertices.slice(POINT_BYTES..));
                pass.draw(0..BOX_CORNERS, part);
                u64::from(BOX_CORNERS) * instances
            }
            Shape::Capsules(_) => {
                pass.set_pipeline(&pipelines.capsules);
                pass.set_vertex_buffer(0, self.capsule_corners.slice(..));
                pass.set_vertex_buffer(1, uploaded.vertices.slice(..));
                pass.set_index_buffer(self.capsule_indices.slice(..), wgpu::IndexFormat::Uint32);
                pass.draw_indexed(0..self.capsule_index_count, 0, part);
                u64::from(self.capsule_index_count) * instances
            }
        }
    }
}

/// Corners of the triangles of a box.
const BOX_CORNERS: u32 = 36;

/// Bytes from a line's first point to its second.
const POINT_BYTES: u64 = 16;

fn lines(
    pass: &mut wgpu::RenderPass<'_>,
    (pipelines, corners): (&LinePipelines, u32),
    (stage, is_hidden): (Stage, bool),
    points: &wgpu::Buffer,
    part: Range<u32>,
) {
    pass.set_pipeline(match (stage, is_hidden) {
        (Stage::OnTop, _) => &pipelines.on_top,
        (_, true) => &pipelines.hidden,
        (_, false) => &pipelines.seen,
    });
    pass.set_vertex_buffer(0, points.slice(..));
    pass.set_vertex_buffer(1, points.slice(POINT_BYTES..));
    pass.draw(0..corners, part);
}

fn upload(device: &Device, shape: &Shape) -> Uploaded {
    let vertices = |label, bytes: &[u8]| buffer(device, label, bytes, BufferUsages::VERTEX);
    match shape {
        Shape::Mesh { positions, triangles } => Uploaded {
            vertices: vertices("mesh::positions", bytemuck::cast_slice(positions)),
            indices: Some(buffer(
                device,
                "mesh::triangles",
                bytemuck::cast_slice(triangles),
                BufferUsages::INDEX,
            )),
            count: 3 * triangles.len() as u32,
        },
        Shape::Strip(points) => Uploaded {
            vertices: vertices("strip::points", bytemuck::cast_slice(points)),
            indices: None,
            count: (points.len() as u32).saturating_sub(1),
        },
        Shape::Segments(segments) => Uploaded {
            vertices: vertices("segments::points", bytemuck::cast_slice(segments)),
            indices: None,
            count: segments.len() as u32,
        },
        Shape::Boxes(boxes) => Uploaded {
            vertices: vertices("boxes::corners", bytemuck::cast_slice(boxes)),
            indices: None,
            count: boxes.len() as u32,
        },
        Shape::Capsules(capsules) => Uploaded {
            vertices: vertices("capsules::instances", bytemuck::cast_slice(capsules)),
            indices: None,
            count: capsules.len() as u32,
        },
    }
}
