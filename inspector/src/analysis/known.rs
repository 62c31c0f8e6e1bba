//! What is known of a recording's arrays where they were read for something else, so that nobody reads them again.

use std::collections::HashMap;

use formats::manifest::QueueId;
use formats::reader::Dump;
use formats::stored_table::StoredTable;
use formats::traced::Traced;

use super::Metric;
use super::coherence::{Coherence, LaneUtilisation};
use super::tables::{Estimators, TableFill};

/// Queues of which something is known.
pub type KnownQueues = HashMap<QueueId, KnownQueue>;

/// What is known of a queue.
#[derive(Debug)]
pub struct KnownQueue {
    /// Its rays.
    pub rays: u64,
    /// Of the length table that its methods read.
    pub table: KnownTable,
    /// Of some of its orders, by method.
    pub orders: HashMap<String, KnownOrder>,
}

/// What is known of an order.
#[derive(Debug)]
pub struct KnownOrder {
    /// How coherent its groups are.
    pub coherence: Coherence,
    /// Its lane utilisation; none without the rays' work.
    pub lanes: Option<Vec<LaneUtilisation>>,
}

/// What is known of a length table.
#[derive(Clone, Debug)]
pub struct KnownTable {
    /// How full it is.
    pub fill: Metric<TableFill>,
    /// Errors of estimated lengths.
    pub estimators: Metric<Estimators>,
}

impl KnownTable {
    /// Of a queue's table, rays and traced lengths.
    pub fn of(
        dump: &Dump,
        traced: Result<(&Traced, &[f32]), String>,
        table: &Result<StoredTable, String>,
    ) -> Self {
        let estimators = match (traced, table) {
            (Err(reason), _) => Metric::missing(reason),
            (_, Err(reason)) => Metric::missing(reason),
            (Ok((traced, lengths)), Ok(table)) => {
                let estimators = Estimators::of(traced, lengths, table, constant_length(dump));
                estimators.ok_or("no ray has a length").into()
            }
        };
        Self { fill: table.as_ref().map(TableFill::of).map_err(String::clone).into(), estimators }
    }
}

/// A quarter of the scene's largest extent (docs/keys.md, "Estimated end").
const DEFAULT_TWO_POINT_LENGTH: f32 = 0.25;

/// The length that two-point assumes in this recording; its default where it was not measured or is
/// swept over, as in a replay.
fn constant_length(dump: &Dump) -> f32 {
    let two_point = dump.manifest().methods.iter().find(|method| method.name == "two-point");
    two_point.map_or(DEFAULT_TWO_POINT_LENGTH, |method| method.two_point_length)
}
