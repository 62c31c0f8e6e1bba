//! Ranges of values: what the ends of a colour bar stand for.

use rayon::prelude::*;

/// The lowest and highest value that colours tell apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ValueRange {
    /// The first colour.
    pub low: f32,
    /// The last colour.
    pub high: f32,
}

impl ValueRange {
    /// Where a value lies, 0 at the low end and 1 at the high one; outside of 0..1 if it is outside.
    pub fn part(self, value: f32) -> f32 {
        if self.high > self.low { (value - self.low) / (self.high - self.low) } else { 0.5 }
    }
}

/// Values in ascending order, so that ranges and histograms of millions of them are found in no time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Values(Vec<f32>);

impl Values {
    /// Sorts the finite ones of these.
    pub fn of(values: impl ParallelIterator<Item = f32>) -> Self {
        let mut finite: Vec<f32> = values.filter(|value| value.is_finite()).collect();
        finite.par_sort_unstable_by(f32::total_cmp);
        Self(finite)
    }

    /// From one percentile to another (0 to 100); 0 to 1 if there are no values.
    pub fn percentiles(&self, low: f32, high: f32) -> ValueRange {
        let Some(last) = self.0.len().checked_sub(1) else { return ValueRange { low: 0.0, high: 1.0 } };
        let at = |percent: f32| {
            let place = f64::from(percent.clamp(0.0, 100.0)) / 100.0 * last as f64;
            self.0[place.round() as usize]
        };
        ValueRange { low: at(low), high: at(high) }
    }

    /// How many lie in each of `bins` equal parts of a range; those outside are in none.
    pub fn histogram(&self, range: ValueRange, bins: usize) -> Vec<u32> {
        let bin = |value: f32| (range.part(value) * bins as f32) as usize;
        let first = self.0.partition_point(|value| range.part(*value) < 0.0);
        let end = self.0.partition_point(|value| range.part(*value) <= 1.0);
        let within = &self.0[first..end.max(first)];
        let mut before = 0;
        let count = |at: usize| {
            // The last one has the high end too.
            let is_before = |&value: &f32| at + 1 == bins || bin(value) <= at;
            let first = std::mem::replace(&mut before, within.partition_point(is_before));
            (before - first) as u32
        };
        (0..bins).map(count).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_leave_outliers_out() {
        let mut values: Vec<f32> = (0..=100).map(|value| value as f32).collect();
        values.reverse();
        values.extend([f32::INFINITY, f32::NAN]);
        let values = Values::of(values.into_par_iter());
        assert_eq!(values.percentiles(0.0, 100.0), ValueRange { low: 0.0, high: 100.0 });
        assert_eq!(values.percentiles(5.0, 95.0), ValueRange { low: 5.0, high: 95.0 });
        let none = Values::of([f32::NAN].into_par_iter());
        assert_eq!(none.percentiles(5.0, 95.0), ValueRange { low: 0.0, high: 1.0 });
    }

    #[test]
    fn every_value_in_the_range_is_counted_once() {
        let values = Values::of([1.5, 0.0, 0.1, -0.1, 0.5, 0.99, 1.0, f32::NAN].into_par_iter());
        assert_eq!(values.histogram(ValueRange { low: 0.0, high: 1.0 }, 4), [2, 0, 1, 2]);
        let same = Values::of([3.0; 5].into_par_iter());
        assert_eq!(same.histogram(ValueRange { low: 3.0, high: 3.0 }, 2), [0, 5]);
    }
}
