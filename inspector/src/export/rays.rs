//! The rays of one queue in one order, read where they lie in the recording.

use std::ops::Range;
use std::sync::Arc;

use anyhow::{Context, Error, bail};
use formats::manifest::{MethodArray, Place, QueueArray, QueueId};
use formats::ray::{Hit, Kind, Ray};
use formats::reader::{Dump, Mapped};
use formats::unit_space::UnitSpace;

use super::capsule::Point;
use crate::analysis::GroupWidth;
use crate::model::filter::{self, Expression};
use crate::model::numbers::Numbers;
use crate::model::{Order, Queue};

/// Which rays, in which order.
#[derive(Clone, Debug)]
pub(crate) struct Selection {
    /// The last that was kept if `None`.
    pub(crate) pass: Option<u32>,
    pub(crate) bounce: u32,
    pub(crate) kind: Kind,
    pub(crate) method: String,
    /// One group alone.
    pub(crate) group: Option<usize>,
    pub(crate) group_width: GroupWidth,
    /// A condition that rays must meet.
    pub(crate) filter: Option<String>,
}

impl Selection {
    /// The queue that is meant.
    fn queue(&self, dump: &Dump) -> anyhow::Result<QueueId> {
        let queues = &source_of(dump).manifest().queues;
        let is_meant = |id: &QueueId| {
            id.bounce == self.bounce && id.kind == self.kind && self.pass.is_none_or(|pass| pass == id.pass)
        };
        let meant = queues.iter().map(|queue| queue.id).filter(is_meant).max();
        meant.with_context(|| {
            let kept: Vec<String> = queues.iter().map(|queue| queue.id.to_string()).collect();
            let pass = self.pass.map_or(String::new(), |pass| format!(" in pass {pass}"));
            let root = dump.root().display();
            format!(
                "{root} has no {} rays of bounce {}{pass}; it has: {}",
                self.kind,
                self.bounce,
                kept.join(", ")
            )
        })
    }

    /// The places of the order that are meant, of so many.
    fn places(&self, rays: usize) -> anyhow::Result<Range<usize>> {
        let Some(group) = self.group else { return Ok(0..rays) };
        let first = group.saturating_mul(self.group_width.rays());
        if first >= rays {
            bail!("there is no group {group}: there are {}", rays.div_ceil(self.group_width.rays()));
        }
        Ok(first..(first + self.group_width.rays()).min(rays))
    }
}

/// The recording that has the rays: a replay's source.
fn source_of(dump: &Dump) -> &Dump {
    if dump.manifest().queues.is_empty() { dump.source().unwrap_or(dump) } else { dump }
}

/// What is known of a queue's rays, mapped, in canonical order.
pub(crate) struct Rays {
    pub(crate) id: QueueId,
    pub(crate) method: String,
    unit_space: UnitSpace,
    rays: Mapped<Ray>,
    path_ids: Mapped<u32>,
    ends: Ends,
    /// Canonical index at each place of the order; none for canonical order itself.
    permutation: Option<Mapped<u32>>,
    /// Places of the order that were asked for.
    places: Places,
}

/// Places of an order, ascending.
enum Places {
    Range(Range<usize>),
    /// Those that pass a filter.
    Listed(Vec<u32>),
}

/// Where rays end.
enum Ends {
    Closest(Mapped<Hit>),
    Shadow { distances: Mapped<f32>, lights: Mapped<u32> },
}

/// One ray with its end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RayAtPlace {
    /// Place in the order.
    pub(crate) place: usize,
    /// Canonical index.
    pub(crate) index: usize,
    pub(crate) path_id: u32,
    pub(crate) ray: Ray,
    pub(crate) end: End,
    /// Where it stops, world units: at its hit, its light, or where it leaves the scene.
    pub(crate) termination: Point,
}

/// How a ray ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum End {
    Closest(Hit),
    /// Distance to the occluder, `+inf` if the light is seen, and which light.
    Shadow {
        distance: f32,
        light: u32,
    },
}

impl End {
    /// Whether it ends at a surface.
    pub(crate) fn is_at_surface(&self) -> bool {
        match self {
            Self::Closest(hit) => hit.is_hit(),
            Self::Shadow { distance, .. } => distance.is_finite(),
        }
    }
}

