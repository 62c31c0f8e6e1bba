//! Vertices that the GPU has: uploaded when a geometry is first drawn, dropped when none draws it.

use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Display;
use std::ops::Range;

use wgpu::util::DeviceExt;
use wgpu::{BufferUsages, Device, ErrorFilter};

use super::super::geometry::{Geometry, Shape, Vertex, capsule_template};
use super::super::picture::{Layer, SpacePicture};
use super::super::surfaces::Surfaces;
use super::pipelines::{Drawing, Lines, POINT_BYTES, Pipelines};

pub(super) struct Uploads {
    uploaded: BTreeMap<u64, Uploaded>,
    capsule_corners: wgpu::Buffer,
    capsule_indices: wgpu::Buffer,
    capsule_index_count: u32,
}

/// What the GPU has of a geometry.
enum Uploaded {
    Mesh {
        corners: wgpu::Buffer,
        colours: wgpu::Buffer,
        triangles: wgpu::Buffer,
    },
    /// Lines, marks or boxes.
    Points(Vec<Run>),
    Capsules {
        each: wgpu::Buffer,
        count: u32,
    },
}

/// As many consecutive lines as a binding holds.
struct Run {
    points: wgpu::BindGroup,
    lines: Range<u32>,
}

/// A buffer of these bytes, a multiple of 4 of them.
///
/// # Errors
/// Why the GPU has none.
fn buffer(device: &Device, label: &str, bytes: &[u8], usage: BufferUsages) -> Result<wgpu::Buffer, String> {
    let (size, most) = (bytes.len() as u64, device.limits().max_buffer_size);
    let needed = format!("{label} needs {} MiB", size.div_ceil(1 << 20));
    if size > most {
        return Err(format!("{needed}, and a buffer of this GPU has {} MiB at most", most >> 20));
    }
    let no_room = |why: &dyn Display| format!("{needed}, and the GPU has no room for them: {why}");
    let scope = device.push_error_scope(ErrorFilter::OutOfMemory);
    let descriptor = wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: true };
    let buffer = device.create_buffer(&descriptor);
    if let Some(error) = pollster::block_on(scope.pop()) {
        return Err(no_room(&error));
    }
    match buffer.get_mapped_range_mut(..) {
        Ok(mut mapped) => mapped.slice(..).copy_from_slice(bytes),
        Err(error) => return Err(no_room(&error)),
    }
    buffer.unmap();
    Ok(buffer)
}

impl Uploads {
    pub(super) fn new(device: &Device) -> Self {
        let (corners, indices) = capsule_template();
        let small = |label, contents, usage| {
            device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some(label),
                contents,
                usage,
            })
        };
        Self {
            uploaded: BTreeMap::new(),
            capsule_corners: small("capsules::corners", bytemuck::cast_slice(&corners), BufferUsages::VERTEX),
            capsule_indices: small("capsules::indices", bytemuck::cast_slice(&indices), BufferUsages::INDEX),
            capsule_index_count: indices.len() as u32,
        }
    }

    /// Uploads a geometry unless the GPU has it; the bytes that it took.
    ///
    /// # Errors
    /// Why the GPU cannot have it; it is not drawn then.
    pub(super) fn add(
        &mut self,
        device: &Device,
        pipelines: &Pipelines,
        geometry: &Geometry,
    ) -> Result<u64, String> {
        match self.uploaded.entry(geometry.id()) {
            Entry::Occupied(_) => Ok(0),
            // Nothing is drawn of it, and no buffer is empty.
            Entry::Vacant(_) if geometry.shape().is_empty() => Ok(0),
            Entry::Vacant(place) => {
                let (uploaded, bytes) = upload(device, pipelines, geometry.shape())?;
                place.insert(uploaded);
                Ok(bytes)
            }
        }
    }

    /// Drops all but these.
    pub(super) fn keep(&mut self, used: BTreeSet<u64>) {
        self.uploaded.retain(|id, _| used.contains(id));
    }

    /// Draws a layer of a picture; how many draws and vertices that are.
    pub(super) fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        pipelines: &Pipelines,
        (layer, drawing): (&Layer, Drawing),
        picture: &SpacePicture,
    ) -> (u64, u64) {
        let Some(uploaded) = self.uploaded.get(&layer.geometry.id()) else { return (0, 0) };
        let Some(pipeline) = pipelines.get(drawing) else { return (0, 0) };
        pass.set_pipeline(pipeline);
        let part = |all: &Range<u32>| match &layer.part {
            Some(part) => part.start.max(all.start)..part.end.min(all.end),
            None => all.clone(),
        };
        match (uploaded, layer.geometry.shape()) {
            (Uploaded::Mesh { corners, colours, triangles }, Shape::Mesh(surfaces)) => {
                pass.set_vertex_buffer(0, corners.slice(..));
                pass.set_vertex_buffer(1, colours.slice(..));
                pass.set_index_buffer(triangles.slice(..), wgpu::IndexFormat::Uint32);
                let drawn = surfaces.in_sight(&picture.camera, picture.pixels);
                drawn.fold((0, 0), |(calls, vertices), (triangles, grid)| {
                    // The shader knows the grid as the number of the instance.
                    pass.draw_indexed(3 * triangles.start..3 * triangles.end, 0, grid..grid + 1);
                    (calls + 1, vertices + 3 * triangles.len() as u64)
                })
            }
            (Uploaded::Points(runs), _) => {
                let corners = match drawing {
                    Drawing::Boxes => BOX_CORNERS,
                    Drawing::Lines(Lines::Arrows, _) => ARROW_CORNERS,
                    _ => QUAD_CORNERS,
                };
                let drawn =
                    runs.iter().map(|run| (run, part(&run.lines))).filter(|(_, part)| !part.is_empty());
                drawn.fold((0, 0), |(calls, vertices), (run, part)| {
                    let of_run = |line: u32| corners * (line - run.lines.start);
                    pass.set_bind_group(1, &run.points, &[]);
                    pass.draw(of_run(part.start)..of_run(part.end), 0..1);
                    (calls + 1, vertices + u64::from(corners) * part.len() as u64)
                })
            }
            (Uploaded::Capsules { each, count }, _) => {
                let part = part(&(0..*count));
                if part.is_empty() {
                    return (0, 0);
                }
                let drawn = u64::from(self.capsule_index_count) * part.len() as u64;
                pass.set_vertex_buffer(0, self.capsule_corners.slice(..));
                pass.set_vertex_buffer(1, each.slice(..));
                pass.set_index_buffer(self.capsule_indices.slice(..), wgpu::IndexFormat::Uint32);
                pass.draw_indexed(0..self.capsule_index_count, 0, part);
                (1, drawn)
            }
            (Uploaded::Mesh { .. }, _) => (0, 0),
        }
    }
}

