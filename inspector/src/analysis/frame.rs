//! The whole frame: a method over all bounces of a recording, whose times are summed round by round, so that
//! a bounce counts by the time that it takes.

use formats::key::method::{CONTROL, REFERENCES, UNSORTED};
use formats::manifest::Stage;
use formats::metrics::frame;
use formats::metrics::samples::Samples;
use serde::Serialize;

use super::summary::{RayClass, distinct};
use super::timing::{SpeedupLine, Time};
use super::{Metric, OrderAnalysis, QueueAnalysis};

/// One method on one kind of rays of a recording, over its bounces.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FrameAnalysis {
    /// The rays.
    pub rays: RayClass,
    /// The method, or `unsorted`.
    pub method: String,
    /// The method that it is a variant of; its own name if it is none.
    pub base: String,
    /// Bounces in which it was measured.
    pub bounces: usize,
    /// Whether it is `auto` and sorted none of these rays: its times are then those of unsorted rays.
    pub left_alone: bool,
    /// Stages that its total counts, in the order in which they run, summed over bounces.
    pub stages: Vec<FrameStage>,
    /// Unsorted trace over trace in this order, beside the control.
    pub trace_speedup: Metric<SpeedupLine>,
    /// Unsorted trace over all stages, beside the control.
    pub net_speedup: Metric<SpeedupLine>,
    /// Mean capsule area of a ray over that in the unsorted order.
    pub capsule_area_ratio: Metric<f64>,
}

/// A stage over all bounces.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FrameStage {
    /// The stage.
    pub stage: Stage,
    /// Median over rounds of its sum over bounces, nanoseconds.
    pub median_ns: f64,
    /// Rounds.
    pub n: usize,
}

impl FrameAnalysis {
    /// Whether it may be called the best: neither what others are held against, nor left unsorted by `auto`.
    pub fn is_candidate(&self) -> bool {
        !REFERENCES.contains(&self.method.as_str()) && !self.left_alone
    }

    /// Every kind of rays and method of some queues, in the order in which they come up, beside the controls.
    pub(super) fn all(queues: &[QueueAnalysis], controls: &[(RayClass, SpeedupLine)]) -> Vec<Self> {
        let mut frames = Vec::new();
        for rays in RayClass::ALL {
            let own: Vec<&QueueAnalysis> =
                queues.iter().filter(|queue| RayClass::of(queue) == Some(rays)).collect();
            let error = instrument_error(controls, &[rays]);
            let orders = own.iter().flat_map(|queue| &queue.orders);
            for method in distinct(orders.map(|order| order.method.as_str())) {
                frames.extend(Self::of(&own, rays, method, error));
            }
        }
        frames
    }

    fn of(queues: &[&QueueAnalysis], rays: RayClass, method: &str, error: f64) -> Option<Self> {
        let measured: Vec<(&QueueAnalysis, &OrderAnalysis)> =
            queues.iter().filter_map(|queue| Some((*queue, queue.order(method)?))).collect();
        let (_, first) = measured.first()?;
        let stages = Stage::OF_ORDERS.into_iter().filter_map(|stage| frame_stage(&measured, stage));
        Some(Self {
            rays,
            method: method.to_owned(),
            base: first.base.clone(),
            bounces: measured.len(),
            left_alone: measured.iter().all(|(_, order)| order.is_left_alone()),
            stages: stages.collect(),
            trace_speedup: speedup(&measured, |order| &order.trace_speedup, traced)
                .map(|line| line.beyond(error)),
            net_speedup: speedup(&measured, |order| &order.net_speedup, |order| order.total.as_ref())
                .map(|line| line.beyond(error)),
            capsule_area_ratio: area_ratio(&measured),
        })
    }
}

/// The trace: of rays as they lie or, where they were traced through indices alone, of that.
pub(super) fn traced(order: &OrderAnalysis) -> Option<&Time> {
    let found = order.stage(Stage::Trace).or_else(|| order.stage(Stage::TraceIndirect));
    found.map(|found| &found.time)
}

