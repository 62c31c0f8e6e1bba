//! The numbers of one queue.

use formats::key::method::UNSORTED;
use formats::manifest::{QueueId, QueueRecord};
use formats::metrics::samples::Samples;
use formats::ray::Kind;
use formats::reader::Dump;
use serde::{Deserialize, Serialize};

use super::Metric;
use super::arrays::QueueArrays;
use super::known::KnownQueues;
use super::options::AnalysisOptions;
use super::order::{OrderAnalysis, QueueContext};
use super::tables::{Estimators, TableFill};

/// The numbers of one queue.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct QueueAnalysis {
    /// Pass, from 0.
    pub pass: u32,
    /// Bounce, from 0.
    pub bounce: u32,
    /// Kind of its rays.
    pub kind: Kind,
    /// Rays.
    pub rays: u64,
    /// How full the length table was that its methods read.
    pub table: Metric<TableFill>,
    /// Errors of estimated lengths.
    pub estimators: Metric<Estimators>,
    /// Its orders, `unsorted` first; none in a pass that was not measured.
    pub orders: Vec<OrderAnalysis>,
}

impl QueueAnalysis {
    /// Which queue it is.
    pub fn id(&self) -> QueueId {
        QueueId { pass: self.pass, bounce: self.bounce, kind: self.kind }
    }

    /// All of a recording, in the order in which they were traced.
    pub(super) fn all(dump: &Dump, options: &AnalysisOptions, known: &KnownQueues) -> Vec<Self> {
        let samples = Samples::of(dump.manifest());
        let of = |queue| Self::of(dump, queue, &samples, options, known);
        dump.manifest().queues.iter().map(of).collect()
    }

    fn of(
        dump: &Dump,
        record: &QueueRecord,
        samples: &Samples<'_>,
        options: &AnalysisOptions,
        known: &KnownQueues,
    ) -> Self {
        let queue = record.id;
        let arrays = QueueArrays::new(dump, record, options.depth);
        let known = known.get(&queue).filter(|known| known.rays == record.rays);
        let table = known.map_or_else(|| arrays.table(), |known| known.table.clone());
        let context =
            QueueContext { dump, queue, rays: record.rays, samples, arrays: &arrays, options, known };
        let mut methods: Vec<&str> = record.methods.iter().map(String::as_str).collect();
        methods.sort_by_key(|&method| method != UNSORTED);
        let orders = methods.into_iter().map(|method| context.order(method)).collect();
        let QueueId { pass, bounce, kind } = queue;
        Self {
            pass,
            bounce,
            kind,
            rays: record.rays,
            table: table.fill,
            estimators: table.estimators,
            orders,
        }
    }

    /// A method's order, if it was measured.
    pub fn order(&self, method: &str) -> Option<&OrderAnalysis> {
        self.orders.iter().find(|order| order.method == method)
    }
}