/// Corners of the triangles of a box, of an arrow's head, and of a line or a mark.
const BOX_CORNERS: u32 = 36;
const ARROW_CORNERS: u32 = 3;
const QUAD_CORNERS: u32 = 6;

/// What the GPU has then, and the bytes that went there.
fn upload(device: &Device, pipelines: &Pipelines, shape: &Shape) -> Result<(Uploaded, u64), String> {
    let points = |label, points: &[Vertex]| {
        let points = buffer(device, label, bytemuck::cast_slice(points), BufferUsages::STORAGE)?;
        let runs = runs(device, pipelines, &points, (shape.len(), shape.points_each()));
        Ok((Uploaded::Points(runs), points.size()))
    };
    match shape {
        Shape::Mesh(Surfaces { positions, colours, triangles, .. }) => {
            let corners = bytemuck::cast_slice(positions);
            let corners = buffer(device, "mesh::corners", corners, BufferUsages::VERTEX)?;
            let colours = bytemuck::cast_slice(colours);
            let colours = buffer(device, "mesh::colours", colours, BufferUsages::VERTEX)?;
            let triangles = bytemuck::cast_slice(triangles);
            let triangles = buffer(device, "mesh::triangles", triangles, BufferUsages::INDEX)?;
            let bytes = corners.size() + colours.size() + triangles.size();
            Ok((Uploaded::Mesh { corners, colours, triangles }, bytes))
        }
        Shape::Strip(strip) => points("strip::points", strip),
        Shape::Segments(pairs) => points("segments::points", pairs.as_flattened()),
        Shape::Boxes(pairs) => points("boxes::corners", pairs.as_flattened()),
        Shape::Capsules(capsules) => {
            let each = bytemuck::cast_slice(capsules);
            let each = buffer(device, "capsules::each", each, BufferUsages::VERTEX)?;
            let bytes = each.size();
            Ok((Uploaded::Capsules { each, count: capsules.len() as u32 }, bytes))
        }
    }
}

/// Lines that a binding may start at: 16 points are as many bytes as any GPU aligns bindings to.
const ALIGNED: u64 = 16;

/// Bindings for all lines of a buffer, each with as many as one may hold.
fn runs(
    device: &Device,
    pipelines: &Pipelines,
    buffer: &wgpu::Buffer,
    (lines, each): (usize, u32),
) -> Vec<Run> {
    let (lines, each) = (lines as u64, u64::from(each));
    // A strip's last line ends at a point that no other starts at.
    let points_most = device.limits().max_storage_buffer_binding_size / POINT_BYTES - 1;
    let most = (points_most / each / ALIGNED * ALIGNED).max(ALIGNED);
    let starts = (0..lines.div_ceil(most)).map(|run| run * most);
    let run = |start: u64| {
        let end = lines.min(start + most);
        let points = (end - start - 1) * each + 2;
        let size = wgpu::BufferSize::new(points * POINT_BYTES);
        let points = wgpu::BufferBinding { buffer, offset: start * each * POINT_BYTES, size };
        Run { points: pipelines.points_bindings(device, points), lines: start as u32..end as u32 }
    };
    starts.map(run).collect()
}
