//! Rays in the order of a method: a row each.

use std::path::PathBuf;
use std::sync::Arc;

use formats::key::Termination;
use formats::key::termination::bounded_length;
use formats::manifest::MethodRecord;
use formats::metrics::group::Group;
use formats::prefetch::{AHEAD, prefetch_at};
use formats::ray::Kind;

use super::cell::Cell;
use super::found::{Found, NONE};
use super::table::{Column, TableWriter};
use crate::analysis::coherence::{Coherence, Lanes};
use crate::analysis::known::KnownOrder;
use crate::model::{Order, Queue};

/// Rows that are made at a time: whole groups of any width, and as many as a cache holds.
const ROWS_PER_BLOCK: usize = 1 << 9;

/// A column of rays.
type RayColumn<'a> = Column<'a, RayRow>;

/// One ray at its place.
struct RayRow {
    found: Found,
    ray: u32,
    place: u32,
    key: u64,
    /// Not a number for none, as are all numbers of a row that are none.
    estimate: f32,
    capsule_area: f64,
    direction_spread: f64,
}

/// An order and what its rows are made from beyond it.
pub(super) struct OrderedRays<'a> {
    /// The recording's name.
    pub(super) recording: &'a str,
    /// The order.
    pub(super) order: &'a Order,
    /// What became of each ray of its queue.
    pub(super) found: &'a [Found],
    /// How its keys were made; none for orders without keys of their own.
    pub(super) method: Option<&'a MethodRecord>,
    /// Rays of a group.
    pub(super) group_width: usize,
}

