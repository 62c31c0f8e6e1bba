//! The numbers of one order of one queue.

use std::cell::LazyCell;

use formats::key::Termination;
use formats::key::method::{AUTO, SHUFFLED, UNSORTED};
use formats::manifest::{CacheRecord, Manifest, MethodRecord, QueueId, Stage, Way};
use formats::metrics::bandwidth::{KeyTraffic, Traffic};
use formats::metrics::order::Places;
use formats::metrics::samples::Samples;
use formats::metrics::speedup::StageSamples;
use formats::reader::Dump;
use serde::{Deserialize, Serialize};

use super::Metric;
use super::arrays::QueueArrays;
use super::coherence::{Coherence, LaneUtilisation, coherence, lanes, of_warp};
use super::known::{KnownOrder, KnownQueue};
use super::options::{AnalysisOptions, Depth};
use super::timing::{SpeedupLine, StageTime, Time, stages};
use crate::shown;

/// The places of an order, read only if they are asked for; if it has none, why.
type LazyPlaces<'a> = LazyCell<Result<Places, String>, Box<dyn FnOnce() -> Result<Places, String> + 'a>>;

/// What variants of a method differ in.
#[derive(Clone, Copy, Debug)]
pub struct Varied {
    /// As a number that can be put in order; `None` where it does not vary.
    pub of: fn(&OrderAnalysis) -> Option<f64>,
    /// What must be the same in all that are compared.
    pub other: fn(&OrderAnalysis) -> Option<f64>,
}

impl Varied {
    /// Bits of the key.
    pub const KEY_BITS: Self = Self {
        of: |order| order.key_bits.map(f64::from),
        other: |order| order.two_point_length.map(f64::from),
    };

    /// Bits of the key that are the origin's. A method itself may lay its bits out in another way than its variants.
    pub const ORIGIN_BITS: Self = Self {
        of: |order| order.origin_bits.filter(|_| order.method != order.base).map(f64::from),
        other: |order| order.key_bits.map(f64::from),
    };

    /// The length that all rays are assumed to have, unit lengths.
    pub const LENGTH: Self = Self {
        of: |order| order.two_point_length.map(f64::from),
        other: |order| order.key_bits.map(f64::from),
    };
}

/// The numbers of one order of one queue.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct OrderAnalysis {
    /// The method, or `unsorted`.
    pub method: String,
    /// The method that it is a variant of; its own name if it is none.
    pub base: String,
    /// Bits of its keys; `null` for `unsorted`.
    pub key_bits: Option<u32>,
    /// How many of them are the origin's, the rest being those of other coordinates; `null` where bits are of a curve
    /// or an exclusive or.
    pub origin_bits: Option<u32>,
    /// Length that it assumes for all rays, unit lengths; `null` if it assumes none.
    pub two_point_length: Option<f32>,
    /// The stages that were timed.
    pub stages: Vec<StageTime>,
    /// How its rays are traced in the total.
    pub way: Way,
    /// All stages that tracing in this order takes that way; `null` where it was not timed.
    pub total: Option<Time>,
    /// Unsorted trace over trace in this order; its verdict, as the next one's, counts what the control misses by.
    pub trace_speedup: Metric<SpeedupLine>,
    /// Unsorted trace over all stages.
    pub net_speedup: Metric<SpeedupLine>,
    /// What the cache model says.
    pub caches: Metric<CacheHits>,
    /// How coherent its groups are.
    pub coherence: Metric<Coherence>,
    /// Lane utilisation, by width. A model.
    pub lanes: Metric<Vec<LaneUtilisation>>,
}

impl OrderAnalysis {
    /// Utilisation of 32 lanes, 0 to 1, where it is known. A model.
    pub fn warp_utilisation(&self) -> Option<f64> {
        of_warp(self.lanes.known()?)
    }

    /// The same beside a control that misses 1 by `error`.
    pub(super) fn beyond(self, error: f64) -> Self {
        let trace_speedup = self.trace_speedup.map(|line| line.beyond(error));
        let net_speedup = self.net_speedup.map(|line| line.beyond(error));
        Self { trace_speedup, net_speedup, ..self }
    }

