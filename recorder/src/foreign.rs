//! Orders that another tracer gave its queues: measured as they are, without a key of ours.

use anyhow::{Result, ensure};
use formats::key::{Extent, Layout, LayoutText};
use formats::manifest::{MethodArray, MethodRecord, Place, QueueId, QueueRecord};
use formats::npy::Dtype;
use formats::permutation::check_bijection;
use formats::reader::Dump;

use crate::stages::setup::MethodPlan;
use crate::stages::sort::cpu::Words;

/// The orders of an import, or those that a replay carries along.
#[derive(Clone, Debug, Default)]
pub struct Foreign {
    /// Their names, with the layouts that their keys are said to be of; without a layout for keys of which
    /// nothing is said.
    pub methods: Vec<MethodPlan>,
    /// What each is of each queue.
    pub orders: Vec<ForeignOrder>,
}

impl Foreign {
    /// The orders of another tracer that a recording holds. `notices` gets a sentence for each that cannot be measured.
    ///
    /// # Errors
    /// If an array of one is damaged or has not an entry for each ray, or its layout is none.
    pub fn recorded(dump: &Dump, extent: Extent, notices: &mut Vec<String>) -> Result<Self> {
        let mut foreign = Self::default();
        let manifest = dump.manifest();
        for record in manifest.foreign_orders() {
            let found = manifest.queues.iter().map(|queue| ForeignOrder::recorded(dump, queue, &record.name));
            let orders: Vec<ForeignOrder> = found.filter_map(Result::transpose).collect::<Result<_>>()?;
            if orders.is_empty() {
                notices.push(format!(
                    "the order {} of another tracer is left out: its permutations were not kept",
                    record.name
                ));
                continue;
            }
            foreign.orders.extend(orders);
            foreign.methods.push(plan(record, extent)?);
        }
        notices.extend(foreign.check());
        Ok(foreign)
    }

    /// Finds what can be measured; a sentence for each order that is no permutation.
    pub fn check(&mut self) -> Vec<String> {
        let problem = |order: &mut ForeignOrder| {
            let checked = check_bijection(&order.permutation, order.permutation.len());
            order.is_permutation = checked.is_ok();
            let (name, queue) = (&order.name, order.queue);
            checked
                .err()
                .map(|error| format!("the order {name} of {queue} is kept and not measured: {error}"))
        };
        self.orders.iter_mut().filter_map(problem).collect()
    }
}

/// The method that an order is recorded as.
fn plan(record: &MethodRecord, extent: Extent) -> Result<MethodPlan> {
    let layout = if record.has_layout() {
        LayoutText::parse(&record.text)?.expand(extent)?
    } else {
        Layout::default()
    };
    Ok(MethodPlan {
        name: record.name.clone(),
        base: record.base.clone(),
        text: record.text.clone(),
        layout,
        termination: record.termination,
        key_bits: record.key_bits,
        two_point_length: record.two_point_length,
        for_kinds: [true; 2],
    })
}

/// One order of one queue.
#[derive(Clone, Debug)]
pub struct ForeignOrder {
    /// The queue.
    pub queue: QueueId,
    /// Name of the order.
    pub name: String,
    /// An entry for each ray; what is no permutation is kept and not measured.
    pub permutation: Vec<u32>,
    /// Whether it has each ray once.
    pub is_permutation: bool,
    /// In canonical order, an entry for each ray, if the keys are there.
    pub keys: Option<Words>,
}

impl ForeignOrder {
    /// That of a recorded queue, if its permutation was kept.
    fn recorded(dump: &Dump, record: &QueueRecord, name: &str) -> Result<Option<Self>> {
        let queue = record.id;
        let place = |array| Place::Method(queue, name.to_owned(), array);
        if !dump.has(&place(MethodArray::Permutation)) {
            return Ok(None);
        }
        let keys = place(MethodArray::Keys);
        let keys = match dump.record(&keys).map(|record| record.dtype) {
            None => None,
            Some(Dtype::U8) => Some(Words::Wide(dump.checked_array(&keys)?.to_vec())),
            Some(_) => Some(Words::Narrow(dump.checked_array(&keys)?.to_vec())),
        };
        let permutation = dump.checked_array(&place(MethodArray::Permutation))?.to_vec();
        let counts = keys.iter().map(|keys| (MethodArray::Keys, keys.len()));
        for (array, found) in counts.chain([(MethodArray::Permutation, permutation.len())]) {
            let (place, rays) = (place(array), record.rays);
            ensure!(found as u64 == rays, "{place} has {found} entries, but the queue has {rays} rays");
        }
        Ok(Some(Self { queue, name: name.to_owned(), permutation, is_permutation: false, keys }))
    }
}

/// The order of this name that a queue can be traced in.
pub fn of<'a>(orders: &'a [ForeignOrder], queue: QueueId, name: &str) -> Option<&'a ForeignOrder> {
    orders.iter().find(|order| order.queue == queue && order.name == name && order.is_permutation)
}
