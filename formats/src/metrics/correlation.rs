//! How two numbers go together.

use serde::Serialize;

/// Correlation of pairs of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Correlation {
    /// Pearson's coefficient: how near the pairs are to a line, −1 to 1.
    pub pearson: f64,
    /// Spearman's: the same of their ranks, so of any rising or falling curve.
    pub spearman: f64,
    /// Pairs.
    pub n: usize,
}

impl Correlation {
    /// Of pairs; those with a number that is not finite do not count. `None` for fewer than three, which
    /// any line fits, and where either number is always the same.
    pub fn of(pairs: &[(f64, f64)]) -> Option<Self> {
        let finite = pairs.iter().filter(|(x, y)| x.is_finite() && y.is_finite());
        let (x, y): (Vec<f64>, Vec<f64>) = finite.copied().unzip();
        if x.len() < 3 {
            return None;
        }
        let pearson = pearson(&x, &y)?;
        let spearman = self::pearson(&ranks(&x), &ranks(&y))?;
        Some(Self { pearson, spearman, n: x.len() })
    }
}

fn pearson(x: &[f64], y: &[f64]) -> Option<f64> {
    let mean = |numbers: &[f64]| numbers.iter().sum::<f64>() / numbers.len() as f64;
    let (mean_x, mean_y) = (mean(x), mean(y));
    let (mut xx, mut yy, mut xy) = (0.0, 0.0, 0.0);
    for (x, y) in x.iter().zip(y) {
        let (x, y) = (x - mean_x, y - mean_y);
        xx += x * x;
        yy += y * y;
        xy += x * y;
    }
    // The roots apart, as the product of two small sums may vanish.
    (xx > 0.0 && yy > 0.0).then(|| (xy / xx.sqrt() / yy.sqrt()).clamp(-1.0, 1.0))
}

/// Ranks from 1; equal numbers share the mean of theirs.
fn ranks(numbers: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..numbers.len()).collect();
    order.sort_by(|&a, &b| numbers[a].total_cmp(&numbers[b]));
    let mut ranks = vec![0.0; numbers.len()];
    let mut start = 0;
    for tied in order.chunk_by(|&a, &b| numbers[a] == numbers[b]) {
        let rank = start as f64 + (tied.len() + 1) as f64 / 2.0;
        tied.iter().for_each(|&place| ranks[place] = rank);
        start += tied.len();
    }
    ranks
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_curves_and_constants() {
        let of = |f: fn(f64) -> f64| {
            Correlation::of(&(1..=20).map(|x| (f64::from(x), f(f64::from(x)))).collect::<Vec<_>>())
        };
        let line = of(|x| 3.0 * x + 1.0).unwrap();
        assert!((line.pearson - 1.0).abs() < 1e-12 && (line.spearman - 1.0).abs() < 1e-12 && line.n == 20);
        let falling = of(|x| (-x).exp()).unwrap();
        assert!((falling.spearman + 1.0).abs() < 1e-12 && falling.pearson > -0.9);
        assert_eq!(of(|_| 2.0), None);
        assert_eq!(Correlation::of(&[(0.0, 1.0), (1.0, 2.0), (f64::NAN, 3.0)]), None);
    }

    /// Against `numpy.corrcoef` of x = 1 2 2 4 5 7, y = 3 1 4 1 5 9, and of their ranks.
    #[test]
    fn ties_share_their_rank() {
        assert_eq!(ranks(&[1.0, 2.0, 2.0, 4.0, 2.0]), [1.0, 3.0, 3.0, 5.0, 3.0]);
        let pairs: Vec<(f64, f64)> =
            [1.0, 2.0, 2.0, 4.0, 5.0, 7.0].into_iter().zip([3.0, 1.0, 4.0, 1.0, 5.0, 9.0]).collect();
        let found = Correlation::of(&pairs).unwrap();
        assert!((found.pearson - 0.724_595_244_322_885_5).abs() < 1e-9, "{found:?}");
        assert!((found.spearman - 0.602_941_176_470_588_5).abs() < 1e-9, "{found:?}");
    }
}
