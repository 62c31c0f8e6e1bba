//! Speedups with bootstrap confidence intervals.

use std::collections::BTreeMap;
use std::fmt;

use serde::{Deserialize, Serialize};

use crate::manifest::{Stage, Way};

/// How many resamples a bootstrap interval is taken from.
const RESAMPLES: usize = 2000;

/// Fewest rounds that a median has a 95 % interval from: the extremes of five hold it in 94 of 100 cases.
pub const INTERVAL_ROUNDS: usize = 6;

/// How far from 1 a control over a whole frame is at most where nothing else runs: it was 0.99 to 1.01.
const CONTROL_BIAS: f64 = 0.03;

/// How many times as fast a method is, and within which interval with 95 % confidence.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Speedup {
    /// Median over rounds of the baseline's time over the method's.
    pub ratio: f64,
    /// The interval; `None` with fewer than [`INTERVAL_ROUNDS`] rounds.
    pub interval: Option<(f64, f64)>,
}

/// What a speedup says beside a control.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// All of the interval is above 1, and farther from it than the control.
    Faster,
    /// All of it is below 1, and farther from it than the control.
    Slower,
    /// The interval contains 1.
    NoSignificantDifference,
    /// It does not, but begins or ends no farther from 1 than the control of these rays lies.
    WithinControl,
    /// There are too few samples for an interval, or samples of two runs, which are no pairs.
    Unknown,
}

impl Verdict {
    /// What it says in words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Faster => "faster",
            Self::Slower => "slower",
            Self::NoSignificantDifference => "no significant difference",
            Self::WithinControl => "within what the control is off by",
            Self::Unknown => "no interval: fewer than 6 rounds, or two runs",
        }
    }

    /// What it says of sorting, as that of a net speedup, in a word; none where nothing is known.
    pub const fn on_sorting(self) -> &'static str {
        match self {
            Self::Faster => "pays",
            Self::Slower => "costs",
            Self::NoSignificantDifference | Self::WithinControl => "level",
            Self::Unknown => "",
        }
    }
}

impl Speedup {
    /// Of a method over a baseline that was measured in the same rounds, nanoseconds each; rounds that one of
    /// them lacks do not count. What slows a whole round down cancels. `None` without a round.
    ///
    /// Percentile bootstrap over rounds, its tails widened for few of them (Hesterberg 2015, "What Teachers
    /// Should Know About the Bootstrap", §5.3), with a fixed seed, so that the same samples always give the same
    /// interval.
    pub fn of(baseline: &[u64], method: &[u64]) -> Option<Self> {
        let ratios: Vec<f64> =
            baseline.iter().zip(method).map(|(&above, &below)| above as f64 / below.max(1) as f64).collect();
        let ratio = median_of(&mut ratios.clone())?;
        if ratios.len() < INTERVAL_ROUNDS {
            return Some(Self { ratio, interval: None });
        }
        let mut random = SplitMix::new();
        let mut medians: Vec<f64> =
            (0..RESAMPLES).filter_map(|_| median_of(&mut random.resample(&ratios))).collect();
        medians.sort_by(f64::total_cmp);
        let tail = (RESAMPLES as f64 * tail_of(ratios.len())) as usize;
        Some(Self { ratio, interval: Some((medians[tail], medians[RESAMPLES - 1 - tail])) })
    }

    /// What it says beside a control that misses 1 by `error`.
    pub fn verdict(&self, error: f64) -> Verdict {
        match self.interval {
            None => Verdict::Unknown,
            Some((low, _)) if low > 1.0 + error => Verdict::Faster,
            Some((_, high)) if high < 1.0 - error => Verdict::Slower,
            Some(_) if self.is_significant() => Verdict::WithinControl,
            Some(_) => Verdict::NoSignificantDifference,
        }
    }

    /// Whether the interval excludes 1; without an interval nothing is known.
    pub fn is_significant(&self) -> bool {
        self.interval.is_some_and(|(low, high)| low > 1.0 || high < 1.0)
    }

    /// Its interval for people, nothing if it has none.
    pub fn interval_text(&self) -> String {
        // A third digit beside 1, on which side of which an end lies.
        let end =
            |end: f64| if (end - 1.0).abs() < 0.005 { format!("{end:.3}") } else { format!("{end:.2}") };
        self.interval.map_or(String::new(), |(low, high)| format!("[{}, {}]", end(low), end(high)))
    }

