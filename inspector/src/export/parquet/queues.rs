//! The queues of a recording: a file for each of their orders.

use std::collections::HashMap;
use std::fs;
use std::sync::Arc;

use anyhow::Context;
use formats::key::method::UNSORTED;
use formats::manifest::{QueueId, QueueRecord};
use formats::reader::Dump;
use rayon::prelude::*;

use super::destination::Destination;
use super::found::{self, Found};
use super::rays::OrderedRays;
use super::{Recorded, Written, partition};
use crate::analysis::KnownQueues;
use crate::analysis::known::{KnownOrder, KnownQueue, KnownTable};
use crate::export::rays::RayChoice;
use crate::model::{Order, Queue};

/// The files of all rays, in the making.
pub(super) struct RayFiles<'a> {
    /// Where they go.
    pub(super) destination: Destination,
    /// Which rays.
    pub(super) choice: &'a RayChoice,
    /// What was written so far.
    pub(super) written: Written,
}

/// The rays of a queue and the orders to be written.
struct QueueRays<'a> {
    id: QueueId,
    methods: Vec<&'a str>,
    queue: Arc<Queue>,
    found: Vec<Found>,
}

/// A file that was written.
struct RayFile {
    rows: u64,
    bytes: u64,
    queue: QueueId,
    method: String,
    /// What was found of its order.
    order: Option<KnownOrder>,
}

impl RayFiles<'_> {
    /// Writes all rays of a recording that are chosen; gives what was found of their queues on the way.
    ///
    /// # Errors
    /// If they cannot be written. What cannot be read is left out.
    pub(super) fn add(&mut self, dump: &Dump, recorded: &Recorded) -> anyhow::Result<KnownQueues> {
        let chosen = dump.manifest().queues.iter().filter(|queue| self.choice.includes(queue.id));
        let chosen: Vec<&QueueRecord> = chosen.collect();
        let mut bounces = chosen.chunk_by(|a, b| (a.id.pass, a.id.bounce) == (b.id.pass, b.id.bounce));
        let mut known = KnownQueues::new();
        bounces.try_for_each(|queues| self.add_bounce(dump, queues, recorded, &mut known))?;
        Ok(known)
    }

    /// The rays of a bounce in each order: those of a pass that was not measured in canonical order alone.
    fn add_bounce(
        &mut self,
        dump: &Dump,
        queues: &[&QueueRecord],
        recorded: &Recorded,
        known: &mut KnownQueues,
    ) -> anyhow::Result<()> {
        let opened: Vec<_> = queues.par_iter().map(|record| self.open(dump, record)).collect();
        let mut queues = Vec::new();
        for opened in opened {
            match opened {
                Ok(queue) => {
                    known.insert(queue.id, self::known(dump, &queue.queue));
                    queues.push(queue);
                }
                Err(reason) => self.leave_out(recorded, &reason),
            }
        }
        let files: Vec<_> = queues
            .par_iter()
            .flat_map(|queue| queue.methods.par_iter().map(move |&method| (queue, method)))
            .map(|(queue, method)| self.write(dump, queue, method, recorded))
            .collect::<Result<_, _>>()?;
        for file in files {
            match file {
                Ok(file) => {
                    self.written.ray_files += 1;
                    self.written.rays += file.rows;
                    self.written.ray_bytes += file.bytes;
                    if let (Some(known), Some(order)) = (known.get_mut(&file.queue), file.order) {
                        known.orders.insert(file.method, order);
                    }
                }
                Err(reason) => self.leave_out(recorded, &reason),
            }
        }
        Ok(())
    }

    fn leave_out(&mut self, recorded: &Recorded, what: &str) {
        self.written.left_out.push(format!("{}, {what}", recorded.recording));
    }

    /// The rays of a queue, or why there are none.
    fn open<'q>(&self, dump: &Dump, record: &'q QueueRecord) -> Result<QueueRays<'q>, String> {
        let id = record.id;
        let mut methods: Vec<&str> = record.methods.iter().map(String::as_str).collect();
        if methods.is_empty() {
            methods.push(UNSORTED);
        }
        methods.retain(|method| self.choice.includes_method(method));
        let queue = Arc::new(Queue::open(dump, id).map_err(|reason| format!("{id}: {reason}"))?);
        let found = found::all(&queue);
        Ok(QueueRays { id, methods, queue, found })
    }

    /// Writes the rays of a queue in one order; gives what was written, or why nothing was.
    fn write(
        &self,
        dump: &Dump,
        &QueueRays { id, ref queue, ref found, .. }: &QueueRays<'_>,
        method: &str,
        recorded: &Recorded,
    ) -> anyhow::Result<Result<RayFile, String>> {
        let order = match Order::open(dump, queue.clone(), method) {
            Ok(order) => order,
            Err(reason) => return Ok(Err(format!("{id}: {method}: {reason}"))),
        };
        let folder = partition::folder(&recorded.scene, &recorded.machine, id, &partition::cut(method));
        let name = format!("{:05}-pass-{:03}.parquet", self.written.recordings, id.pass);
        let path = self.destination.rays_file(&folder, &name)?;
        let rows = OrderedRays {
            recording: &recorded.recording,
            order: &order,
            found,
            method: dump.manifest().methods.iter().find(|known| known.name == method),
            group_width: self.choice.group_width.rays(),
        };
        let (rows, order) = rows.write(path.clone())?;
        let bytes = fs::metadata(&path).with_context(|| format!("cannot find {}", path.display()))?.len();
        Ok(Ok(RayFile { rows, bytes, queue: id, method: method.to_owned(), order }))
    }
}

/// What is known of a queue before its orders are.
fn known(dump: &Dump, queue: &Queue) -> KnownQueue {
    let table = KnownTable::of(dump, Ok((&queue.traced, &queue.lengths)), &queue.table);
    KnownQueue { rays: queue.len() as u64, table, orders: HashMap::new() }
}
