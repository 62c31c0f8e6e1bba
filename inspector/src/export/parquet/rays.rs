//! Rays in the order of a method: a row each.

use std::path::PathBuf;

use formats::key::Termination;
use formats::key::termination::bounded_length;
use formats::manifest::MethodRecord;
use formats::metrics::group::Group;
use formats::ray::Work;
use formats::traced::Results;

use super::table::Values::{Few, Near, Runs};
use super::table::{Column, TableWriter};
use crate::model::{Order, Queue};

/// A column of rays.
type RayColumn<'a> = Column<RayRow<'a>>;

/// One ray at its place.
struct RayRow<'a> {
    recording: &'a str,
    pass: u32,
    place: u32,
    group: u32,
    ray: u32,
    path: u32,
    key: Option<u64>,
    origin: [f32; 3],
    direction: [f32; 3],
    t: Option<f32>,
    length: Option<f32>,
    estimate: Option<f32>,
    triangle: Option<u32>,
    material: Option<u32>,
    light: Option<u32>,
    nodes: Option<u32>,
    triangles_tested: Option<u32>,
    capsule_area: Option<f64>,
    direction_spread: Option<f64>,
}

/// An order and what its rows are made from beyond it.
pub(super) struct OrderedRays<'a> {
    /// The recording's name.
    pub(super) recording: &'a str,
    /// The order.
    pub(super) order: &'a Order,
    /// How its keys were made; none for orders without keys of their own.
    pub(super) method: Option<&'a MethodRecord>,
    /// Rays of a group.
    pub(super) group_width: usize,
}

/// What a queue's arrays have of a ray beside itself.
struct Found {
    path: u32,
    t: Option<f32>,
    triangle: Option<u32>,
    work: Option<Work>,
}

/// What the arrays have of some rays. They lie anywhere: asked for one after the other, with nothing in between, the
/// processor waits for many of them at once.
fn found(queue: &Queue, indices: &[usize]) -> Vec<Found> {
    let of = |&index: &usize| {
        let (t, triangle) = match queue.traced.results() {
            Results::Hits(hits) => {
                hits[index].is_hit().then_some((hits[index].t, hits[index].triangle)).unzip()
            }
            Results::Distances(distances) => (Some(distances[index]), None),
        };
        let work = queue.work.as_ref().ok().map(|work| work[index]);
        Found { path: queue.path_ids[index], t, triangle, work }
    };
    indices.iter().map(of).collect()
}

impl OrderedRays<'_> {
    /// Writes all rows into a file; gives their number.
    ///
    /// # Errors
    /// If it cannot be written.
    pub(super) fn write(&self, path: PathBuf) -> anyhow::Result<u64> {
        let mut table = TableWriter::create(path, columns())?;
        let (order, queue) = (self.order, &*self.order.queue);
        for first in (0..order.len()).step_by(self.group_width) {
            let places = first..(first + self.group_width).min(order.len());
            let indices: Vec<usize> = places.clone().map(|place| order.places.ray(place)).collect();
            let group = Group::of(&queue.traced, &queue.lengths, None, indices.iter().copied());
            let found = found(queue, &indices);
            for ((place, index), found) in places.zip(indices).zip(found) {
                table.push(self.row(queue, place, index, &found, group.as_ref()))?;
            }
        }
        table.finish()
    }

    fn row(
        &self,
        queue: &Queue,
        place: usize,
        index: usize,
        &Found { path, t, triangle, work }: &Found,
        group: Option<&Group>,
    ) -> RayRow<'_> {
        let ray = &queue.traced.rays()[index];
        let material = triangle.and_then(|triangle| queue.materials.as_ref().ok()?.get(triangle as usize));
        let finite = |number: f64| Some(number).filter(|number| number.is_finite());
        RayRow {
            recording: self.recording,
            pass: queue.id.pass,
            place: place as u32,
            group: (place / self.group_width) as u32,
            ray: index as u32,
            path,
            key: self.order.keys.as_ref().ok().map(|(keys, _)| keys.at(index)),
            origin: ray.origin,
            direction: ray.direction,
            t: t.filter(|t| t.is_finite()),
            length: Some(queue.lengths[index]).filter(|length| length.is_finite()),
            estimate: self.estimate(queue, index),
            triangle,
            material: material.copied(),
            light: queue.lights.as_ref().map(|lights| lights[index]),
            nodes: work.map(|work| work.nodes),
            triangles_tested: work.map(|work| work.triangles),
            capsule_area: group.and_then(|group| finite(group.area)),
            direction_spread: group.and_then(|group| finite(group.spread)),
        }
    }

    /// The length that the method took a ray for, cut as its key has it.
    fn estimate(&self, queue: &Queue, index: usize) -> Option<f32> {
        let (method, ray) = (self.method?, &queue.traced.rays()[index]);
        let length = match method.termination {
            Termination::Unused => None,
            Termination::Fixed => Some(method.two_point_length),
            Termination::Adaptive => queue.table.as_ref().ok().map(|table| table.mean(ray)),
            Termination::Real => Some(queue.lengths[index]),
        }?;
        let unit = queue.traced.unit();
        Some(bounded_length(unit, ray, unit.point(ray.origin), length)).filter(|length| length.is_finite())
    }
}

