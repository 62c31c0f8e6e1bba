//! What panels ask of the context that takes work: made on other threads and kept, in [`Derived`].

use std::sync::Arc;

use formats::hierarchy::Hierarchy;
use formats::key::Facts;
use formats::manifest::QueueId;
use formats::ray::Kind;
use formats::traced::Results;
use rayon::prelude::*;

use super::absent::Absent;
use super::background::Waker;
use super::coherences::OrderCoherence;
use super::context::{Context, opened};
use super::derived::{Derived, Filtered};
use super::groups::Groups;
use super::numbers::Numbers;
use super::order::Order;
use super::path::PathRay;
use super::queue::Queue;
use super::rows::{Rows, Sorting};
use super::selection::Selection;
use crate::analysis::costliest::{CostlyTriangle, costliest};
use crate::analysis::estimates::Estimates;
use crate::analysis::key_bits::KeyBits;
use crate::analysis::visits::Visits;

impl Context {
    /// Has a window drawn again when there is more to show.
    pub fn wake_with(&self, wake: impl Fn() + Send + Sync + 'static) {
        self.derived.waker.set(wake);
    }

    /// Who has the window drawn again, for what panels make on other threads.
    pub fn waker(&self) -> &Waker {
        &self.derived.waker
    }

    /// Waits for everything that is being made; whether anything was.
    pub fn finish(&mut self) -> bool {
        self.derived.waker.wait()
    }

    /// The orders of the queue that can be shown: recorded ones, and the one made here.
    pub fn methods(&self) -> Vec<String> {
        self.methods_of(self.selection.recording)
    }

    /// The orders of the same queue of any of the open recordings that can be shown.
    pub fn methods_of(&self, recording: usize) -> Vec<String> {
        let recording = self.recordings.get(recording);
        let recorded = recording.map_or(&[][..], |open| open.methods(self.selection.queue));
        let made = self.what_if.as_ref().map(|_| super::what_if::WHAT_IF.to_owned());
        recorded.iter().cloned().chain(made).collect()
    }

    /// The numbers of the rays of an order of the selected recording.
    pub fn numbers(&self, order: Arc<Order>) -> Option<Numbers> {
        let header = &self.recording()?.dump.manifest().header;
        Some(Numbers::of(order, header, self.selection.group_width))
    }

    /// Which rays of an order pass the filter.
    pub fn filtered(&mut self, order: &Arc<Order>) -> Filtered {
        let Some(expression) = self.selection.filter.in_force().cloned() else { return Filtered::All };
        let Some(numbers) = self.numbers(order.clone()) else { return Filtered::All };
        let wanted = ((order.serial, numbers.width), expression.clone());
        let find = move || numbers.passing(&expression).map(Arc::new);
        match self.derived.passing.of(wanted, &self.derived.waker, find) {
            // Nobody knows which pass where finding it out failed.
            Err(_) => Filtered::Unknown,
            Ok(Ok(passing)) => Filtered::Some(passing.clone()),
            Ok(Err(error)) => Filtered::Refused(error.clone()),
        }
    }

