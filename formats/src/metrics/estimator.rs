//! How far estimated ray lengths are from traced ones.

use serde::{Deserialize, Serialize};

/// Errors of an estimate over the rays of a queue, in unit lengths.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct EstimateError {
    /// Mean of |estimate − traced|.
    pub mean_absolute: f64,
    /// Median of it; the mean of the middle two for an even number.
    pub median_absolute: f64,
    /// Root of the mean square.
    pub root_mean_square: f64,
    /// Rays.
    pub n: u64,
}

impl EstimateError {
    /// From pairs of (estimated, traced) lengths; `None` for no pair. Pairs that are not finite, as those
    /// of rays without a direction, do not count. Memory: 4 bytes a pair, since the median is taken from
    /// single-precision errors.
    pub fn of(lengths: impl IntoIterator<Item = (f32, f32)>) -> Option<Self> {
        let (mut sum, mut squares) = (0.0f64, 0.0f64);
        let mut errors: Vec<f32> = Vec::new();
        for (estimated, traced) in lengths {
            let error = (f64::from(estimated) - f64::from(traced)).abs();
            if error.is_finite() {
                sum += error;
                squares += error * error;
                errors.push(error as f32);
            }
        }
        let n = errors.len();
        if n == 0 {
            return None;
        }
        let (mean_absolute, mean_square) = (sum / n as f64, squares / n as f64);
        let (below, &mut upper, _) = errors.select_nth_unstable_by(n / 2, f32::total_cmp);
        let lower = below.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        let lower = if n.is_multiple_of(2) { lower } else { upper };
        let median_absolute = 0.5 * (f64::from(lower) + f64::from(upper));
        Some(Self { mean_absolute, median_absolute, root_mean_square: mean_square.sqrt(), n: n as u64 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_by_hand() {
        assert_eq!(EstimateError::of([]), None);
        let of = EstimateError::of([(0.25, 0.5), (0.25, 0.25), (1.0, 0.25)]).unwrap();
        assert_eq!((of.mean_absolute, of.median_absolute, of.n), (1.0 / 3.0, 0.25, 3));
        assert!((of.root_mean_square - (0.625f64 / 3.0).sqrt()).abs() < 1e-12);
        let even = EstimateError::of([(0.0, 1.0), (0.0, 0.5), (0.0, 0.25), (0.0, 0.0)]).unwrap();
        assert_eq!(even.median_absolute, 0.375);
    }

    #[test]
    fn the_median_is_that_of_sorted_errors_and_endless_rays_do_not_count() {
        let pair = |i: u32| (0.25, (i.wrapping_mul(2_654_435_761) >> 8) as f32 / (1 << 24) as f32);
        for n in [1, 2, 7, 1000, 1001] {
            let mut errors: Vec<f64> =
                (0..n).map(pair).map(|(a, b)| (f64::from(a) - f64::from(b)).abs()).collect();
            errors.sort_by(f64::total_cmp);
            let (low, high) = (errors[(errors.len() - 1) / 2], errors[errors.len() / 2]);
            let endless = [(0.25, f32::INFINITY), (f32::NAN, 1.0)];
            let found = EstimateError::of((0..n).map(pair).chain(endless)).unwrap();
            assert!((found.median_absolute - 0.5 * (low + high)).abs() < 1e-7);
            assert_eq!(found.n, u64::from(n));
        }
    }
}