    /// What stands before it: `≈` where its interval holds 1.
    pub fn mark(&self) -> &'static str {
        if self.interval.is_some() && !self.is_significant() { "≈ " } else { "" }
    }

    /// Whether, as that of a control over a whole frame, it says that other speedups cannot be trusted: its interval
    /// excludes 1, or it misses 1 by more than it does on a machine on which nothing else runs.
    pub fn is_bad_control(&self) -> bool {
        self.is_significant() || (self.ratio - 1.0).abs() > CONTROL_BIAS
    }
}

/// Its ratio and interval.
impl fmt::Display for Speedup {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { ratio, interval } = *self;
        let space = if interval.is_some() { " " } else { "" };
        write!(formatter, "{}{ratio:.2}{space}{}", self.mark(), self.interval_text())
    }
}

/// The part of resamples beyond either end of a 95 % interval: that of the normal distribution beyond
/// √(n / (n − 1)) times the 97.5 % quantile of Student's distribution with n − 1 degrees of freedom.
pub(super) fn tail_of(rounds: usize) -> f64 {
    let (z, freedom) = (1.959_964f64, (rounds - 1) as f64);
    // Cornish and Fisher's expansion (Abramowitz & Stegun 26.7.5), to 0.003 at 5 degrees of freedom.
    let student = z
        + (z.powi(3) + z) / (4.0 * freedom)
        + (5.0 * z.powi(5) + 16.0 * z.powi(3) + 3.0 * z) / (96.0 * freedom.powi(2))
        + (3.0 * z.powi(7) + 19.0 * z.powi(5) + 17.0 * z.powi(3) - 15.0 * z) / (384.0 * freedom.powi(3));
    let beyond = (rounds as f64 / freedom).sqrt() * student;
    // Abramowitz & Stegun 26.2.16, to 1e-5.
    let t = 1.0 / (1.0 + 0.33267 * beyond);
    let density = (-0.5 * beyond * beyond).exp() / std::f64::consts::TAU.sqrt();
    density * (0.436_183_6 * t - 0.120_167_6 * t * t + 0.937_298 * t.powi(3))
}

pub(super) fn median_of(values: &mut [f64]) -> Option<f64> {
    let middle = values.len() / 2;
    if values.is_empty() {
        return None;
    }
    let is_even = values.len().is_multiple_of(2);
    let (before, &mut above, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
    let below = || before.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    Some(if is_even { (below() + above) / 2.0 } else { above })
}

/// What an instrument misses by: speedups that should be 1, pooled.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Instrument {
    /// How many there are.
    pub experiments: usize,
    /// How many of their intervals hold 1.
    pub hold_one: usize,
    /// Their geometric mean, less 1.
    pub pooled_bias: f64,
    /// Median over them of half the width of the interval; `None` without intervals.
    pub median_half_width: Option<f64>,
}

impl Instrument {
    /// Of speedups of a control; `None` if there are none.
    pub fn of(controls: impl IntoIterator<Item = Speedup>) -> Option<Self> {
        let controls: Vec<Speedup> = controls.into_iter().collect();
        let intervals = || controls.iter().filter_map(|control| control.interval);
        let mut half_widths: Vec<f64> = intervals().map(|(low, high)| (high - low) / 2.0).collect();
        Some(Self {
            experiments: controls.len(),
            hold_one: intervals().filter(|(low, high)| (*low..=*high).contains(&1.0)).count(),
            pooled_bias: geometric_mean(controls.iter().map(|control| control.ratio))? - 1.0,
            median_half_width: median_of(&mut half_widths),
        })
    }
}

/// Geometric mean of ratios: the mean under which twice as fast and half as fast cancel. `None` if there
/// are none; those that are not above 0 and finite do not count.
pub fn geometric_mean(ratios: impl IntoIterator<Item = f64>) -> Option<f64> {
    let logarithms = ratios.into_iter().filter(|ratio| *ratio > 0.0 && ratio.is_finite()).map(f64::ln);
    let (sum, count) = logarithms.fold((0.0, 0u32), |(sum, count), ln| (sum + ln, count + 1));
    (count > 0).then(|| (sum / f64::from(count)).exp())
}

/// Median of samples; the mean of the middle two for an even number. `None` if there are none.
pub fn median(samples: &[u64]) -> Option<f64> {
    quantile(samples, 0.5)
}

/// Interquartile range of samples, by linear interpolation. `None` if there are none.
pub fn interquartile_range(samples: &[u64]) -> Option<f64> {
    Some(quantile(samples, 0.75)? - quantile(samples, 0.25)?)
}

