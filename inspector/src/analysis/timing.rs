//! Times of an order's stages, and what follows from them: rates, speedups, bandwidths.

use formats::manifest::Stage;
use formats::metrics::bandwidth::{Traffic, bytes_per_second};
use formats::metrics::speedup::{Speedup, StageSamples, Verdict, median, quantile};
use serde::{Deserialize, Serialize};

/// Samples of one time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Time {
    /// Median in nanoseconds.
    pub median_ns: f64,
    /// First and third quartile.
    pub quartiles_ns: (f64, f64),
    /// Every sample, as it was taken.
    pub samples_ns: Vec<u64>,
    /// Million rays a second, by the median.
    pub mrays_per_second: f64,
}

impl Time {
    /// Of samples of the time that `rays` rays took; `None` for no samples.
    pub fn of(samples_ns: &[u64], rays: u64) -> Option<Self> {
        let median_ns = median(samples_ns)?;
        Some(Self {
            median_ns,
            quartiles_ns: (quantile(samples_ns, 0.25)?, quantile(samples_ns, 0.75)?),
            samples_ns: samples_ns.to_vec(),
            mrays_per_second: rays as f64 / median_ns.max(f64::MIN_POSITIVE) * 1e3,
        })
    }
}

/// One stage of an order.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StageTime {
    /// The stage.
    pub stage: Stage,
    /// How long it took.
    #[serde(flatten)]
    pub time: Time,
    /// Bytes per ray that it must read and write, a lower bound; `null` if that depends on the scene.
    pub bytes_per_ray: Option<u64>,
    /// These bytes over the median time.
    pub bytes_per_second: Option<f64>,
}

/// A speedup over the trace of unsorted rays.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SpeedupLine {
    /// Median over rounds of the baseline's time over the method's.
    pub ratio: f64,
    /// 95 % bootstrap interval; `null` with fewer than six rounds.
    pub interval: Option<(f64, f64)>,
    /// What it says.
    pub verdict: Verdict,
    /// Samples of the method.
    pub n: usize,
}

impl SpeedupLine {
    /// Without what it says.
    pub fn speedup(&self) -> Speedup {
        Speedup { ratio: self.ratio, interval: self.interval }
    }

    /// The same beside a control that misses 1 by `error`.
    pub fn beyond(self, error: f64) -> Self {
        Self { verdict: self.speedup().verdict(error), ..self }
    }

    /// Of `method` over `baseline`; `None` if either has no samples.
    pub fn of(baseline: &[u64], method: &[u64]) -> Option<Self> {
        let speedup = Speedup::of(baseline, method)?;
        let Speedup { ratio, interval } = speedup;
        Some(Self { ratio, interval, verdict: speedup.verdict(0.0), n: method.len() })
    }
}

/// The stages as bars stack them, each with its place in [`Stage::OF_ORDERS`]: tracing first, then what an order adds to
/// it, so that it is seen how much of what the trace saves is left.
pub fn stacked() -> impl Iterator<Item = (usize, Stage)> {
    let is_trace = |(_, stage): &(usize, Stage)| matches!(stage, Stage::Trace | Stage::TraceIndirect);
    let all = || Stage::OF_ORDERS.into_iter().enumerate();
    all().filter(is_trace).chain(all().filter(move |stage| !is_trace(stage)))
}

/// What a stage is called in legends.
pub fn stage_name(stage: Stage) -> &'static str {
    match stage {
        Stage::TraceIndirect => "trace through indices",
        other => other.name(),
    }
}

/// The times of an order's stages, those that were taken.
pub fn stages(samples: &StageSamples, traffic: &Traffic, rays: u64) -> Vec<StageTime> {
    let of = |stage: Stage| {
        let time = Time::of(samples.of(stage), rays)?;
        let bytes_per_ray = traffic.bytes_per_ray(stage);
        let bytes_per_second =
            bytes_per_ray.and_then(|bytes| bytes_per_second(bytes.saturating_mul(rays), time.median_ns));
        Some(StageTime { stage, time, bytes_per_ray, bytes_per_second })
    };
    Stage::OF_ORDERS.into_iter().filter_map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_are_rays_over_medians() {
        let time = Time::of(&[2_000, 1_000, 3_000], 4_000).unwrap();
        assert_eq!((time.median_ns, time.quartiles_ns), (2_000.0, (1_500.0, 2_500.0)));
        assert_eq!(time.mrays_per_second, 2_000.0);
        assert_eq!(Time::of(&[], 1), None);
    }
}
