//! Rays, hits, the curve of an order and capsules as binary PLY, for Blender, MeshLab and their like.

use std::io::{self, Write};

use formats::metrics::capsule::{Capsule, Point, Segment};

use super::capsule;
use super::rays::ChosenRays;

/// Each ray as an edge from its origin to where it stops, coloured by its place in the order.
pub(crate) fn rays(rays: &ChosenRays, output: &mut dyn Write) -> io::Result<()> {
    let count = rays.len();
    header(output, 2 * count, &[("edge", count, EDGE)])?;
    for ray in rays.iter() {
        let colour = colour(ray.place, rays);
        vertex(output, ray.ray.origin.map(f64::from), colour)?;
        vertex(output, ray.termination, colour)?;
    }
    (0..count as u32).try_for_each(|ray| edge(output, 2 * ray, 2 * ray + 1))
}

/// Rays of several bounces as edges, coloured by bounce.
pub(crate) fn paths(rays: &[(u32, [Point; 2])], output: &mut dyn Write) -> io::Result<()> {
    let last = rays.iter().map(|(bounce, _)| *bounce).max().unwrap_or(0).max(1);
    header(output, 2 * rays.len(), &[("edge", rays.len(), EDGE)])?;
    for (bounce, ends) in rays {
        let colour = viridis(f64::from(*bounce) / f64::from(last));
        ends.iter().try_for_each(|end| vertex(output, *end, colour))?;
    }
    (0..rays.len() as u32).try_for_each(|ray| edge(output, 2 * ray, 2 * ray + 1))
}

/// Where rays end at surfaces, coloured by place in the order.
pub(crate) fn hits(rays: &ChosenRays, output: &mut dyn Write) -> io::Result<()> {
    let hits = || rays.iter().filter(|ray| rays.queue().is_at_surface(ray.index));
    header(output, hits().count(), &[])?;
    hits().try_for_each(|ray| vertex(output, ray.termination, colour(ray.place, rays)))
}

/// The way through the origins that an order takes.
pub(crate) fn curve(rays: &ChosenRays, output: &mut dyn Write) -> io::Result<()> {
    let count = rays.len();
    header(output, count, &[("edge", count.saturating_sub(1), EDGE)])?;
    for ray in rays.iter() {
        vertex(output, ray.ray.origin.map(f64::from), colour(ray.place, rays))?;
    }
    (1..count as u32).try_for_each(|place| edge(output, place - 1, place))
}

/// The capsule of each group of an order.
pub(crate) fn capsules(rays: &ChosenRays, group_width: usize, output: &mut dyn Write) -> io::Result<()> {
    let groups = rays.len().div_ceil(group_width);
    header(output, groups * capsule::VERTICES, &[("face", groups * capsule::TRIANGLES, FACE)])?;
    let mut group: Vec<Segment> = Vec::with_capacity(group_width);
    for (at, ray) in rays.iter().enumerate() {
        group.push(Segment { origin: ray.ray.origin.map(f64::from), end: ray.termination });
        if group.len() == group_width || at + 1 == rays.len() {
            let colour = colour(ray.place, rays);
            let vertices =
                Capsule::around(&group).into_iter().flat_map(|capsule| capsule::vertices(&capsule));
            vertices.into_iter().try_for_each(|point| vertex(output, point, colour))?;
            group.clear();
        }
    }
    for group in 0..groups {
        let first = (group * capsule::VERTICES) as u32;
        for corners in capsule::triangles() {
            output.write_all(&[3])?;
            corners.iter().try_for_each(|corner| output.write_all(&(first + corner).to_le_bytes()))?;
        }
    }
    Ok(())
}

const EDGE: &str = "property int vertex1\nproperty int vertex2\n";
const FACE: &str = "property list uchar int vertex_indices\n";

fn header(output: &mut dyn Write, vertices: usize, elements: &[(&str, usize, &str)]) -> io::Result<()> {
    // The format counts corners in signed 32-bit numbers.
    if vertices > i32::MAX as usize {
        return Err(io::Error::other(format!(
            "{vertices} corners are more than PLY can count; export one group"
        )));
    }
    write!(
        output,
        "ply\nformat binary_little_endian 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\n\
         property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
    )?;
    for (name, count, properties) in elements {
        write!(output, "element {name} {count}\n{properties}")?;
    }
    output.write_all(b"end_header\n")
}

fn vertex(output: &mut dyn Write, point: Point, colour: [u8; 3]) -> io::Result<()> {
    point.iter().try_for_each(|part| output.write_all(&(*part as f32).to_le_bytes()))?;
    output.write_all(&colour)
}

fn edge(output: &mut dyn Write, from: u32, to: u32) -> io::Result<()> {
    output.write_all(&from.to_le_bytes())?;
    output.write_all(&to.to_le_bytes())
}

/// By place in the order.
fn colour(place: usize, rays: &ChosenRays) -> [u8; 3] {
    viridis(rays.part(place))
}

/// Dark blue for 0 over green to yellow for 1 (five of its colours).
fn viridis(part: f64) -> [u8; 3] {
    const STOPS: [[f64; 3]; 5] = [
        [68.0, 1.0, 84.0],
        [59.0, 82.0, 139.0],
        [33.0, 145.0, 140.0],
        [94.0, 201.0, 98.0],
        [253.0, 231.0, 37.0],
    ];
    let along = part * (STOPS.len() - 1) as f64;
    let stop = (along as usize).min(STOPS.len() - 2);
    let part = along - stop as f64;
    [0, 1, 2].map(|at| (STOPS[stop][at] * (1.0 - part) + STOPS[stop + 1][at] * part).round() as u8)
}