/// Quantile `q` (0 to 1) of samples, by linear interpolation. `None` if there are none.
pub fn quantile(samples: &[u64], q: f64) -> Option<f64> {
    let mut sorted = samples.to_vec();
    sorted.sort_unstable();
    let place = sorted.len().checked_sub(1)? as f64 * q;
    let (below, above) = (sorted[place.floor() as usize] as f64, sorted[place.ceil() as usize] as f64);
    Some(below + (above - below) * place.fract())
}

/// SplitMix64 (Steele, Lea & Flood 2014).
pub(super) struct SplitMix(u64);

impl SplitMix {
    /// Always the same numbers.
    pub(super) fn new() -> Self {
        Self(0x5eed)
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number below `count`, which is not 0.
    pub(super) fn below(&mut self, count: usize) -> usize {
        (self.next() % count as u64) as usize
    }

    pub(super) fn resample(&mut self, samples: &[f64]) -> Vec<f64> {
        samples.iter().map(|_| samples[self.below(samples.len())]).collect()
    }
}

/// The samples of an order's stages, in nanoseconds, one per round.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct StageSamples(BTreeMap<Stage, Vec<u64>>);

impl StageSamples {
    /// The samples of a stage; none if the order does not have it.
    pub fn of(&self, stage: Stage) -> &[u64] {
        self.0.get(&stage).map_or(&[], Vec::as_slice)
    }

    /// The same, to be added to.
    pub fn of_mut(&mut self, stage: Stage) -> &mut Vec<u64> {
        self.0.entry(stage).or_default()
    }

    /// The samples of the trace: of rays as they lie or, where they were traced through indices alone, of that.
    pub fn traced(&self) -> &[u64] {
        match self.of(Stage::Trace) {
            [] => self.of(Stage::TraceIndirect),
            found => found,
        }
    }

    /// All stages that have samples.
    pub fn iter(&self) -> impl Iterator<Item = (Stage, &[u64])> {
        self.0.iter().map(|(&stage, samples)| (stage, samples.as_slice()))
    }

    /// `decide + key + sort + (gather + trace + scatter, or trace through indices) + accumulate` per round, of
    /// those that the order has.
    pub fn totals(&self, way: Way) -> Vec<u64> {
        let stages = [Stage::Decide, Stage::Key, Stage::Sort, Stage::Accumulate].iter().chain(way.stages());
        let stages: Vec<&[u64]> = stages.map(|&stage| self.of(stage)).collect();
        let rounds = stages.iter().map(|samples| samples.len()).max().unwrap_or(0);
        // A file may say that a stage took any time.
        let at = |round: usize| stages.iter().filter_map(move |samples| samples.get(round));
        (0..rounds).map(|round| at(round).fold(0u64, |total, &ns| total.saturating_add(ns))).collect()
    }

