//! Per machine, rays and method: the whole frame, means over recordings.

use formats::key::method::UNSORTED;
use formats::metrics::speedup::{Verdict, geometric_mean};
use formats::ray::Kind;
use serde::Serialize;

use super::timing::SpeedupLine;
use super::{FrameAnalysis, Metric, QueueAnalysis, RecordingAnalysis};

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

    /// Those of a kind, over all bounces.
    pub fn of_kind(kind: Kind) -> Self {
        match kind {
            Kind::Closest => Self::Secondary,
            Kind::Shadow => Self::Shadow,
        }
    }

    /// Their kind.
    pub fn kind(self) -> Kind {
        match self {
            Self::Secondary => Kind::Closest,
            Self::Shadow => Kind::Shadow,
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

/// One method on one machine, over recordings: of each the sum over its bounces.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MethodSummary {
    /// Backend, adapter, kernel and threads: times of different ones have no common mean.
    pub configuration: String,
    /// The rays.
    pub rays: RayClass,
    /// The method.
    pub method: String,
    /// Recordings in which it was measured.
    pub recordings: usize,
    /// Speedup of the trace alone.
    pub trace_speedup: Metric<MeanSpeedup>,
    /// Speedup with all that sorting costs.
    pub net_speedup: Metric<MeanSpeedup>,
    /// Geometric mean over recordings of mean capsule areas over those of unsorted rays.
    pub capsule_area_ratio: Metric<f64>,
}

/// Speedups of one method over recordings.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct MeanSpeedup {
    /// Geometric mean.
    pub mean: f64,
    /// Smallest.
    pub lowest: f64,
    /// Largest.
    pub highest: f64,
    /// 95 % interval of a single one; `null` for several or for too few rounds.
    pub interval: Option<(f64, f64)>,
    /// Speedups.
    pub n: usize,
    /// Those that are faster, by their interval.
    pub faster: usize,
    /// Those that are slower, by their interval.
    pub slower: usize,
    /// Those without an interval, of too few rounds.
    pub untested: usize,
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
            interval: match speedups[..] {
                [only] => only.interval,
                _ => None,
            },
            n: speedups.len(),
            faster: with(Verdict::Faster),
            slower: with(Verdict::Slower),
            untested: with(Verdict::Unknown),
        })
    }
}

/// Every machine, kind of rays and method, in the order in which they come up. Variants, which sweeps show,
/// are among them only where nothing else was measured.
pub fn summaries(recordings: &[RecordingAnalysis]) -> Vec<MethodSummary> {
    let mut summaries = Vec::new();
    for configuration in distinct(recordings.iter().map(|recording| recording.configuration.as_str())) {
        let same = recordings.iter().filter(|recording| recording.configuration == configuration);
        let frames: Vec<&FrameAnalysis> = same.flat_map(|recording| &recording.frames).collect();
        for rays in RayClass::ALL {
            let of_rays = || frames.iter().filter(|frame| frame.rays == rays && frame.method != UNSORTED);
            let has_plain = of_rays().any(|frame| frame.base == frame.method);
            let shown = of_rays().filter(|frame| !has_plain || frame.base == frame.method);
            for method in distinct(shown.map(|frame| frame.method.as_str())) {
                let own: Vec<&FrameAnalysis> =
                    of_rays().filter(|frame| frame.method == method).copied().collect();
                summaries.push(summary(configuration, rays, method, &own));
            }
        }
    }
    summaries
}

fn summary(configuration: &str, rays: RayClass, method: &str, frames: &[&FrameAnalysis]) -> MethodSummary {
    let speedup = |of: fn(&FrameAnalysis) -> &Metric<SpeedupLine>| {
        let mean = MeanSpeedup::of(frames.iter().filter_map(|frame| of(frame).known()));
        let reason = frames.iter().find_map(|frame| of(frame).reason());
        mean.ok_or(reason.unwrap_or("it was not timed")).into()
    };
    let no_area = frames.iter().find_map(|frame| frame.capsule_area_ratio.reason());
    let areas = frames.iter().filter_map(|frame| frame.capsule_area_ratio.known().copied());
    MethodSummary {
        configuration: configuration.to_owned(),
        rays,
        method: method.to_owned(),
        recordings: frames.len(),
        trace_speedup: speedup(|frame| &frame.trace_speedup),
        net_speedup: speedup(|frame| &frame.net_speedup),
        capsule_area_ratio: geometric_mean(areas)
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
            line(2.0, Verdict::Unknown),
        ];
        let mean = MeanSpeedup::of(&lines).unwrap();
        assert!((mean.mean - 2.0).abs() < 1e-12);
        assert_eq!((mean.lowest, mean.highest, mean.n), (0.5, 8.0, 4));
        assert_eq!((mean.faster, mean.slower, mean.untested), (1, 1, 1));
        assert_eq!(MeanSpeedup::of(&[]), None);
    }
}
