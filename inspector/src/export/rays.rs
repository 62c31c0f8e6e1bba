//! The rays of one queue in one order, read where they lie in the recording.

use std::collections::BTreeSet;
use std::ops::Range;
use std::sync::Arc;

use anyhow::{Context, Error, bail};
use clap::Args;
use formats::key::method::UNSORTED;
use formats::manifest::QueueId;
use formats::metrics::capsule::Point;
use formats::ray::{Kind, Ray};
use formats::reader::Dump;
use formats::traced::Traced;

use crate::analysis::GroupWidth;
use crate::arguments;
use crate::filter::{Expression, FilterError};
use crate::model::numbers::Numbers;
use crate::model::path::on_paths;
use crate::model::recording::queue_records;
use crate::model::{Order, Queue};

/// Which rays, in which order.
#[derive(Clone, Debug, Args)]
pub(crate) struct RayChoice {
    /// The pass [default: the last that was kept; for parquet all].
    #[arg(long)]
    pass: Option<u32>,
    /// The bounce; 0 is the camera rays [default: 1; for parquet all].
    #[arg(long)]
    bounce: Option<u32>,
    /// The kind of rays [default: closest; for parquet both].
    #[arg(long, value_parser = arguments::kind())]
    kind: Option<Kind>,
    /// The order: a method, or unsorted [default: unsorted; for parquet all].
    #[arg(long)]
    method: Option<String>,
    /// One group of the order alone, counted from 0.
    #[arg(long)]
    pub(super) group: Option<usize>,
    /// Rays in a group.
    #[arg(long, value_enum, default_value_t)]
    pub(super) group_width: GroupWidth,
    /// Only the rays that meet a condition, such as 'hit && length < 0.1'; capsules are left out, as they
    /// are those of whole groups.
    #[arg(long, value_name = "EXPR")]
    pub(super) filter: Option<String>,
}

impl RayChoice {
    /// The queue that is meant.
    fn queue(&self, dump: &Dump) -> anyhow::Result<QueueId> {
        let (bounce, kind) = (self.bounce.unwrap_or(1), self.kind.unwrap_or(Kind::Closest));
        let queues = queue_records(dump);
        let is_meant = |id: &QueueId| id.bounce == bounce && id.kind == kind && self.includes(*id);
        let meant = queues.iter().map(|queue| queue.id).filter(is_meant).max();
        meant.with_context(|| {
            let kept: Vec<String> = queues.iter().map(|queue| queue.id.to_string()).collect();
            let pass = self.pass.map_or(String::new(), |pass| format!(" in pass {pass}"));
            let root = dump.root().display();
            format!("{root} has no {kind} rays of bounce {bounce}{pass}; it has: {}", kept.join(", "))
        })
    }

    /// Whether a queue is meant where all are that nothing leaves out.
    pub(super) fn includes(&self, queue: QueueId) -> bool {
        self.pass.is_none_or(|pass| pass == queue.pass)
            && self.bounce.is_none_or(|bounce| bounce == queue.bounce)
            && self.kind.is_none_or(|kind| kind == queue.kind)
    }

    /// Whether it leaves any rays out.
    pub(super) fn names_rays(&self) -> bool {
        self.pass.is_some() || self.bounce.is_some() || self.kind.is_some() || self.method.is_some()
    }

    /// Whether an order is, likewise.
    pub(super) fn includes_method(&self, method: &str) -> bool {
        self.method.as_ref().is_none_or(|meant| meant == method)
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

/// Rays of a queue in an order.
pub(crate) struct ChosenRays {
    order: Arc<Order>,
    /// Places of the order, ascending.
    places: Vec<u32>,
}

/// One ray with its end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RayAtPlace {
    /// Place in the order.
    pub(crate) place: usize,
    /// Canonical index.
    pub(crate) index: usize,
    pub(crate) ray: Ray,
    /// Where it stops, world units: at its hit, its light, or where it leaves the scene.
    pub(crate) termination: Point,
}

impl ChosenRays {
    /// Opens what a choice names.
    pub(crate) fn open(dump: &Dump, choice: &RayChoice) -> anyhow::Result<Self> {
        let queue = Queue::open(dump, choice.queue(dump)?).map_err(Error::msg)?;
        let method = choice.method.as_deref().unwrap_or(UNSORTED);
        let order = Order::open(dump, Arc::new(queue), method).map_err(Error::msg)?;
        let order = Arc::new(order);
        let places = choice.places(order.len())?;
        let places = match &choice.filter {
            Some(filter) => {
                let numbers = Numbers::of(order.clone(), &dump.manifest().header, choice.group_width);
                passing(&numbers, filter, &places)?
            }
            None => places.map(|place| place as u32).collect(),
        };
        Ok(Self { order, places })
    }

    /// The queue that they are of.
    pub(crate) fn queue(&self) -> &Queue {
        &self.order.queue
    }

    /// What they are ordered by.
    pub(crate) fn method(&self) -> &str {
        &self.order.method
    }

    /// How many there are.
    pub(crate) fn len(&self) -> usize {
        self.places.len()
    }

    /// How far along the order a place is, 0 to 1.
    pub(crate) fn part(&self, place: usize) -> f64 {
        place as f64 / self.order.len().saturating_sub(1).max(1) as f64
    }

    /// All of them in their order.
    pub(crate) fn iter(&self) -> impl Iterator<Item = RayAtPlace> + '_ {
        self.places.iter().map(|&place| self.at(place as usize))
    }

    fn at(&self, place: usize) -> RayAtPlace {
        let (queue, index) = (&self.order.queue, self.order.places.ray(place));
        let ray = queue.traced.rays()[index];
        RayAtPlace { place, index, ray, termination: termination(&queue.traced, index) }
    }

    /// The rays of all bounces of their pass that are on the paths of these, each with its bounce, from its origin to
    /// where it stops, world units. Shadow rays are among them.
    pub(crate) fn on_their_paths(&self, dump: &Dump) -> anyhow::Result<Vec<(u32, [Point; 2])>> {
        let pass = self.queue().id.pass;
        let paths: BTreeSet<u32> = self.iter().map(|ray| self.queue().path_ids[ray.index]).collect();
        let paths: Vec<u32> = paths.into_iter().collect();
        let mut found = Vec::new();
        let queues = queue_records(dump);
        for id in queues.iter().map(|record| record.id).filter(|id| id.pass == pass) {
            let (traced, rays) = on_paths(dump, id, &paths).map_err(Error::msg)?;
            found.extend(rays.into_iter().map(|(_, ray)| {
                (id.bounce, [traced.rays()[ray].origin.map(f64::from), termination(&traced, ray)])
            }));
        }
        Ok(found)
    }
}

/// Where a ray stops, world units.
fn termination(traced: &Traced, index: usize) -> Point {
    let ray = traced.rays()[index];
    let length = f64::from(traced.length(index)) / f64::from(traced.unit().scale);
    // A ray without a direction never leaves.
    let length = if length.is_finite() { length } else { 0.0 };
    [0, 1, 2].map(|axis| f64::from(ray.origin[axis]) + length * f64::from(ray.direction[axis]))
}

/// Which of these places pass a filter.
fn passing(numbers: &Numbers, filter: &str, places: &Range<usize>) -> anyhow::Result<Vec<u32>> {
    let wrong = |error: FilterError| Error::msg(format!("--filter: {}", error.shown(filter)));
    let expression = Expression::parse(filter).map_err(wrong)?;
    let passing = numbers.passing(&expression).map_err(wrong)?;
    Ok(passing.places()[passing.between(places)].to_vec())
}
