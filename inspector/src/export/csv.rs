//! Rays with their ends as CSV, one row each, in their order.

use std::io::{self, Write};

use formats::ray::Kind;

use super::rays::{End, RayAtPlace, Rays};

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
pub(crate) fn write(rays: &Rays, output: impl Write) -> io::Result<()> {
    let mut writer = csv::Writer::from_writer(output);
    let end_columns: &[&str] = match rays.id().kind {
        Kind::Closest => &["t", "triangle", "u", "v"],
        Kind::Shadow => &["distance", "light"],
    };
    writer.write_record(RAY_COLUMNS.iter().chain(end_columns))?;
    for ray in rays.iter() {
        writer.write_record(row(&ray))?;
    }
    writer.flush()
}

fn row(at: &RayAtPlace) -> Vec<String> {
    let mut row = vec![at.place.to_string(), at.index.to_string(), at.path_id.to_string()];
    let ray = &at.ray;
    row.extend(ray.origin.iter().map(f32::to_string));
    row.push(ray.t_min.to_string());
    row.extend(ray.direction.iter().map(f32::to_string));
    row.push(ray.t_max.to_string());
    match &at.end {
        End::Closest(hit) if hit.is_hit() => {
            row.extend([hit.t.to_string(), hit.triangle.to_string(), hit.u.to_string(), hit.v.to_string()]);
        }
        // No triangle number that could be taken for one.
        End::Closest(hit) => row.extend([hit.t.to_string(), String::new(), String::new(), String::new()]),
        End::Shadow { distance, light } => row.extend([distance.to_string(), light.to_string()]),
    }
    row
}
