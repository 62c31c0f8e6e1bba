//! What a sort may cost: what it saves in tracing, and what it takes.

use formats::key::method::UNSORTED;
use formats::manifest::Stage;
use formats::metrics::speedup::median;
use serde::Serialize;

use super::frame::{summed, traced};
use super::summary::RayClass;
use super::timing::{SpeedupLine, Time};
use super::{OrderAnalysis, QueueAnalysis, RecordingAnalysis};

/// One method on one kind of rays of a recording, over its bounces; nanoseconds a ray.
///
/// From ratios by rounds, as speedups are: it costs less than it saves where its net speedup is above 1, and nowhere
/// else.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct BreakEven {
    /// What the trace of sorted rays, the one that its total counts, is shorter by than that of unsorted ones; below
    /// 0 if it is longer.
    pub saved_ns: f64,
    /// 95 % interval of it; `null` with fewer than six rounds.
    pub interval: Option<(f64, f64)>,
    /// All that its total counts besides that trace: of an order of another tracer neither its key nor its sort, which
    /// were not timed.
    pub cost_ns: f64,
    /// The trace of unsorted rays.
    pub unsorted_ns: f64,
    /// Samples of the method.
    pub n: usize,
}

impl BreakEven {
    /// Of a method that may be called the best, if it and the trace of unsorted rays were timed.
    pub fn of(recording: &RecordingAnalysis, rays: RayClass, method: &str) -> Option<Self> {
        let frame = recording.frame(rays, method).filter(|frame| frame.is_candidate())?;
        frame.trace_speedup.known()?;
        let queues = recording.measured().filter(|queue| RayClass::of(queue) == Some(rays));
        let measured: Vec<(&QueueAnalysis, &OrderAnalysis)> =
            queues.filter_map(|queue| Some((queue, queue.order(method)?))).collect();
        let unsorted = summed(measured.iter().filter_map(|(queue, _)| traced(queue.order(UNSORTED)?)));
        let sorted = summed(measured.iter().filter_map(|(_, order)| counted_trace(order)));
        let SpeedupLine { ratio, interval, n, .. } = SpeedupLine::of(&unsorted, &sorted)?;
        let net = match frame.net_speedup.known() {
            Some(net) => net.ratio,
            None => {
                let totals = measured.iter().filter_map(|(_, order)| order.total.as_ref());
                SpeedupLine::of(&unsorted, &summed(totals))?.ratio
            }
        };
        let count: f64 = measured.iter().map(|(queue, _)| queue.rays as f64).sum();
        let unsorted_ns = median(&unsorted)? / count;
        let saved = |speedup: f64| unsorted_ns * (1.0 - 1.0 / speedup);
        let found = Self {
            saved_ns: saved(ratio),
            interval: interval.map(|(low, high)| (saved(low), saved(high))),
            cost_ns: unsorted_ns * (1.0 / net - 1.0 / ratio),
            unsorted_ns,
            n,
        };
        (found.saved_ns + found.cost_ns).is_finite().then_some(found)
    }
}

/// The trace that an order's total counts.
fn counted_trace(order: &OrderAnalysis) -> Option<&Time> {
    let traces = [Stage::Trace, Stage::TraceIndirect].into_iter().filter(|stage| order.way.counts(*stage));
    traces.filter_map(|stage| order.stage(stage)).map(|found| &found.time).next()
}
