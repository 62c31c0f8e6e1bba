//! How costs grow: the exponent b of c·n^b, fitted to measured costs.

use serde::{Deserialize, Serialize};

/// Student's 97.5 % quantiles for 1 to 10 degrees of freedom; more take the last, which is wider than theirs.
const STUDENT: [f64; 10] = [12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228];

/// The exponent b of a cost that grows as n^b.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Exponent {
    /// Slope of the line of least squares through the logarithms.
    pub value: f64,
    /// Its 95 % interval, from how far the points lie off the line; `None` for two points.
    pub interval: Option<(f64, f64)>,
}

impl Exponent {
    /// Through points of n and cost; those that are not above 0 do not count. `None` without two different n.
    pub fn of(points: impl IntoIterator<Item = (f64, f64)>) -> Option<Self> {
        let usable = points.into_iter().filter(|&(n, cost)| n > 0.0 && cost > 0.0);
        let points: Vec<(f64, f64)> = usable.map(|(n, cost)| (n.ln(), cost.ln())).collect();
        let count = points.len() as f64;
        let mean = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / count;
        let (x, y) = (mean(|point| point.0), mean(|point| point.1));
        let width: f64 = points.iter().map(|point| (point.0 - x).powi(2)).sum();
        if points.len() < 2 || width < 1e-12 {
            return None;
        }
        let value = points.iter().map(|point| (point.0 - x) * (point.1 - y)).sum::<f64>() / width;
        let freedom = points.len() - 2;
        let interval = (freedom > 0).then(|| {
            let off: f64 = points.iter().map(|point| (point.1 - y - value * (point.0 - x)).powi(2)).sum();
            let half = STUDENT[freedom.min(STUDENT.len()) - 1] * (off / freedom as f64 / width).sqrt();
            (value - half, value + half)
        });
        Some(Self { value, interval })
    }

    /// What n·log n, which is no power of n, comes to over the same n. The logarithm is that of n + 1, so that
    /// an n of 1 counts.
    pub fn of_n_log_n(ns: impl IntoIterator<Item = f64>) -> Option<f64> {
        Self::of(ns.into_iter().map(|n| (n, n * n.ln_1p()))).map(|exponent| exponent.value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_have_their_exponents_and_noise_an_interval_that_holds_them() {
        let ns = [1e3f64, 1e4, 1e5, 1e6, 1e7];
        let exact = Exponent::of(ns.map(|n| (n, 5.0 * n.powf(1.5)))).unwrap();
        let (low, high) = exact.interval.unwrap();
        assert!((exact.value - 1.5).abs() < 1e-9 && high - low < 1e-6, "{exact:?}");
        let noisy: Vec<(f64, f64)> =
            ns.iter().zip([1.1, 0.9, 1.05, 0.95, 1.0]).map(|(&n, f)| (n, n * f)).collect();
        let (low, high) = Exponent::of(noisy).unwrap().interval.unwrap();
        assert!(low < 1.0 && 1.0 < high && high - low > 0.01, "{low} to {high}");
        let n_log_n = Exponent::of_n_log_n(ns).unwrap();
        assert!((1.08..1.11).contains(&n_log_n), "{n_log_n}");
        assert_eq!(Exponent::of([(10.0, 1.0), (20.0, 4.0)]).unwrap().interval, None);
        assert_eq!(Exponent::of([(10.0, 1.0), (10.0, 2.0), (20.0, 0.0)]), None);
    }
}