impl OrderedRays<'_> {
    /// Writes all rows into a file; gives their number and what was found of the order on the way.
    ///
    /// # Errors
    /// If it cannot be written.
    pub(super) fn write(&self, path: PathBuf) -> anyhow::Result<(u64, Option<KnownOrder>)> {
        let mut table = TableWriter::create(path, self.columns())?;
        let mut rows = Vec::with_capacity(ROWS_PER_BLOCK);
        let mut groups = Vec::with_capacity(self.order.len().div_ceil(self.group_width));
        let mut lanes = Lanes::default();
        for first in (0..self.order.len()).step_by(ROWS_PER_BLOCK) {
            rows.clear();
            let places = first..(first + ROWS_PER_BLOCK).min(self.order.len());
            rows.extend(places.map(|place| {
                let ahead = (place + AHEAD).min(self.order.len() - 1);
                prefetch_at(self.found, self.order.places.ray(ahead));
                self.row(place)
            }));
            self.add_estimates(&mut rows);
            groups.extend(rows.chunks_mut(self.group_width).filter_map(|group| self.add_capsule(group)));
            lanes.add(rows.iter().map(|row| &row.found.work));
            table.add(&rows)?;
        }
        let lanes = self.order.queue.work.is_ok().then(|| lanes.utilisation());
        let order = Coherence::of(groups).map(|coherence| KnownOrder { coherence, lanes });
        Ok((table.finish()?, order))
    }

    fn row(&self, place: usize) -> RayRow {
        let ray = self.order.places.ray(place);
        RayRow {
            found: self.found[ray],
            ray: ray as u32,
            place: place as u32,
            key: self.order.keys.as_ref().map_or(0, |(keys, _)| keys.at(ray)),
            estimate: f32::NAN,
            capsule_area: f64::NAN,
            direction_spread: f64::NAN,
        }
    }

    /// Whether the method takes rays for some length, and it is known which.
    fn has_estimates(&self) -> bool {
        match self.method.map_or(Termination::Unused, |method| method.termination) {
            Termination::Unused => false,
            Termination::Adaptive => self.order.queue.table.is_ok(),
            Termination::Fixed | Termination::Real => true,
        }
    }

    /// The lengths that the method took rays for, cut as its keys have them.
    fn add_estimates(&self, rows: &mut [RayRow]) {
        let Some(method) = self.method else { return };
        let (queue, unit): (&Queue, _) = (&self.order.queue, self.order.queue.traced.unit());
        for row in rows {
            let Found { ray, length, .. } = &row.found;
            let length = match method.termination {
                Termination::Unused => return,
                Termination::Fixed => method.two_point_length,
                Termination::Adaptive => match &queue.table {
                    Ok(table) => table.mean(ray),
                    Err(_) => return,
                },
                Termination::Real => *length,
            };
            row.estimate = bounded_length(unit, ray, unit.point(ray.origin), length);
        }
    }

    /// How coherent a group is, for each of its rays.
    fn add_capsule(&self, rows: &mut [RayRow]) -> Option<Group> {
        let rays = rows.iter().map(|row| (&row.found.ray, row.found.length));
        let group = Group::around(self.order.queue.traced.unit(), rays)?;
        for row in rows {
            (row.capsule_area, row.direction_spread) = (group.area, group.spread);
        }
        Some(group)
    }

    fn columns(&self) -> Vec<RayColumn<'_>> {
        let (mut columns, mut found) = (self.which(), self.what_was_found());
        columns.append(&mut found);
        columns
    }

    /// Which ray it is, where it stands, where it starts.
    fn which(&self) -> Vec<RayColumn<'_>> {
        let world = "world units";
        let (recording, pass): (Arc<str>, _) = (self.recording.into(), self.order.queue.id.pass);
        let group_width = self.group_width as u32;
        let has_keys = self.order.keys.is_ok();
        vec![
            RayColumn::constant("recording", "Recording, by its folder", recording),
            RayColumn::constant("pass", "Pass, from 0", pass),
            RayColumn::known("place", "Place in the order, from 0", |row| row.place),
            RayColumn::known(
                "group",
                "Group in the order, from 0: rays that are traced together",
                move |row| row.place / group_width,
            ),
            RayColumn::known("ray", "Canonical index: the place in pixel order", |row| row.ray),
            RayColumn::known("path", "Path: its pixel, row by row from the top left", |row| row.found.path),
            if_kept(has_keys, "key", "What the rays are sorted by", |row| Some(row.key)),
            RayColumn::known("origin_x", "Origin", |row| row.found.ray.origin[0]).unit(world),
            RayColumn::known("origin_y", "Origin", |row| row.found.ray.origin[1]).unit(world),
            RayColumn::known("origin_z", "Origin", |row| row.found.ray.origin[2]).unit(world),
            RayColumn::known("direction_x", "Direction, a unit vector", |row| row.found.ray.direction[0]),
            RayColumn::known("direction_y", "Direction, a unit vector", |row| row.found.ray.direction[1]),
            RayColumn::known("direction_z", "Direction, a unit vector", |row| row.found.ray.direction[2]),
        ]
    }

    /// What became of it, and how its group is.
    fn what_was_found(&self) -> Vec<RayColumn<'_>> {
        let unit_lengths = "unit lengths: the scene's largest side is 1";
        let queue = &*self.order.queue;
        let (has_hits, has_materials) = (queue.id.kind == Kind::Closest, queue.materials.is_ok());
        let (has_lights, has_work) = (queue.lights.is_some(), queue.work.is_ok());
        let index = |index: u32| Some(index).filter(|&index| index != NONE);
        let number = |number: f32| Some(number).filter(|number| number.is_finite());
        let real = |number: f64| Some(number).filter(|number| number.is_finite());
        vec![
            RayColumn::optional(
                "t",
                "Distance to the surface that was hit; null where none was",
                move |row| number(row.found.t),
            )
            .unit("world units"),
            RayColumn::optional("length", "Traced length, cut where the ray leaves the scene", move |row| {
                number(row.found.length)
            })
            .unit(unit_lengths),
            if_kept(
                self.has_estimates(),
                "estimate",
                "Length that the method takes it for; null where it takes none",
                move |row| number(row.estimate),
            )
            .unit(unit_lengths),
            if_kept(
                has_hits,
                "triangle",
                "Triangle that was hit; null for none and for shadow rays",
                move |row| index(row.found.triangle),
            ),
            if_kept(has_hits && has_materials, "material", "Material of that triangle", move |row| {
                index(row.found.material)
            }),
            if_kept(has_lights, "light", "Light that a shadow ray goes to", |row| Some(row.found.light)),
            if_kept(has_work, "nodes", "Nodes of the hierarchy visited; null where not recorded", |row| {
                Some(row.found.work.nodes)
            }),
            if_kept(has_work, "triangles_tested", "Triangles tested; null where not recorded", |row| {
                Some(row.found.work.triangles)
            }),
            RayColumn::repeated("capsule_area", "Area of the capsule around the ray's group", move |row| {
                real(row.capsule_area)
            })
            .unit("unit lengths squared"),
            RayColumn::repeated(
                "direction_spread",
                "Direction spread of its group: 0 if all are parallel",
                move |row| real(row.direction_spread),
            ),
        ]
    }
}

/// A column of what some queues have of no ray.
fn if_kept<'a, T: Cell + 'a>(
    is_kept: bool,
    name: &'static str,
    about: &'static str,
    of: impl Fn(&RayRow) -> Option<T> + 'a,
) -> RayColumn<'a> {
    if is_kept { RayColumn::optional(name, about, of) } else { RayColumn::absent::<T>(name, about) }
}
