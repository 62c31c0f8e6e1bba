//! Speedups with bootstrap confidence intervals (DESIGN §7).

/// How many resamples a bootstrap interval is taken from.
const RESAMPLES: usize = 1000;

/// A ratio of two medians and the interval that 95 % of its bootstrap resamples fall into.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Speedup {
    /// Median of the baseline over median of the method.
    pub ratio: f64,
    /// 2.5 % and 97.5 % quantiles; `None` with fewer than two samples on either side.
    pub interval: Option<(f64, f64)>,
}

impl Speedup {
    /// Of `method` over `baseline`, from samples in nanoseconds (both non-empty).
    ///
    /// Percentile bootstrap of the ratio of medians (Efron & Tibshirani 1993, §13), with a fixed
    /// seed, so that the same samples always give the same interval.
    pub fn of(baseline: &[u64], method: &[u64]) -> Option<Self> {
        let ratio = ratio(median(baseline)?, median(method)?);
        if baseline.len() < 2 || method.len() < 2 {
            return Some(Self { ratio, interval: None });
        }
        let mut random = SplitMix(0x5eed);
        let mut ratios: Vec<f64> = (0..RESAMPLES)
            .filter_map(|_| {
                let above = median(&random.resample(baseline))?;
                let below = median(&random.resample(method))?;
                Some(self::ratio(above, below))
            })
            .collect();
        ratios.sort_by(f64::total_cmp);
        let quantile = |q: f64| ratios[((ratios.len() - 1) as f64 * q).round() as usize];
        Some(Self { ratio, interval: Some((quantile(0.025), quantile(0.975))) })
    }

    /// Whether the interval excludes 1; without an interval nothing is known.
    pub fn is_significant(&self) -> bool {
        self.interval.is_some_and(|(low, high)| low > 1.0 || high < 1.0)
    }
}

/// Geometric mean of ratios: the mean under which twice as fast and half as fast cancel. `None` if there
/// are none; those that are not above 0 and finite do not count.
pub fn geometric_mean(ratios: impl IntoIterator<Item = f64>) -> Option<f64> {
    let logarithms = ratios.into_iter().filter(|ratio| *ratio > 0.0 && ratio.is_finite()).map(f64::ln);
    let (sum, count) = logarithms.fold((0.0, 0u32), |(sum, count), ln| (sum + ln, count + 1));
    (count > 0).then(|| (sum / f64::from(count)).exp())
}

fn ratio(above: f64, below: f64) -> f64 {
    above / below.max(f64::MIN_POSITIVE)
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
struct SplitMix(u64);

impl SplitMix {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn resample(&mut self, samples: &[u64]) -> Vec<u64> {
        samples.iter().map(|_| samples[(self.next() % samples.len() as u64) as usize]).collect()
    }
}

/// The samples of one method's stages, in nanoseconds, one per repeat.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct StageSamples {
    /// Making keys, the table query of two-point-adaptive included.
    pub key: Vec<u64>,
    /// Sorting them.
    pub sort: Vec<u64>,
    /// Gathering rays into the new order.
    pub gather: Vec<u64>,
    /// Tracing gathered rays.
    pub trace: Vec<u64>,
    /// Tracing through indices instead.
    pub trace_indirect: Vec<u64>,
    /// Adding lengths to the table; empty but for two-point-adaptive.
    pub accumulate: Vec<u64>,
}

impl StageSamples {
    /// `key + sort + min(gather + trace, trace through indices) + accumulate` per repeat; which of
    /// the two ways is shorter is decided once, by medians.
    pub fn totals(&self) -> Vec<u64> {
        let gathered = median(&self.gather).zip(median(&self.trace)).map(|(gather, trace)| gather + trace);
        let through_indices = median(&self.trace_indirect)
            .is_some_and(|indirect| gathered.is_none_or(|gathered| indirect < gathered));
        let at = |samples: &[u64], repeat: usize| samples.get(repeat).copied().unwrap_or(0);
        (0..self.key.len())
            .map(|repeat| {
                let traced = if through_indices {
                    at(&self.trace_indirect, repeat)
                } else {
                    at(&self.gather, repeat).saturating_add(at(&self.trace, repeat))
                };
                // A file may say that a stage took any time.
                [&self.key, &self.sort, &self.accumulate]
                    .iter()
                    .fold(traced, |total, samples| total.saturating_add(at(samples, repeat)))
            })
            .collect()
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
        assert_eq!(speedup.ratio, 2.0);
        assert!(speedup.is_significant());
        assert!(!Speedup::of(&[90, 110, 100, 95, 105], &[92, 108, 101, 96, 104]).unwrap().is_significant());
        assert_eq!(Speedup::of(&[100], &[50]).unwrap(), Speedup { ratio: 2.0, interval: None });
        assert_eq!(Speedup::of(&[], &[50]), None);
    }

    #[test]
    fn the_interval_covers_the_truth_about_as_often_as_it_says() {
        let mut random = SplitMix(7);
        let mut covered = 0;
        for _ in 0..200 {
            let mut draw =
                |centre: u64| -> Vec<u64> { (0..15).map(|_| centre + random.next() % 21 - 10).collect() };
            let (above, below) = (draw(300), draw(200));
            let (low, high) = Speedup::of(&above, &below).unwrap().interval.unwrap();
            covered += usize::from((low..=high).contains(&1.5));
        }
        assert!(covered >= 180, "covered {covered} of 200");
    }

    #[test]
    fn totals_take_the_shorter_way() {
        let mut stages = StageSamples {
            key: vec![1, 1],
            sort: vec![2, 2],
            gather: vec![5, 5],
            trace: vec![10, 11],
            trace_indirect: vec![12, 12],
            accumulate: vec![],
        };
        assert_eq!(stages.totals(), [15, 15]);
        stages.trace_indirect = vec![99, 99];
        stages.accumulate = vec![1, 2];
        assert_eq!(stages.totals(), [19, 21]);
    }
}
