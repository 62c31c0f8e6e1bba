//! Vertices that the GPU has: uploaded when a geometry is first drawn, dropped when none draws it.

use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};

use wgpu::util::DeviceExt;
use wgpu::{BufferUsages, Device};

use super::super::frame::{Frame, Layer};
use super::super::geometry::{Geometry, Shape, capsule_template};
use super::super::surfaces::Surfaces;
use super::pipelines::{Lines, Pipelines, Way};

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

    /// Draws a layer of a frame; how many draws and vertices that are.
    pub(super) fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        pipelines: &Pipelines,
        (layer, way): (&Layer, Way),
        frame: &Frame,
    ) -> (u64, u64) {
        let Some(uploaded) = self.uploaded.get(&layer.geometry.id()) else { return (0, 0) };
        let all = 0..uploaded.count;
        let part = layer.part.as_ref();
        let part = part.map_or(all.clone(), |part| part.start.min(all.end)..part.end.min(all.end));
        let Some(pipeline) = pipelines.get(way).filter(|_| !part.is_empty()) else { return (0, 0) };
        pass.set_pipeline(pipeline);
        let instances = part.len() as u64;
        match layer.geometry.shape() {
            Shape::Mesh(surfaces) => {
                let Some(indices) = &uploaded.indices else { return (0, 0) };
                pass.set_vertex_buffer(0, uploaded.vertices.slice(..));
                pass.set_index_buffer(indices.slice(..), wgpu::IndexFormat::Uint32);
                let drawn = surfaces.in_sight(&frame.camera, frame.pixels);
                drawn.fold((0, 0), |(calls, vertices), (triangles, grid)| {
                    // The shader knows the grid as the number of the instance.
                    pass.draw_indexed(3 * triangles.start..3 * triangles.end, 0, grid..grid + 1);
                    (calls + 1, vertices + 3 * triangles.len() as u64)
                })
            }
            Shape::Strip(_) | Shape::Segments(_) | Shape::Boxes(_) => {
                let corners = match way {
                    Way::Boxes => BOX_CORNERS,
                    Way::Lines(Lines::Arrows, _) => 3,
                    _ => 4,
                };
                pass.set_vertex_buffer(0, uploaded.vertices.slice(..));
                pass.set_vertex_buffer(1, uploaded.vertices.slice(POINT_BYTES..));
                pass.draw(0..corners, part);
                (1, u64::from(corners) * instances)
            }
            Shape::Capsules(_) => {
                pass.set_vertex_buffer(0, self.capsule_corners.slice(..));
                pass.set_vertex_buffer(1, uploaded.vertices.slice(..));
                pass.set_index_buffer(self.capsule_indices.slice(..), wgpu::IndexFormat::Uint32);
                pass.draw_indexed(0..self.capsule_index_count, 0, part);
                (1, u64::from(self.capsule_index_count) * instances)
            }
        }
    }
}

/// Corners of the triangles of a box.
const BOX_CORNERS: u32 = 36;

/// Bytes from a line's first point to its second.
const POINT_BYTES: u64 = 16;

fn upload(device: &Device, shape: &Shape) -> Uploaded {
    let vertices = |label, bytes: &[u8]| buffer(device, label, bytes, BufferUsages::VERTEX);
    match shape {
        Shape::Mesh(Surfaces { positions, triangles, .. }) => Uploaded {
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
