//! Ranges of values: what the ends of a colour bar stand for.

/// The lowest and highest value that colours tell apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ValueRange {
    /// The first colour.
    pub low: f32,
    /// The last colour.
    pub high: f32,
}

impl ValueRange {
    /// Between two percentiles (0 to 100) of the finite values; 0 to 1 if there are none.
    pub fn of_percentiles(values: &[f32], low: f32, high: f32) -> Self {
        let mut finite: Vec<f32> = values.iter().copied().filter(|value| value.is_finite()).collect();
        if finite.is_empty() {
            return Self { low: 0.0, high: 1.0 };
        }
        finite.sort_unstable_by(f32::total_cmp);
        let at = |percent: f32| {
            let place = f64::from(percent.clamp(0.0, 100.0)) / 100.0 * (finite.len() - 1) as f64;
            finite[place.round() as usize]
        };
        Self { low: at(low), high: at(high) }
    }

    /// Where a value lies, 0 at the low end and 1 at the high one; outside of 0..1 if it is outside.
    pub fn part(self, value: f32) -> f32 {
        if self.high > self.low { (value - self.low) / (self.high - self.low) } else { 0.5 }
    }
}

/// How many finite values lie in each of `bins` equal parts of a range; those outside are in none.
pub fn histogram(values: &[f32], range: ValueRange, bins: usize) -> Vec<u32> {
    let mut counts = vec![0; bins];
    for value in values {
        let part = range.part(*value);
        if (0.0..=1.0).contains(&part) {
            counts[((part * bins as f32) as usize).min(bins.saturating_sub(1))] += 1;
        }
    }
    counts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_leave_outliers_out() {
        let mut values: Vec<f32> = (0..=100).map(|value| value as f32).collect();
        values.extend([f32::INFINITY, f32::NAN]);
        assert_eq!(ValueRange::of_percentiles(&values, 0.0, 100.0), ValueRange { low: 0.0, high: 100.0 });
        assert_eq!(ValueRange::of_percentiles(&values, 5.0, 95.0), ValueRange { low: 5.0, high: 95.0 });
        assert_eq!(ValueRange::of_percentiles(&[f32::NAN], 5.0, 95.0), ValueRange { low: 0.0, high: 1.0 });
    }

    #[test]
    fn every_value_in_the_range_is_counted_once() {
        let values = [0.0, 0.1, 0.5, 0.99, 1.0, 1.5, f32::NAN];
        let counts = histogram(&values, ValueRange { low: 0.0, high: 1.0 }, 4);
        assert_eq!(counts, [2, 0, 1, 2]);
        assert_eq!(histogram(&[3.0; 5], ValueRange { low: 3.0, high: 3.0 }, 2), [0, 5]);
    }
}
