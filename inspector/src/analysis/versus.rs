//! Order B against order A: on one queue, and on the whole frame.

use formats::key::method::UNSORTED;
use formats::metrics::speedup::Verdict;
use serde::Serialize;

use super::frame::{summed, traced};
use super::summary::{RayClass, distinct};
use super::timing::{SpeedupLine, Time};
use super::{Metric, OrderAnalysis, QueueAnalysis, RecordingAnalysis};

/// An order of a recording: a method, or `unsorted`.
#[derive(Clone, Copy, Debug)]
pub struct OrderOf<'a> {
    /// The recording.
    pub recording: &'a RecordingAnalysis,
    /// The method.
    pub method: &'a str,
}

/// How much faster order B is than order A.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Versus {
    /// Trace in order A over trace in order B.
    pub trace: Metric<SpeedupLine>,
    /// The same with all that sorting costs on either side, beside the controls of these rays.
    pub net: Metric<SpeedupLine>,
    /// The kinds of rays whose times are in it.
    pub rays: Vec<RayClass>,
}

impl Versus {
    /// On the whole frame: all queues but camera rays, their times summed round by round. A queue that a method does
    /// not order is as it lies, unsorted.
    pub fn on_frame([a, b]: [OrderOf<'_>; 2]) -> Self {
        let is_frame = |queue: &QueueAnalysis| RayClass::of(queue).is_some();
        let is_there = |of: OrderOf<'_>| {
            of.recording.measured().any(|queue| is_frame(queue) && queue.order(of.method).is_some())
        };
        let order = if is_there(a) && is_there(b) { or_unsorted } else { QueueAnalysis::order as Lookup };
        Self::by([a, b], is_frame, order)
    }

    /// Each method of a recording over unsorted rays on the whole frame, in the order in which they come up.
    pub fn over_unsorted(recording: &RecordingAnalysis) -> Vec<(String, Self)> {
        let queues = recording.measured().filter(|queue| RayClass::of(queue).is_some());
        let methods = distinct(queues.flat_map(|queue| &queue.orders).map(|order| order.method.as_str()));
        let of = |method: &str| {
            let orders = [UNSORTED, method].map(|method| OrderOf { recording, method });
            (method.to_owned(), Self::on_frame(orders))
        };
        methods.into_iter().filter(|method| *method != UNSORTED).map(of).collect()
    }

    /// On the queues of B that `is_meant`.
    pub fn on([a, b]: [OrderOf<'_>; 2], is_meant: impl Fn(&QueueAnalysis) -> bool) -> Self {
        Self::by([a, b], is_meant, QueueAnalysis::order)
    }

    fn by([a, b]: [OrderOf<'_>; 2], is_meant: impl Fn(&QueueAnalysis) -> bool, order: Lookup) -> Self {
        let queues: Vec<&QueueAnalysis> = b.recording.measured().filter(|queue| is_meant(queue)).collect();
        let has_b = queues.iter().filter(|queue| order(queue, b.method).is_some());
        let pairs: Vec<[&OrderAnalysis; 2]> = has_b
            .clone()
            .filter_map(|queue| Some([order(same(a, queue)?, a.method)?, order(queue, b.method)?]))
            .collect();
        let classes: Vec<RayClass> = has_b.clone().filter_map(|queue| RayClass::of(queue)).collect();
        let is_one_run = std::ptr::eq(a.recording, b.recording);
        let speedup = |of: fn(&OrderAnalysis) -> &Metric<SpeedupLine>,
                       time: fn(&OrderAnalysis) -> Option<&Time>| {
            if pairs.is_empty() || pairs.len() < has_b.clone().count() {
                return Metric::missing("A and B were not both measured on the same rays");
            }
            let line = speedup(&pairs, of, time);
            // Rounds of two runs are no pairs: what slowed one down did not slow the other.
            let unpaired = |line| SpeedupLine { interval: None, verdict: Verdict::Unknown, ..line };
            if is_one_run { line } else { line.map(unpaired) }
        };
        let rays: Vec<RayClass> = RayClass::ALL.into_iter().filter(|class| classes.contains(class)).collect();
        let error = b.recording.instrument_error(&rays);
        Self {
            trace: speedup(|order| &order.trace_speedup, traced).map(|line| line.beyond(error)),
            net: speedup(|order| &order.net_speedup, total).map(|line| line.beyond(error)),
            rays,
        }
    }
}

/// How the order of a method is found among those of a queue.
type Lookup = for<'q> fn(&'q QueueAnalysis, &str) -> Option<&'q OrderAnalysis>;

/// The order of a method, or unsorted rays where it has none.
fn or_unsorted<'a>(queue: &'a QueueAnalysis, method: &str) -> Option<&'a OrderAnalysis> {
    queue.order(method).or_else(|| queue.order(UNSORTED))
}

/// The rays of a queue of B in the recording of A.
fn same<'a>(a: OrderOf<'a>, queue: &QueueAnalysis) -> Option<&'a QueueAnalysis> {
    a.recording.queues.iter().find(|found| (found.id(), found.rays) == (queue.id(), queue.rays))
}

/// All that tracing in an order takes: of unsorted rays the trace alone.
fn total(order: &OrderAnalysis) -> Option<&Time> {
    if order.method == UNSORTED { traced(order) } else { order.total.as_ref() }
}

/// What one queue lacks, all lack.
fn speedup(
    pairs: &[[&OrderAnalysis; 2]],
    of: fn(&OrderAnalysis) -> &Metric<SpeedupLine>,
    time: fn(&OrderAnalysis) -> Option<&Time>,
) -> Metric<SpeedupLine> {
    let sorted = pairs.iter().flatten().filter(|order| order.method != UNSORTED);
    if let Some(reason) = sorted.map(|order| of(order).reason()).find_map(|reason| reason) {
        return Metric::missing(reason);
    }
    let sum = |side: usize| {
        let times: Option<Vec<&Time>> = pairs.iter().map(|pair| time(pair[side])).collect();
        times.map(|times| summed(times.into_iter()))
    };
    let line = sum(0).zip(sum(1)).and_then(|(a, b)| SpeedupLine::of(&a, &b));
    line.ok_or("it was not timed").into()
}