fn columns<'a>() -> Vec<RayColumn<'a>> {
    let (mut columns, mut found) = (which(), what_was_found());
    columns.append(&mut found);
    columns
}

/// Which ray it is, where it stands, where it starts.
fn which<'a>() -> Vec<RayColumn<'a>> {
    let world = "world units";
    vec![
        RayColumn::text("recording", "Recording, by its folder", |row| Some(row.recording)).required(),
        RayColumn::u32("pass", "Pass, from 0", Runs, |row| Some(row.pass)).required(),
        RayColumn::u32("place", "Place in the order, from 0", Near, |row| Some(row.place)).required(),
        RayColumn::u32("group", "Group in the order, from 0: rays that are traced together", Near, |row| {
            Some(row.group)
        })
        .required(),
        RayColumn::u32("ray", "Canonical index: the place in pixel order", Near, |row| Some(row.ray))
            .required(),
        RayColumn::u32("path", "Path: its pixel, row by row from the top left", Near, |row| Some(row.path))
            .required(),
        RayColumn::u64("key", "What the rays are sorted by", Near, |row| row.key),
        RayColumn::f32("origin_x", "Origin", |row| Some(row.origin[0])).unit(world).required(),
        RayColumn::f32("origin_y", "Origin", |row| Some(row.origin[1])).unit(world).required(),
        RayColumn::f32("origin_z", "Origin", |row| Some(row.origin[2])).unit(world).required(),
        RayColumn::f32("direction_x", "Direction, a unit vector", |row| Some(row.direction[0])).required(),
        RayColumn::f32("direction_y", "Direction, a unit vector", |row| Some(row.direction[1])).required(),
        RayColumn::f32("direction_z", "Direction, a unit vector", |row| Some(row.direction[2])).required(),
    ]
}

/// What became of it, and how its group is.
fn what_was_found<'a>() -> Vec<RayColumn<'a>> {
    let unit_lengths = "unit lengths: the scene's largest side is 1";
    vec![
        RayColumn::f32("t", "Distance to the surface that was hit; null where none was", |row| row.t)
            .unit("world units"),
        RayColumn::f32("length", "Traced length, cut where the ray leaves the scene", |row| row.length)
            .unit(unit_lengths),
        RayColumn::f32("estimate", "Length that the method takes it for; null where it takes none", |row| {
            row.estimate
        })
        .unit(unit_lengths),
        RayColumn::u32("triangle", "Triangle that was hit; null for none and for shadow rays", Near, |row| {
            row.triangle
        }),
        RayColumn::u32("material", "Material of that triangle", Few, |row| row.material),
        RayColumn::u32("light", "Light that a shadow ray goes to", Few, |row| row.light),
        RayColumn::u32("nodes", "Nodes of the hierarchy visited; null where not recorded", Near, |row| {
            row.nodes
        }),
        RayColumn::u32("triangles_tested", "Triangles tested; null where not recorded", Near, |row| {
            row.triangles_tested
        }),
        RayColumn::f64("capsule_area", "Area of the capsule around the ray's group", Runs, |row| {
            row.capsule_area
        })
        .unit("unit lengths squared"),
        RayColumn::f64(
            "direction_spread",
            "Direction spread of its group: 0 if all are parallel",
            Runs,
            |row| row.direction_spread,
        ),
    ]
}