    /// The groups of an order; `None` until they are known.
    pub fn groups<'a>(&mut self, order: &'a Arc<Order>) -> Option<&'a Groups> {
        let width = self.selection.group_width;
        if order.known_groups(width).is_none() {
            let of = order.clone();
            let find = move || {
                of.groups(width);
            };
            // What it is asked for is in the order once it is known.
            let _ = self.derived.groups.of((order.serial, width), &self.derived.waker, find);
        }
        order.known_groups(width)
    }

    /// The rows of an order's rays that pass the filter; `None` until they are known.
    pub fn rows(&mut self, order: &Arc<Order>, sorting: Sorting) -> Option<Arc<Rows>> {
        let passing = match self.filtered(order) {
            Filtered::Unknown => return None,
            filtered => filtered.passing(),
        };
        let numbers = self.numbers(order.clone())?;
        let expression = passing.as_ref().and(self.selection.filter.in_force().cloned());
        let wanted = ((order.serial, numbers.width), expression, sorting);
        let make = move || Arc::new(Rows::of(&numbers, passing.as_deref(), sorting));
        self.derived.rows.of(wanted, &self.derived.waker, make).ok().cloned()
    }

    /// The what-if order of the queue.
    ///
    /// # Errors
    /// Why there is none, or not yet.
    pub fn what_if_order(&mut self) -> Result<Arc<Order>, Absent> {
        let settings = self.what_if.clone().ok_or("no what-if order was asked for; its panel makes one")?;
        let queue = self.queue()?;
        let recording = self.recording().ok_or("no recording is open")?;
        let (at, dump) = (recording.opening, recording.dump.clone());
        let wanted = (at, queue.id, settings.clone());
        let make = move || {
            let order = settings.order(&dump.manifest().header, queue)?;
            // Panels ask for it, and should not make the window wait.
            order.place_of_ray();
            Ok(Arc::new(order))
        };
        opened(self.derived.what_if.of(wanted, &self.derived.waker, make))
    }

    /// How coherent the what-if order is.
    ///
    /// # Errors
    /// Why there is no such order, or that it is not known yet.
    pub fn what_if_coherence(&mut self) -> Result<&OrderCoherence, Absent> {
        let (order, width) = (self.what_if_order()?, self.selection.group_width);
        let wanted = (order.serial, width);
        let find = move || OrderCoherence::of(&order, width);
        self.derived.what_if_coherence.of(wanted, &self.derived.waker, find)
    }

    /// What each bit of the what-if order's keys is worth.
    ///
    /// # Errors
    /// Why that cannot be said, or not yet.
    pub fn what_if_bits(&mut self) -> Result<Arc<KeyBits>, Absent> {
        let (order, width) = (self.what_if_order()?, self.selection.group_width);
        let wanted = (order.serial, width);
        let find = move || {
            let (keys, layout) = order.keys.as_ref().map_err(String::clone)?;
            let Queue { traced, lengths, .. } = &*order.queue;
            let used = layout.key_bits.min(layout.layout.bits().len() as u32);
            let bits = layout.key_bits - used..layout.key_bits;
            let found = KeyBits::of(traced, lengths, (keys, bits), width.rays());
            found.map(Arc::new).ok_or_else(|| "there are no rays, or some are not finite".to_owned())
        };
        opened(self.derived.what_if_bits.of(wanted, &self.derived.waker, find))
    }

    /// How coherent the queue's recorded orders are, as far as it is known in this frame, and how many orders
    /// there are. See [`Coherences::of`](super::coherences::Coherences::of).
    ///
    /// # Errors
    /// Why the queue cannot be shown, or not yet.
    pub fn coherences(&mut self, frame: u64) -> Result<(&[OrderCoherence], usize), Absent> {
        let queue = self.queue()?;
        let recording = self.recordings.get(self.selection.recording).ok_or("no recording is open")?;
        let Derived { waker, coherences, .. } = &mut self.derived;
        let known = coherences.of(recording, &queue, self.selection.group_width, (waker, frame));
        Ok((known, recording.methods(queue.id).len()))
    }

    /// Estimated against traced lengths of the queue.
    ///
    /// # Errors
    /// Why they are not known, or not yet.
    pub fn estimates(&mut self) -> Result<Arc<Estimates>, Absent> {
        let queue = self.queue()?;
        let at = self.recording().ok_or("no recording is open")?.opening;
        let wanted = (at, queue.id);
        let make = move || {
            let table = queue.table.as_ref().map_err(String::clone)?;
            Ok(Arc::new(Estimates::of(&queue.traced, &queue.lengths, table)))
        };
        opened(self.derived.estimates.of(wanted, &self.derived.waker, make))
    }

    /// The rays of the queue whose estimate comes from a cell, ascending; `None` until they are known.
    pub fn rays_of_cell(&mut self, cell: u32) -> Option<Arc<Vec<u32>>> {
        let queue = self.queue().ok()?;
        let recording = self.recording()?;
        let (at, header) = (recording.opening, &recording.dump.manifest().header);
        let encoder = header.cell_encoder()?;
        let wanted = (at, self.selection.queue, cell);
        let make = move || {
            let rays = queue.traced.rays().par_iter().enumerate();
            let found = rays.filter(|(_, ray)| encoder.encode(ray, Facts::default()) == u64::from(cell));
            Arc::new(found.map(|(ray, _)| ray as u32).collect::<Vec<u32>>())
        };
        self.derived.rays_of_cell.of(wanted, &self.derived.waker, make).ok().cloned()
    }

    /// The triangles of the queue whose rays cost most, and the nodes and triangles of all rays.
    ///
    /// # Errors
    /// Why they are not known, or not yet.
    pub fn costliest(&mut self) -> Result<(Arc<[CostlyTriangle]>, u64), Absent> {
        /// How many are found.
        const FOUND: usize = 10;
        let queue = self.queue()?;
        let at = self.recording().ok_or("no recording is open")?.opening;
        let make = move || {
            let Results::Hits(hits) = queue.traced.results() else {
                return Err("of shadow rays is not known which triangle stops them".to_owned());
            };
            let (found, all) = costliest(hits, queue.work.as_ref()?, FOUND);
            Ok((found.into(), all))
        };
        let wanted = (at, self.selection.queue);
        self.derived.costliest.of(wanted, &self.derived.waker, make)?.clone().map_err(Absent::from)
    }

    /// The boxes that a ray of an order and its group enter.
    ///
    /// # Errors
    /// Why they are not known, or not yet.
    pub fn visits(&mut self, order: &Arc<Order>, ray: usize) -> Result<Arc<Visits>, Absent> {
        let recording = self.recording().ok_or("no recording is open")?;
        let (dump, known) = (recording.dump.clone(), recording.hierarchy.clone());
        let width = self.selection.group_width;
        let wanted = ((order.serial, width), ray);
        let order = order.clone();
        let make = move || {
            let hierarchy = known.get_or_init(|| Hierarchy::open(&dump).map_err(|error| error.to_string()));
            let hierarchy = hierarchy.as_ref()?;
            let rays: Vec<usize> = order
                .places_of_group(order.group_of(ray, width), width)
                .map(|place| order.places.ray(place))
                .collect();
            Ok(Arc::new(Visits::of(hierarchy, &order.queue.traced, order.queue.id.kind, &rays, ray)))
        };
        opened(self.derived.visits.of(wanted, &self.derived.waker, make))
    }

    /// The rays of paths in the selected pass, by bounce; `None` until they are known. Of a single path they have
    /// their places in orders A and B, for which orders are searched through.
    pub fn paths(&mut self, mut paths: Vec<u32>) -> Option<Arc<[PathRay]>> {
        paths.sort_unstable();
        let recording = self.recording()?;
        let Selection { queue, method, baseline, .. } = &self.selection;
        // Order A of another recording is of other rays.
        let a = baseline.recording.is_none().then(|| baseline.method.clone());
        let methods = if paths.len() == 1 { [a, Some(method.clone())] } else { [None, None] };
        let dump = recording.dump.clone();
        let wanted = (recording.opening, queue.pass, paths.clone(), methods.clone());
        let queues = recording.queues().iter().map(|record| record.id);
        let mut queues: Vec<QueueId> = queues.filter(|found| found.pass == queue.pass).collect();
        queues.sort_by_key(|queue| (queue.bounce, queue.kind == Kind::Shadow));
        let make = move || {
            queues.into_iter().flat_map(|queue| PathRay::of(&dump, queue, &paths, &methods)).collect()
        };
        self.derived.paths.of(wanted, &self.derived.waker, make).ok().cloned()
    }
}
