//! Rows of `recorder bench error`: run time against error, four curves.

use serde::{Deserialize, Serialize};

use crate::metrics::estimator::EstimateError;
use crate::metrics::speedup::Speedup;
use crate::ray::Kind;

/// The four curves; one that was not asked for has no rows.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ErrorRows {
    /// Trace rate against lost and wrong hits.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub precision: Vec<PrecisionRow>,
    /// Cost of the length table against the error of its estimates.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub estimator: Vec<EstimatorRow>,
    /// Key and sort time against capsule area and trace time.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub key_bits: Vec<KeyBitsRow>,
    /// Wall time against the noise of the picture.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub image: Vec<ImageRow>,
}

/// One trace kernel with one triangle test and one box test on the closest rays of a bounce.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PrecisionRow {
    /// Name of the scene.
    pub scene: String,
    /// Its triangles.
    pub triangles: u64,
    /// Trace kernel: `wide`, `cwbvh`, `bvh2` or `ray-query`.
    pub kernel: String,
    /// `watertight` or `moeller-trumbore`; `driver` where the driver tests.
    pub triangle_test: String,
    /// `padded` or `plain`; `driver` where the driver tests.
    pub box_test: String,
    /// Bounces of the rays, joined: `1-3`.
    pub bounces: String,
    /// What was found wrong, against the exact hits.
    pub errors: HitErrors,
    /// Rays of one sample.
    pub rays_timed: u64,
    /// One sample per repeat, nanoseconds.
    pub samples_ns: Vec<u64>,
}

/// Hits compared with the exact ones; what rounding of the ray's own coordinates explains is not wrong.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct HitErrors {
    /// Rays compared.
    pub rays: u64,
    /// Nothing was found where there is a hit.
    pub missed: u64,
    /// A hit was found where there is none.
    pub false_hits: u64,
    /// A triangle was found, but not the nearest one.
    pub wrong_triangles: u64,
    /// Not the exact answer for the ray, but for one within rounding of it: not counted as wrong.
    pub tied: u64,
    /// |t − exact t| / exact t, over hits of the exact triangle.
    pub relative: Distribution,
    /// |t − exact t| in ulp of the coordinate scale: the largest coordinate of the ray's origin and the
    /// triangle's corners.
    pub ulp: Distribution,
}

/// Median, tail and end of a set of errors.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Distribution {
    /// Half of all are at most this.
    pub median: f64,
    /// 99.9 % of all are at most this.
    pub p999: f64,
    /// The largest.
    pub max: f64,
}

impl Distribution {
    /// Of these numbers, by nearest rank; zeros for none. NaN counts as largest.
    pub fn of(mut values: Vec<f64>) -> Self {
        values.sort_by(f64::total_cmp);
        let at = |share: f64| {
            let rank = (share * values.len() as f64).ceil() as usize;
            values.get(rank.saturating_sub(1)).copied().unwrap_or(0.0)
        };
        Self { median: at(0.5), p999: at(0.999), max: at(1.0) }
    }
}

/// One way to estimate ray lengths, after some passes of learning.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EstimatorRow {
    /// Name of the scene.
    pub scene: String,
    /// Kind of the rays: secondary rays of all bounces, or shadow rays of all bounces.
    pub kind: Kind,
    /// Method whose key addresses the length table; `constant` for the length that `two-point` assumes.
    pub table_method: String,
    /// The table has 2^table_bits cells; 0 for the constant.
    pub table_bits: u32,
    /// Pass whose rays were estimated, from 1: so many passes less one had been added before, and the
    /// earlier bounces of this one.
    pub pass: u32,
    /// Cells that a ray was added to by then.
    pub cells_touched: u64,
    /// Errors of the estimated lengths, cut by the ray's end and the scene's box as in keys.
    pub error: EstimateError,
    /// Rays of one timed sample; 0 in passes that were not timed.
    pub rays_timed: u64,
    /// Time to add the rays of a queue to the table, nanoseconds; empty for the constant.
    pub accumulate_ns: Vec<u64>,
    /// Time to make `two-point-adaptive` keys, the query included; for the constant, `two-point` keys.
    pub key_ns: Vec<u64>,
}

/// One method at one number of key bits.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct KeyBitsRow {
    /// Name of the scene.
    pub scene: String,
    /// Bounce of the rays.
    pub bounce: u32,
    /// Kind of the rays.
    pub kind: Kind,
    /// Method, or `unsorted`.
    pub method: String,
    /// Bits of the key; 0 for `unsorted`.
    pub key_bits: u32,
    /// Rays of the queue.
    pub rays: u64,
    /// Mean capsule area of groups of 64, weighted by rays, unit space.
    pub capsule_area: f64,
    /// One sample per repeat, nanoseconds; empty for `unsorted`.
    pub key_ns: Vec<u64>,
    /// As `key_ns`.
    pub sort_ns: Vec<u64>,
    /// Trace of gathered rays; for `unsorted`, in canonical order.
    pub trace_ns: Vec<u64>,
}

/// A picture after some passes, and how long they take when rays are traced in the order of a method.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ImageRow {
    /// Name of the scene.
    pub scene: String,
    /// Method that every queue but that of the camera rays is sorted by, or `unsorted`.
    pub method: String,
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Samples per pixel.
    pub passes: u32,
    /// Time of all of them, keys, sorts, gathers and scatters included, nanoseconds on the device's clock.
    pub wall_ns: u64,
    /// Over `unsorted`, by passes; of `unsorted` and of results before this field there is none.
    #[serde(default)]
    pub speedup: Option<Speedup>,
    /// Mean squared error of the picture, relative to the reference.
    pub relative_mse: f64,
    /// Samples per pixel of the reference, which has another seed.
    pub reference_passes: u32,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranks_of_a_distribution() {
        assert_eq!(Distribution::of(vec![]), Distribution::default());
        let of = Distribution::of((1..=1000).rev().map(f64::from).collect());
        assert_eq!((of.median, of.p999, of.max), (500.0, 999.0, 1000.0));
        assert_eq!(Distribution::of(vec![3.0]), Distribution { median: 3.0, p999: 3.0, max: 3.0 });
        assert!(Distribution::of(vec![f64::NAN, 1.0]).max.is_nan());
    }
}