    /// The way that is shorter by its medians, where a recording does not say which was chosen.
    pub fn shorter_way(&self) -> Way {
        let ns = |way: Way| -> f64 { way.stages().iter().filter_map(|&stage| median(self.of(stage))).sum() };
        let is_indirect = !self.of(Stage::TraceIndirect).is_empty();
        let is_gathered = !self.of(Stage::Trace).is_empty();
        let is_shorter = !is_gathered || ns(Way::Indices) < ns(Way::Gathered);
        if is_indirect && is_shorter { Way::Indices } else { Way::Gathered }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_and_quartiles() {
        assert_eq!(median(&[]), None);
        assert_eq!(median(&[5, 1, 3]), Some(3.0));
        assert_eq!(median(&[4, 1, 2, 3]), Some(2.5));
        assert_eq!(interquartile_range(&[1, 2, 3, 4, 5]), Some(2.0));
    }

    #[test]
    fn halves_and_doubles_cancel() {
        let mean = geometric_mean([0.5, 2.0, 4.0, 0.25, f64::NAN, 0.0]).unwrap();
        assert!((mean - 1.0).abs() < 1e-12);
        assert!((geometric_mean([1.0, 8.0]).unwrap() - 8.0f64.sqrt()).abs() < 1e-12);
        assert_eq!(geometric_mean([]), None);
    }

    #[test]
    fn clear_differences_are_significant_and_noise_is_not() {
        let slow = [200, 201, 199, 202, 198, 200, 203];
        let fast = [100, 101, 99, 102, 98, 100, 103];
        let speedup = Speedup::of(&slow, &fast).unwrap();
        assert!((speedup.ratio - 2.0).abs() < 0.02, "{speedup:?}");
        assert!(speedup.is_significant());
        let noise =
            Speedup::of(&[90, 110, 100, 95, 105, 97, 103], &[92, 108, 101, 94, 106, 96, 104]).unwrap();
        assert!(!noise.is_significant(), "{noise:?}");
        assert_eq!(Speedup::of(&[100; 5], &[50; 5]).unwrap(), Speedup { ratio: 2.0, interval: None });
        assert_eq!(Speedup::of(&[], &[50]), None);
    }

    #[test]
    fn what_the_control_misses_is_no_gain() {
        let of = |low: f64, high: f64| Speedup { ratio: (low + high) / 2.0, interval: Some((low, high)) };
        let beside = |error: f64| {
            [of(1.01, 1.04), of(0.96, 0.99), of(0.99, 1.5)].map(|speedup| speedup.verdict(error))
        };
        assert_eq!(beside(0.0), [Verdict::Faster, Verdict::Slower, Verdict::NoSignificantDifference]);
        let [within, level] = [Verdict::WithinControl, Verdict::NoSignificantDifference];
        assert_eq!(beside(0.01), [within, within, level], "as far from 1 as the control");
        let unknown = Speedup { ratio: 2.0, interval: None };
        assert_eq!(unknown.verdict(0.0), Verdict::Unknown);
        let texts = [of(1.002, 1.1), of(0.9, 1.3), unknown].map(|speedup| speedup.to_string());
        assert_eq!(texts, ["1.05 [1.002, 1.10]", "≈ 1.10 [0.90, 1.30]", "2.00"]);
    }

    #[test]
    fn a_control_is_bad_if_it_surely_or_clearly_misses_one() {
        let is_bad = |ratio, interval| Speedup { ratio, interval }.is_bad_control();
        assert!(is_bad(1.01, Some((1.005, 1.02))) && is_bad(1.2, Some((0.9, 1.4))) && is_bad(0.8, None));
        assert!(!is_bad(1.01, Some((0.99, 1.02))) && !is_bad(0.99, None));
    }

    #[test]
    fn what_slows_whole_rounds_down_cancels() {
        let drift = |at_once: u64| (0..9).map(|round| at_once * (100 + 50 * (round % 3))).collect::<Vec<_>>();
        let (low, high) = Speedup::of(&drift(3), &drift(2)).unwrap().interval.unwrap();
        assert!((low - 1.5).abs() < 1e-9 && (high - 1.5).abs() < 1e-9, "{low} to {high}");
    }

    /// Rounds of 7, 11 and 15, over medians of skewed noise: 95 of 100 intervals hold the truth, to chance.
    #[test]
    fn the_interval_covers_the_truth_as_often_as_it_says() {
        let mut random = SplitMix(7);
        for rounds in [7, 11, 15] {
            let covered = (0..1000).filter(|_| {
                let mut draw = |_| 1_000_000 + (random.next() % 1000) * (random.next() % 1000);
                let above: Vec<u64> = (0..rounds).map(&mut draw).collect();
                let below: Vec<u64> = (0..rounds).map(&mut draw).collect();
                let (low, high) = Speedup::of(&above, &below).unwrap().interval.unwrap();
                (low..=high).contains(&1.0)
            });
            let covered = covered.count();
            assert!((940..=995).contains(&covered), "{covered} of 1000 with {rounds} rounds");
        }
    }

    #[test]
    fn totals_take_one_way() {
        let mut stages = StageSamples::default();
        for (stage, samples) in [
            (Stage::Key, [1, 1]),
            (Stage::Sort, [2, 2]),
            (Stage::Gather, [5, 5]),
            (Stage::Trace, [10, 11]),
            (Stage::Scatter, [1, 1]),
            (Stage::TraceIndirect, [12, 20]),
        ] {
            stages.of_mut(stage).extend(samples);
        }
        assert_eq!(stages.totals(Way::Gathered), [19, 20]);
        assert_eq!(stages.totals(Way::Indices), [15, 23]);
        assert_eq!(stages.shorter_way(), Way::Indices);
        assert_eq!(stages.traced(), [10, 11]);
        stages.of_mut(Stage::Trace).clear();
        assert_eq!(stages.traced(), [12, 20]);
        stages.of_mut(Stage::Trace).extend([10, 11]);
        stages.of_mut(Stage::Accumulate).extend([1, u64::MAX]);
        assert_eq!(stages.totals(Way::Gathered), [20, u64::MAX]);
    }
}
