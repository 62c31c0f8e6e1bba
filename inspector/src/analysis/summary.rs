//! Totals over the bounces of a recording; per machine, rays and method: means over recordings.

use formats::key::method::UNSORTED;
use formats::metrics::speedup::geometric_mean;
use formats::ray::Kind;
use serde::Serialize;

use super::timing::{SpeedupLine, Verdict};
use super::{Metric, OrderAnalysis, QueueAnalysis, RecordingAnalysis};

/// The rays that a mean is taken over.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum RayClass {
    /// Closest rays of bounces ≥ 1.
    Secondary,
    /// Shadow rays of all bounces.
    Shadow,
}

impl RayClass {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Secondary, Self::Shadow];

    /// Those of a queue; `None` for camera rays, which no mean is taken over.
    pub fn of(queue: &QueueAnalysis) -> Option<Self> {
        match (queue.kind, queue.bounce) {
            (Kind::Closest, 0) => None,
            (Kind::Closest, _) => Some(Self::Secondary),
            (Kind::Shadow, _) => Some(Self::Shadow),
        }
    }

    /// Name in tables and figures.
    pub fn name(self) -> &'static str {
        match self {
            Self::Secondary => "secondary",
            Self::Shadow => "shadow",
        }
    }
}

/// What a speedup counts of the time in another order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Counted {
    /// The trace alone.
    Trace,
    /// All that tracing in that order takes.
    Everything,
}

impl Counted {
    /// Of one queue.
    pub fn speedup(self, order: &OrderAnalysis) -> &Metric<SpeedupLine> {
        match self {
            Self::Trace => &order.trace_speedup,
            Self::Everything => &order.net_speedup,
        }
    }

    fn samples(self, order: &OrderAnalysis) -> Option<&[u64]> {
        let time = match self {
            Self::Trace => &order.traced()?.time,
            Self::Everything => order.total.as_ref()?,
        };
        Some(&time.samples_ns)
    }
}

/// Speedup of a method over all queues of a recording with these rays: times of unsorted rays over those in its
/// order, both summed over queues round by round, so that a queue weighs as much as it takes.
///
/// Missing where the method has no speedup in any of these queues; then it says why.
pub fn total_speedup(
    recording: &RecordingAnalysis,
    rays: RayClass,
    method: &str,
    counted: Counted,
) -> Metric<SpeedupLine> {
    let queues = || recording.measured().filter(|queue| RayClass::of(queue) == Some(rays));
    let orders = || queues().filter_map(|queue| Some((queue.order(UNSORTED)?, queue.order(method)?)));
    let (mut baseline, mut sorted): (Vec<u64>, Vec<u64>) = Default::default();
    for (unsorted, order) in orders().filter(|(_, order)| counted.speedup(order).known().is_some()) {
        let pair = Counted::Trace.samples(unsorted).zip(counted.samples(order));
        let (of_unsorted, of_order) = pair.unwrap_or_default();
        add(&mut baseline, of_unsorted);
        add(&mut sorted, of_order);
    }
    let reason =
        || orders().find_map(|(_, order)| counted.speedup(order).reason()).unwrap_or("it was not measured");
    SpeedupLine::of(&baseline, &sorted).ok_or_else(reason).into()
}

/// Adds times round by round; where some have fewer rounds, the others are left out.
fn add(sums: &mut Vec<u64>, times: &[u64]) {
    if sums.is_empty() {
        sums.extend(times);
    } else {
        sums.truncate(times.len());
        sums.iter_mut().zip(times).for_each(|(sum, &time)| *sum = sum.saturating_add(time));
    }
}

/// One method on one machine, over scenes and bounces.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MethodSummary {
    /// Backend, adapter, kernel and threads: times of different ones have no common mean.
    pub configuration: String,
    /// The rays.
    pub rays: RayClass,
    /// The method.
    pub method: String,
    /// Queues in which it was measured.
    pub queues: usize,
    /// Speedup of the trace alone.
    pub trace_speedup: Metric<MeanSpeedup>,
    /// Speedup with all that sorting costs.
    pub net_speedup: Metric<MeanSpeedup>,
    /// Geometric mean of mean capsule areas over those of unsorted rays.
    pub capsule_area_ratio: Metric<f64>,
}

