//! The arrays of a queue that its orders share.

use formats::manifest::{QueueId, QueueRecord};
use formats::ray::Work;
use formats::reader::{Dump, Loaded};
use formats::stored_table::StoredTable;
use formats::traced::Traced;

use super::options::Depth;
use super::tables::{Estimators, TableFill};
use super::{Metric, work};

/// A quarter of the scene's largest extent (KEYS, "Termination point").
const DEFAULT_TWO_POINT_LENGTH: f32 = 0.25;

/// The length that two-point assumes in this recording; its default where it was not measured or is
/// swept over, as in a replay.
fn constant_length(dump: &Dump) -> f32 {
    let two_point = dump.manifest().methods.iter().find(|method| method.name == "two-point");
    two_point.map_or(DEFAULT_TWO_POINT_LENGTH, |method| method.two_point_length)
}

/// The arrays of a queue that its orders share; where they are not to be had, why.
#[derive(Debug)]
pub(super) struct QueueArrays {
    /// The rays with their results, and the traced length of each.
    pub(super) traced: Result<(Traced, Vec<f32>), String>,
    pub(super) work: Result<Loaded<Work>, String>,
    is_read: bool,
}

impl QueueArrays {
    /// Why there are no numbers of arrays that were not to be read.
    pub(super) const NOT_READ: &str = "the arrays were not read";

    pub(super) fn open(dump: &Dump, record: &QueueRecord, depth: Depth) -> Self {
        if depth == Depth::Manifest {
            let unread = || Self::NOT_READ.to_owned();
            return Self { traced: Err(unread()), work: Err(unread()), is_read: false };
        }
        let of_all = |name: &str, found: usize| {
            let problem = || {
                let queue = record.id;
                format!(
                    "{queue}/{name}.npy has {found} entries for {} rays; `inspector verify` says what is wrong",
                    record.rays
                )
            };
            (found as u64 == record.rays).then_some(()).ok_or_else(problem)
        };
        let traced = || {
            let traced = Traced::open(dump, record.id).map_err(|error| error.to_string())?;
            of_all("rays", traced.rays().len())?;
            let lengths = traced.lengths();
            Ok((traced, lengths))
        };
        let work = || {
            let work = work::work(dump, record.id)?;
            of_all("work", work.len())?;
            Ok(work)
        };
        Self { traced: traced(), work: work(), is_read: true }
    }

    /// Fill of the table that the queue's methods read, and errors of estimated lengths.
    pub(super) fn table(&self, dump: &Dump, queue: QueueId) -> (Metric<TableFill>, Metric<Estimators>) {
        if !self.is_read {
            return (Metric::missing(Self::NOT_READ), Metric::missing(Self::NOT_READ));
        }
        let table = StoredTable::open(dump, queue).map_err(|error| error.to_string());
        let estimators = match (&self.traced, &table) {
            (Err(reason), _) | (_, Err(reason)) => Metric::missing(reason),
            (Ok((traced, lengths)), Ok(table)) => {
                let estimators = Estimators::of(traced, lengths, table, constant_length(dump));
                estimators.ok_or("no ray has a length").into()
            }
        };
        (table.as_ref().map(TableFill::of).map_err(String::clone).into(), estimators)
    }
}
