//! The arrays of a queue that its orders share.

use std::cell::OnceCell;

use formats::manifest::QueueRecord;
use formats::ray::Work;
use formats::reader::{Dump, Loaded};
use formats::stored_table::StoredTable;
use formats::traced::Traced;

use super::known::KnownTable;
use super::options::Depth;
use super::{Metric, work};

/// The arrays of a queue that its orders share, each read when it is first asked for; where they are not to be had, why.
#[derive(Debug)]
pub(super) struct QueueArrays<'a> {
    dump: &'a Dump,
    record: &'a QueueRecord,
    depth: Depth,
    traced: OnceCell<Result<(Traced, Vec<f32>), String>>,
    work: OnceCell<Result<Loaded<Work>, String>>,
}

impl<'a> QueueArrays<'a> {
    /// Why there are no numbers of arrays that were not to be read.
    pub(super) const NOT_READ: &'static str = "the arrays were not read";

    pub(super) fn new(dump: &'a Dump, record: &'a QueueRecord, depth: Depth) -> Self {
        Self { dump, record, depth, traced: OnceCell::new(), work: OnceCell::new() }
    }

    /// The rays with their results, and the traced length of each.
    pub(super) fn traced(&self) -> Result<(&Traced, &[f32]), String> {
        let read = || {
            self.check_depth()?;
            let traced = Traced::open(self.dump, self.record.id).map_err(|error| error.to_string())?;
            self.check_count("rays", traced.rays().len())?;
            let lengths = traced.lengths();
            Ok((traced, lengths))
        };
        let (traced, lengths) = self.traced.get_or_init(read).as_ref().map_err(String::clone)?;
        Ok((traced, lengths))
    }

    /// What each ray took.
    pub(super) fn work(&self) -> Result<&[Work], String> {
        let read = || {
            self.check_depth()?;
            let work = work::work(self.dump, self.record.id)?;
            self.check_count("work", work.len())?;
            Ok(work)
        };
        Ok(self.work.get_or_init(read).as_ref().map_err(String::clone)?)
    }

    /// Of the table that the queue's methods read.
    pub(super) fn table(&self) -> KnownTable {
        if let Err(why) = self.check_depth() {
            return KnownTable { fill: Metric::missing(&why), estimators: Metric::missing(&why) };
        }
        let table = StoredTable::open(self.dump, self.record.id).map_err(|error| error.to_string());
        KnownTable::of(self.dump, self.traced(), &table)
    }

    fn check_depth(&self) -> Result<(), String> {
        if self.depth == Depth::Manifest { Err(Self::NOT_READ.to_owned()) } else { Ok(()) }
    }

    fn check_count(&self, name: &str, found: usize) -> Result<(), String> {
        let QueueRecord { id, rays, .. } = self.record;
        if found as u64 == *rays {
            return Ok(());
        }
        Err(format!(
            "{id}/{name}.npy has {found} entries for {rays} rays; `inspector verify` says what is wrong"
        ))
    }
}
