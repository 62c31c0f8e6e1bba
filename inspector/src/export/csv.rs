//! Rays with their ends as CSV, one row each, in their order.

use std::io::{self, Write};

use formats::ray::{Hit, Kind};
use formats::traced::Results;

use super::rays::{ChosenRays, RayAtPlace};
use crate::model::Queue;

const RAY_COLUMNS: [&str; 11] = [
    "place",
    "ray",
    "path",
    "origin_x",
    "origin_y",
    "origin_z",
    "t_min",
    "direction_x",
    "direction_y",
    "direction_z",
    "t_max",
];

/// Writes the rows with their header. Lengths are world units; `ray` is the canonical index.
pub(crate) fn write(rays: &ChosenRays, output: impl Write) -> io::Result<()> {
    let mut writer = csv::Writer::from_writer(output);
    let end_columns: &[&str] = match rays.queue().id.kind {
        Kind::Closest => &["t", "triangle", "u", "v"],
        Kind::Shadow => &["distance", "light"],
    };
    writer.write_record(RAY_COLUMNS.iter().chain(end_columns))?;
    for ray in rays.iter() {
        writer.write_record(row(rays.queue(), &ray))?;
    }
    writer.flush()
}

fn row(queue: &Queue, at: &RayAtPlace) -> Vec<String> {
    let (index, ray) = (at.index, &at.ray);
    let mut row = vec![at.place.to_string(), index.to_string(), queue.path_ids[index].to_string()];
    row.extend(ray.origin.iter().map(f32::to_string));
    row.push(ray.t_min.to_string());
    row.extend(ray.direction.iter().map(f32::to_string));
    row.push(ray.t_max.to_string());
    match queue.traced.results() {
        Results::Hits(hits) => {
            let Hit { t, triangle, u, v } = hits[index];
            row.push(t.to_string());
            // No triangle number that could be taken for one.
            let is_hit = hits[index].is_hit();
            let of_triangle = [triangle.to_string(), u.to_string(), v.to_string()];
            row.extend(if is_hit { of_triangle } else { Default::default() });
        }
        Results::Distances(distances) => {
            let light = queue.lights.as_ref().map_or(0, |lights| lights[index]);
            row.extend([distances[index].to_string(), light.to_string()]);
        }
    }
    row
}