/// Unsorted trace over the trace of the control, which has times alone.
pub(super) fn control(
    samples: &Samples<'_>,
    queues: &[QueueAnalysis],
    rays: RayClass,
) -> Option<SpeedupLine> {
    let measured =
        || queues.iter().filter(|queue| RayClass::of(queue) == Some(rays) && !queue.orders.is_empty());
    let traces = |method: &'static str| {
        let of = |queue: &QueueAnalysis| Some(samples.get(queue.id(), method)?.traced().to_vec());
        measured().map(of).collect::<Option<Vec<_>>>()
    };
    let sum = |traces: Vec<Vec<u64>>| frame::summed(traces.iter().map(Vec::as_slice));
    SpeedupLine::of(&sum(traces(UNSORTED)?), &sum(traces(CONTROL)?))
}

/// The most that the controls of some rays miss 1 by; 0 where none was measured.
pub(super) fn instrument_error(controls: &[(RayClass, SpeedupLine)], rays: &[RayClass]) -> f64 {
    let own = controls.iter().filter(|(of, _)| rays.contains(of));
    own.map(|(_, line)| (line.ratio - 1.0).abs()).fold(0.0, f64::max)
}

/// A speedup of the sums; what one bounce lacks, the frame lacks.
fn speedup(
    measured: &[(&QueueAnalysis, &OrderAnalysis)],
    of: fn(&OrderAnalysis) -> &Metric<SpeedupLine>,
    time: fn(&OrderAnalysis) -> Option<&Time>,
) -> Metric<SpeedupLine> {
    if let Some(reason) = measured.iter().find_map(|(_, order)| of(order).reason()) {
        return Metric::missing(reason);
    }
    let unsorted = measured.iter().filter_map(|(queue, _)| traced(queue.order(UNSORTED)?));
    let own = measured.iter().filter_map(|(_, order)| time(order));
    SpeedupLine::of(&summed(unsorted), &summed(own)).ok_or("it was not timed").into()
}

/// A stage of the way that is counted; bounces that have not got it, such as unsorted ones of `auto`, add
/// nothing.
fn frame_stage(measured: &[(&QueueAnalysis, &OrderAnalysis)], stage: Stage) -> Option<FrameStage> {
    let counted = measured.iter().filter(|(_, order)| order.way.counts(stage));
    let sums = summed(counted.filter_map(|(_, order)| Some(&order.stage(stage)?.time)));
    let Time { median_ns, samples_ns, .. } = Time::of(&sums, 1)?;
    Some(FrameStage { stage, median_ns, n: samples_ns.len() })
}

/// Times added up round by round, as many rounds as all of them have.
pub(super) fn summed<'a>(times: impl Iterator<Item = &'a Time>) -> Vec<u64> {
    frame::summed(times.map(|time| time.samples_ns.as_slice()))
}

fn area_ratio(measured: &[(&QueueAnalysis, &OrderAnalysis)]) -> Metric<f64> {
    if let Some(reason) = measured.iter().find_map(|(_, order)| order.coherence.reason()) {
        return Metric::missing(reason);
    }
    let weighted = |(queue, order): (&QueueAnalysis, &OrderAnalysis)| {
        Some(order.coherence.known()?.mean_capsule_area * queue.rays as f64)
    };
    let own: Option<f64> = measured.iter().map(|&at| weighted(at)).sum();
    let unsorted: Option<f64> =
        measured.iter().map(|&(queue, _)| weighted((queue, queue.order(UNSORTED)?))).sum();
    let ratio = own.zip(unsorted).map(|(own, unsorted)| own / unsorted).filter(|ratio| ratio.is_finite());
    ratio.ok_or("the capsules of unsorted rays are not known").into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounds_are_summed_and_a_large_bounce_weighs_more() {
        let times = [[100u64, 120, 100], [10, 20, 30]].map(|samples| Time::of(&samples, 1).unwrap());
        assert_eq!(summed(times.iter()), [110, 140, 130]);
        let faster = [[50u64, 60, 50], [20, 40, 60]].map(|samples| Time::of(&samples, 1).unwrap());
        let line = SpeedupLine::of(&summed(times.iter()), &summed(faster.iter())).unwrap();
        // Twice as fast on 100 ns, half as fast on 10 ns: not 1.
        assert!((line.ratio - 140.0 / 100.0).abs() < 1e-12, "{line:?}");
        assert_eq!(summed([].into_iter()), [0u64; 0]);
    }
}
