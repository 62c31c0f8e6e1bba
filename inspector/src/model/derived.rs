//! What panels ask for that takes work: it is made on other threads and kept.

use std::sync::Arc;

use formats::manifest::QueueId;

use super::background::{Background, Waker};
use super::coherences::{Coherences, OrderCoherence};
use super::order::Order;
use super::path::PathRay;
use super::rows::{Rows, Sorting};
use super::what_if::Settings;
use crate::analysis::GroupWidth;
use crate::analysis::costliest::CostlyTriangle;
use crate::analysis::estimates::Estimates;
use crate::analysis::key_bits::KeyBits;
use crate::analysis::visits::Visits;
use crate::filter::{Expression, FilterError, Passing};

/// The rays of paths: of which opening of a recording, pass and paths, and orders A and B.
type WantedPaths = (u64, u32, Vec<u32>, [Option<String>; 2]);

/// Serial number of an order, and rays of a group.
pub(crate) type Grouped = (u64, GroupWidth);

/// Which rows: of which order, what its rays must meet, what they are sorted by.
type WantedRows = (Grouped, Option<Arc<Expression>>, Sorting);

/// Triangles, and the steps of all rays.
type Costliest = (Arc<[CostlyTriangle]>, u64);

/// What was made of orders and queues.
#[derive(Debug, Default)]
pub struct Derived {
    pub(super) waker: Waker,
    pub(super) coherences: Coherences,
    pub(super) groups: Background<Grouped, ()>,
    pub(super) passing: Background<(Grouped, Arc<Expression>), Result<Arc<Passing>, FilterError>>,
    pub(super) rows: Background<WantedRows, Arc<Rows>>,
    pub(super) what_if: Background<(u64, QueueId, Settings), Result<Arc<Order>, String>>,
    pub(super) what_if_coherence: Background<Grouped, OrderCoherence>,
    pub(super) what_if_bits: Background<Grouped, Result<Arc<KeyBits>, String>>,
    pub(super) estimates: Background<(u64, QueueId), Result<Arc<Estimates>, String>>,
    pub(super) paths: Background<WantedPaths, Arc<[PathRay]>>,
    pub(super) costliest: Background<(u64, QueueId), Result<Costliest, String>>,
    pub(super) visits: Background<(Grouped, usize), Result<Arc<Visits>, String>>,
    pub(super) rays_of_cell: Background<(u64, QueueId, u32), Arc<Vec<u32>>>,
}

/// Which rays of the order pass the filter.
#[derive(Clone, Debug)]
pub enum Filtered {
    /// All, as there is no filter.
    All,
    /// It is still being found out.
    Unknown,
    /// These.
    Some(Arc<Passing>),
    /// None can be told, as the filter asks for what is not known of them.
    Refused(FilterError),
}

impl Filtered {
    /// The rays that pass; `None` if all do. While it is not known, none do.
    pub fn passing(&self) -> Option<Arc<Passing>> {
        match self {
            Self::All | Self::Refused(_) => None,
            Self::Unknown => Some(Arc::default()),
            Self::Some(passing) => Some(passing.clone()),
        }
    }

    /// Whether the ray at a place passes.
    pub fn contains(&self, place: usize) -> bool {
        match self {
            Self::All | Self::Refused(_) => true,
            Self::Unknown => false,
            Self::Some(passing) => passing.contains(place),
        }
    }
}