impl Rays {
    /// Opens what a selection names.
    pub(crate) fn open(dump: &Dump, selection: &Selection) -> anyhow::Result<Self> {
        let id = selection.queue(dump)?;
        let rays: Mapped<Ray> = dump.array(&Place::Queue(id, QueueArray::Rays))?;
        let path_ids = dump.array(&Place::Queue(id, QueueArray::PathIds))?;
        let ends = match id.kind {
            Kind::Closest => Ends::Closest(dump.array(&Place::Queue(id, QueueArray::Hits))?),
            Kind::Shadow => Ends::Shadow {
                distances: dump.array(&Place::Queue(id, QueueArray::Distances))?,
                lights: dump.array(&Place::Queue(id, QueueArray::Lights))?,
            },
        };
        let method = selection.method.clone();
        let permutation = if method == formats::key::method::UNSORTED {
            None
        } else {
            let place = Place::Method(id, method.clone(), MethodArray::Permutation);
            let permutation: Mapped<u32> = dump.array(&place)?;
            formats::permutation::check_bijection(&permutation, rays.len()).context(place.to_string())?;
            Some(permutation)
        };
        let ends_count = match &ends {
            Ends::Closest(hits) => hits.len(),
            Ends::Shadow { distances, lights } => distances.len().min(lights.len()),
        };
        if path_ids.len() != rays.len() || ends_count != rays.len() {
            bail!(
                "{id} has {} rays, {} paths and {ends_count} ends; expected as many of each",
                rays.len(),
                path_ids.len()
            );
        }
        let places = selection.places(rays.len())?;
        let places = match &selection.filter {
            Some(filter) => Places::Listed(passing(dump, id, selection, filter, &places)?),
            None => Places::Range(places),
        };
        let scene = &dump.manifest().header.scene;
        let unit_space = UnitSpace::from_bounds(scene.bounds_min, scene.bounds_max);
        Ok(Self { id, method, unit_space, rays, path_ids, ends, permutation, places })
    }

    /// How many there are.
    pub(crate) fn len(&self) -> usize {
        match &self.places {
            Places::Range(places) => places.len(),
            Places::Listed(places) => places.len(),
        }
    }

    /// How far along the order a place is, 0 to 1.
    pub(crate) fn part(&self, place: usize) -> f64 {
        place as f64 / self.rays.len().saturating_sub(1).max(1) as f64
    }

    /// All of them in their order.
    pub(crate) fn iter(&self) -> impl Iterator<Item = RayAtPlace> + '_ {
        let place = |at: usize| match &self.places {
            Places::Range(places) => places.start + at,
            Places::Listed(places) => places[at] as usize,
        };
        (0..self.len()).map(move |at| self.at(place(at)))
    }

    fn at(&self, place: usize) -> RayAtPlace {
        let index = self.permutation.as_ref().map_or(place, |permutation| permutation[place] as usize);
        let ray = self.rays[index];
        let (end, unit_length) = match &self.ends {
            Ends::Closest(hits) => {
                (End::Closest(hits[index]), self.unit_space.closest_length(&ray, &hits[index]))
            }
            Ends::Shadow { distances, lights } => {
                let distance = distances[index];
                let end = End::Shadow { distance, light: lights[index] };
                (end, self.unit_space.shadow_length(&ray, distance))
            }
        };
        let length = f64::from(unit_length) / f64::from(self.unit_space.scale);
        // A ray without a direction never leaves.
        let length = if length.is_finite() { length } else { 0.0 };
        let termination =
            [0, 1, 2].map(|axis| f64::from(ray.origin[axis]) + length * f64::from(ray.direction[axis]));
        RayAtPlace { place, index, path_id: self.path_ids[index], ray, end, termination }
    }
}

/// Which of these places pass a filter.
fn passing(
    dump: &Dump,
    id: QueueId,
    selection: &Selection,
    filter: &str,
    places: &Range<usize>,
) -> anyhow::Result<Vec<u32>> {
    let wrong = |error: filter::FilterError| Error::msg(format!("--filter: {}", error.shown(filter)));
    let expression = Expression::parse(filter).map_err(wrong)?;
    let queue = Arc::new(Queue::open(dump, id).map_err(Error::msg)?);
    let order = Arc::new(Order::open(dump, queue, &selection.method).map_err(Error::msg)?);
    let numbers = Numbers::of(order, &dump.manifest().header, selection.group_width);
    let passing = filter::passing(&expression, &numbers).map_err(wrong)?;
    Ok(passing.places()[passing.between(places)].to_vec())
}
