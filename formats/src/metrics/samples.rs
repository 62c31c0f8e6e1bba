//! The samples of a recording, by queue and order.

use std::collections::BTreeMap;

use super::speedup::StageSamples;
use crate::manifest::{Manifest, QueueId, TimingRecord, Way};

/// The samples of a recording.
#[derive(Debug, Default)]
pub struct Samples<'a> {
    by_order: BTreeMap<(QueueId, &'a str), StageSamples>,
    ways: BTreeMap<&'a str, Way>,
}

impl<'a> Samples<'a> {
    /// All that a manifest has. Stages that serve both kinds belong to no order and are left out.
    pub fn of(manifest: &'a Manifest) -> Self {
        let mut by_order: BTreeMap<_, StageSamples> = BTreeMap::new();
        for TimingRecord { pass, bounce, kind, method, stage, samples_ns } in &manifest.timings {
            let Some(kind) = *kind else { continue };
            let queue = QueueId { pass: *pass, bounce: *bounce, kind };
            let stages = by_order.entry((queue, method.as_str())).or_default();
            stages.of_mut(*stage).extend(samples_ns);
        }
        let ways = manifest.ways.iter().map(|record| (record.method.as_str(), record.way));
        Self { by_order, ways: ways.collect() }
    }

    /// How sorted rays are traced in a method's totals: the way that the recording chose, else, as until
    /// version 2, the one with the shorter median in this queue.
    pub fn way(&self, queue: QueueId, method: &'a str) -> Way {
        let shorter = || self.get(queue, method).map_or(Way::Gathered, StageSamples::shorter_way);
        self.ways.get(method).copied().unwrap_or_else(shorter)
    }

    /// Those of one order.
    pub fn get(&self, queue: QueueId, method: &'a str) -> Option<&StageSamples> {
        self.by_order.get(&(queue, method))
    }

    /// Every queue and order that has any, by queue.
    pub fn orders(&self) -> impl Iterator<Item = (QueueId, &'a str)> + '_ {
        self.by_order.keys().copied()
    }
}