    /// A stage, if it was timed.
    pub fn stage(&self, stage: Stage) -> Option<&StageTime> {
        self.stages.iter().find(|found| found.stage == stage)
    }

    /// Whether it is `auto` and sorted none of these rays.
    pub fn is_left_alone(&self) -> bool {
        self.method == AUTO && self.stage(Stage::Sort).is_none()
    }
}

/// How many bits of a method's keys are the origin's.
fn origin_bits(record: &MethodRecord) -> Option<u32> {
    let bits = || record.layout.iter().take(record.key_bits as usize);
    let is_coordinate = |name: &String| name.chars().all(char::is_alphanumeric);
    let is_origin = |name: &&String| matches!(name.as_str(), "ox" | "oy" | "oz");
    bits().all(is_coordinate).then(|| bits().filter(is_origin).count() as u32)
}

/// Hit ratios of the cache model.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CacheHits {
    /// Rays that were modelled, a sample.
    pub rays: u64,
    /// Lines that they asked for.
    pub accesses: u64,
    /// Of these, the share found in the first level.
    pub l1: f64,
    /// Of the others, the share found in the second; 0 if there are no others.
    pub l2: f64,
    /// Share found in either.
    pub either: f64,
}

impl CacheHits {
    /// Lines that so many rays ask for, if they are like those of the sample.
    pub fn lines(&self, rays: u64) -> f64 {
        self.accesses as f64 / self.rays.max(1) as f64 * rays as f64
    }
}

impl From<&CacheRecord> for CacheHits {
    fn from(record: &CacheRecord) -> Self {
        let ratio = |part: u64, whole: u64| if whole == 0 { 0.0 } else { part as f64 / whole as f64 };
        let beyond_l1 = record.accesses.saturating_sub(record.l1_hits);
        Self {
            rays: record.rays,
            accesses: record.accesses,
            l1: ratio(record.l1_hits, record.accesses),
            l2: ratio(record.l2_hits, beyond_l1),
            either: ratio(record.l1_hits.saturating_add(record.l2_hits), record.accesses),
        }
    }
}

/// A queue and everything that its orders share.
#[derive(Debug)]
pub(super) struct QueueContext<'a> {
    pub(super) dump: &'a Dump,
    pub(super) queue: QueueId,
    pub(super) rays: u64,
    pub(super) samples: &'a Samples<'a>,
    pub(super) arrays: &'a QueueArrays<'a>,
    pub(super) options: &'a AnalysisOptions,
    pub(super) known: Option<&'a KnownQueue>,
}

