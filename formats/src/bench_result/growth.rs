//! Rows of `recorder bench growth`.

use serde::{Deserialize, Serialize};

use crate::metrics::growth::Exponent;

/// How one cost grows with one size, all else being equal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GrowthRow {
    /// Name of the scene.
    pub scene: String,
    /// What grows: `triangles`, `rays`, `bounces`, `lights` or `threads`.
    pub against: String,
    /// What it costs: a stage, `hierarchy`, `memory to build` or `memory to trace`.
    pub cost: String,
    /// `ns` or `bytes`.
    pub unit: String,
    /// The cost of each size, in ascending order.
    pub points: Vec<GrowthPoint>,
}

/// What one size costs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GrowthPoint {
    /// The size: how many triangles, rays of a pass, bounces, lights or threads.
    pub n: u64,
    /// One sample per repeat; of memory a single one.
    pub samples: Vec<u64>,
}

/// How a cost grows beside n·log n.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The exponent is at most that of n·log n.
    Within,
    /// It is more, but its interval holds less.
    NotShown,
    /// Its whole interval is more.
    Worse,
}

impl GrowthRow {
    /// Size and least sample of each point: what else a machine does only adds to a cost, the more the longer
    /// it takes, which medians would show as growth.
    pub fn least(&self) -> Vec<(f64, f64)> {
        let of = |point: &GrowthPoint| Some((point.n as f64, *point.samples.iter().min()? as f64));
        self.points.iter().filter_map(of).collect()
    }

    /// Its exponent over all points, and what n·log n comes to over the same; `None` with fewer than two.
    pub fn exponents(&self) -> Option<(Exponent, f64)> {
        let points = self.least();
        let n_log_n = Exponent::of_n_log_n(points.iter().map(|point| point.0))?;
        Some((Exponent::of(points)?, n_log_n))
    }

    /// Whether it grows worse than n·log n.
    pub fn verdict(&self) -> Option<Verdict> {
        let (exponent, n_log_n) = self.exponents()?;
        Some(match exponent.interval.map_or(exponent.value, |interval| interval.0) {
            _ if exponent.value <= n_log_n => Verdict::Within,
            low if low <= n_log_n => Verdict::NotShown,
            _ => Verdict::Worse,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn squares_are_worse_than_n_log_n_and_n_log_n_is_not() {
        let row = |cost: fn(f64) -> f64| {
            let point = |n: u64| GrowthPoint { n, samples: vec![cost(n as f64) as u64] };
            let points = [1_000, 10_000, 100_000, 1_000_000].map(point).to_vec();
            let [scene, against, cost, unit] = ["a", "triangles", "hierarchy", "ns"].map(str::to_owned);
            GrowthRow { scene, against, cost, unit, points }
        };
        assert_eq!(row(|n| n * n).verdict(), Some(Verdict::Worse));
        assert_eq!(row(|n| 1e3 * n.ln()).verdict(), Some(Verdict::Within));
        let wavering = row(|n| if n < 5e5 { n } else { 3.0 * n });
        assert_eq!(wavering.verdict(), Some(Verdict::NotShown), "{:?}", wavering.exponents());
        assert_eq!(GrowthRow { points: Vec::new(), ..wavering }.verdict(), None);
    }
}
