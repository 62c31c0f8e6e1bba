//! Orders that another tracer gave its queues: measured as they are, without a key of ours.

use formats::manifest::QueueId;

use crate::stages::setup::MethodPlan;

/// The orders of an import.
#[derive(Clone, Debug, Default)]
pub struct Foreign {
    /// Their names, with the layouts that their keys are said to be of; without a layout for keys of which
    /// nothing is said.
    pub methods: Vec<MethodPlan>,
    /// What each is of each queue.
    pub orders: Vec<ForeignOrder>,
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
    /// An entry for each ray, if the keys are there.
    pub keys: Option<ForeignKeys>,
}

/// Keys in canonical order, as they came.
#[derive(Clone, Debug)]
pub enum ForeignKeys {
    /// `<u4`.
    Narrow(Vec<u32>),
    /// `<u8`.
    Wide(Vec<u64>),
}

impl ForeignKeys {
    /// How many there are.
    pub fn count(&self) -> usize {
        match self {
            Self::Narrow(keys) => keys.len(),
            Self::Wide(keys) => keys.len(),
        }
    }

    /// Bits of each.
    pub fn bits(&self) -> u32 {
        match self {
            Self::Narrow(_) => 32,
            Self::Wide(_) => 64,
        }
    }
}

/// The order of this name that a queue can be traced in.
pub fn of<'a>(orders: &'a [ForeignOrder], queue: QueueId, name: &str) -> Option<&'a ForeignOrder> {
    orders.iter().find(|order| order.queue == queue && order.name == name && order.is_permutation)
}