impl<'a> QueueContext<'a> {
    fn manifest(&self) -> &'a Manifest {
        self.dump.manifest()
    }

    /// The numbers of a method's order.
    pub(super) fn order(&self, method: &'a str) -> OrderAnalysis {
        let record = self.manifest().methods.iter().find(|record| record.name == method);
        let traffic = Traffic {
            kind: self.queue.kind,
            order: record
                .map(|record| KeyTraffic { key_bits: record.key_bits, termination: record.termination }),
        };
        let own = self.samples.get(self.queue, method);
        let way = self.samples.way(self.queue, method);
        let totals = own.map_or(Vec::new(), |own| own.totals(way));
        let places = LazyPlaces::new(Box::new(|| self.places(method)));
        let known = self.known.and_then(|queue| queue.orders.get(method));
        OrderAnalysis {
            method: shown::name(method),
            base: shown::name(record.map_or(method, |record| &record.base)),
            key_bits: record.map(|record| record.key_bits),
            origin_bits: record.and_then(origin_bits),
            two_point_length: record
                .filter(|record| record.termination == Termination::Fixed)
                .map(|record| record.two_point_length),
            stages: own.map_or(Vec::new(), |own| stages(own, &traffic, self.rays)),
            way,
            total: Time::of(&totals, self.rays),
            trace_speedup: self.speedup(method, record, own.map_or(&[], StageSamples::traced)),
            net_speedup: if method == SHUFFLED {
                Metric::missing("a random order has neither keys nor a sort: what it costs says nothing")
            } else if self.manifest().foreign_orders().any(|order| order.name == method) {
                Metric::missing("its keys came with the rays: making and sorting them was not timed")
            } else {
                self.speedup(method, record, &totals)
            },
            caches: self.caches(method),
            coherence: self.coherence(known, &places),
            lanes: self.lanes(known, &places),
        }
    }

    fn speedup(&self, method: &str, record: Option<&MethodRecord>, samples: &[u64]) -> Metric<SpeedupLine> {
        if method == UNSORTED {
            return Metric::missing("unsorted rays are what others are compared with");
        }
        if record.is_some_and(|record| record.termination == Termination::Real) {
            return Metric::missing(
                "it must trace the rays before it can sort them: an upper bound, not a method",
            );
        }
        let baseline =
            self.samples.get(self.queue, UNSORTED).map_or(&[][..], |unsorted| unsorted.of(Stage::Trace));
        if baseline.is_empty() {
            return Metric::missing("the trace of unsorted rays was not timed");
        }
        SpeedupLine::of(baseline, samples).ok_or("it was not timed").into()
    }

    fn caches(&self, method: &str) -> Metric<CacheHits> {
        let is_order = |cache: &&CacheRecord| cache.queue == self.queue && cache.method == method;
        let record = self.manifest().caches.iter().find(is_order);
        record.map(CacheHits::from).ok_or("the recorder did not run the cache model").into()
    }

    /// The places of a method's order; if it has none, why.
    fn places(&self, method: &str) -> Result<Places, String> {
        let rays = usize::try_from(self.rays).map_err(|error| error.to_string())?;
        if self.options.depth == Depth::Manifest {
            return Err(QueueArrays::NOT_READ.to_owned());
        }
        Places::open(self.dump, self.queue, method, rays)
    }

    fn coherence(&self, known: Option<&KnownOrder>, places: &LazyPlaces<'_>) -> Metric<Coherence> {
        let of = |places: &Places| {
            let (traced, lengths) = self.arrays.traced()?;
            let width = self.options.group_width.rays();
            coherence(traced, lengths, places, width).ok_or_else(|| "there are no rays".to_owned())
        };
        let found = match known {
            Some(known) => Ok(known.coherence.clone()),
            None => places.as_ref().map_err(String::clone).and_then(of),
        };
        let is_finite = |of: &Coherence| (of.mean_capsule_area + of.mean_direction_spread).is_finite();
        let why = || "its rays are not finite; `inspector verify` says which".to_owned();
        found.and_then(|found| is_finite(&found).then_some(found).ok_or_else(why)).into()
    }

    fn lanes(&self, known: Option<&KnownOrder>, places: &LazyPlaces<'_>) -> Metric<Vec<LaneUtilisation>> {
        let of = |places: &Places| Ok(lanes(self.arrays.work()?, places));
        let found = match known.and_then(|known| known.lanes.clone()) {
            Some(lanes) => Ok(lanes),
            None => places.as_ref().map_err(String::clone).and_then(of),
        };
        let why = || "no ray did any work".to_owned();
        found.and_then(|lanes| Some(lanes).filter(|lanes| !lanes.is_empty()).ok_or_else(why)).into()
    }
}

#[cfg(test)]
mod tests {
    use formats::ray::Kind;

    use super::*;

    #[test]
    fn cache_ratios_by_hand() {
        let mut record = CacheRecord {
            queue: QueueId { pass: 0, bounce: 0, kind: Kind::Closest },
            method: "aila".into(),
            groups: 1,
            rays: 64,
            line_bytes: 128,
            l1_bytes: 1,
            l2_bytes: 2,
            accesses: 1000,
            l1_hits: 500,
            l2_hits: 250,
        };
        let hits = CacheHits::from(&record);
        assert_eq!((hits.l1, hits.l2, hits.either), (0.5, 0.5, 0.75));
        record.l1_hits = 1000;
        record.l2_hits = 0;
        assert_eq!(CacheHits::from(&record).l2, 0.0);
    }
}