/// Speedups of one method over recordings, each the total of all bounces.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct MeanSpeedup {
    /// Geometric mean.
    pub mean: f64,
    /// Smallest.
    pub lowest: f64,
    /// Largest.
    pub highest: f64,
    /// Recordings.
    pub n: usize,
    /// Recordings that are faster, by their interval.
    pub faster: usize,
    /// Recordings that are slower, by their interval.
    pub slower: usize,
}

impl MeanSpeedup {
    /// Of some speedups; `None` for none.
    pub fn of<'a>(speedups: impl IntoIterator<Item = &'a SpeedupLine>) -> Option<Self> {
        let speedups: Vec<&SpeedupLine> = speedups.into_iter().collect();
        let ratios = || speedups.iter().map(|speedup| speedup.ratio);
        let with = |verdict| speedups.iter().filter(|speedup| speedup.verdict == verdict).count();
        Some(Self {
            mean: geometric_mean(ratios())?,
            lowest: ratios().fold(f64::INFINITY, f64::min),
            highest: ratios().fold(f64::NEG_INFINITY, f64::max),
            n: speedups.len(),
            faster: with(Verdict::Faster),
            slower: with(Verdict::Slower),
        })
    }
}

/// Every machine, kind of rays and method, in the order in which they come up.
pub fn summaries(recordings: &[RecordingAnalysis]) -> Vec<MethodSummary> {
    let mut summaries = Vec::new();
    for configuration in distinct(recordings.iter().map(|recording| recording.configuration.as_str())) {
        let same = || recordings.iter().filter(|recording| recording.configuration == configuration);
        for rays in RayClass::ALL {
            let queues: Vec<&QueueAnalysis> = same()
                .flat_map(RecordingAnalysis::measured)
                .filter(|queue| RayClass::of(queue) == Some(rays))
                .collect();
            let methods = queues.iter().flat_map(|queue| &queue.orders).map(|order| order.method.as_str());
            for method in distinct(methods.filter(|method| *method != UNSORTED)) {
                summaries.push(summary(configuration, rays, method, &same().collect::<Vec<_>>(), &queues));
            }
        }
    }
    summaries
}

fn summary(
    configuration: &str,
    rays: RayClass,
    method: &str,
    recordings: &[&RecordingAnalysis],
    queues: &[&QueueAnalysis],
) -> MethodSummary {
    let measured = || queues.iter().filter_map(|queue| Some((queue, queue.order(method)?)));
    let speedup = |counted: Counted| -> Metric<MeanSpeedup> {
        let totals: Vec<Metric<SpeedupLine>> =
            recordings.iter().map(|recording| total_speedup(recording, rays, method, counted)).collect();
        let reason = measured().find_map(|(_, order)| counted.speedup(order).reason());
        let mean = MeanSpeedup::of(totals.iter().filter_map(Metric::known));
        mean.ok_or(reason.unwrap_or("it was not timed")).into()
    };
    let area = |order: &OrderAnalysis| Some(order.coherence.known()?.mean_capsule_area);
    let area_ratio = |(queue, order): (&&QueueAnalysis, &OrderAnalysis)| {
        Some(area(order)? / area(queue.order(UNSORTED)?)?)
    };
    let no_area = measured().find_map(|(_, order)| order.coherence.reason());
    MethodSummary {
        configuration: configuration.to_owned(),
        rays,
        method: method.to_owned(),
        queues: measured().count(),
        trace_speedup: speedup(Counted::Trace),
        net_speedup: speedup(Counted::Everything),
        capsule_area_ratio: geometric_mean(measured().filter_map(area_ratio))
            .ok_or(no_area.unwrap_or("the capsules of unsorted rays are not known"))
            .into(),
    }
}

/// Each name once, in the order in which they first come up.
pub fn distinct<T: PartialEq>(names: impl IntoIterator<Item = T>) -> Vec<T> {
    let mut found = Vec::new();
    for name in names {
        if !found.contains(&name) {
            found.push(name);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_are_geometric_and_count_verdicts() {
        let line = |ratio, verdict| SpeedupLine { ratio, interval: None, verdict, n: 3 };
        let lines = [
            line(2.0, Verdict::Faster),
            line(0.5, Verdict::Slower),
            line(8.0, Verdict::NoSignificantDifference),
        ];
        let mean = MeanSpeedup::of(&lines).unwrap();
        assert!((mean.mean - 2.0).abs() < 1e-12);
        assert_eq!((mean.lowest, mean.highest, mean.n, mean.faster, mean.slower), (0.5, 8.0, 3, 1, 1));
        assert_eq!(MeanSpeedup::of(&[]), None);
    }
}
