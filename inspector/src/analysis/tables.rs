//! Fill of the length table, and errors of the lengths that methods estimate.

use formats::key::termination::bounded_length;
use formats::metrics::estimator::EstimateError;
use formats::ray::Ray;
use formats::stored_table::StoredTable;
use formats::traced::Traced;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Rays that a thread takes at a time.
const RAYS_PER_TASK: usize = 8192;

/// How full a length table is, as the methods of a queue read it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TableFill {
    /// Cells that a ray was added to.
    pub touched: u64,
    /// All cells.
    pub cells: u64,
    /// Share of cells that are touched, 0 to 1.
    pub fill: f64,
}

impl TableFill {
    /// Of a stored table.
    pub fn of(table: &StoredTable) -> Self {
        let (touched, cells) = (table.touched(), table.cells());
        Self { touched, cells, fill: touched as f64 / cells as f64 }
    }
}

/// How far the lengths that the two-point methods take are from the traced ones, in unit lengths. The
/// estimates are those of the keys: cut by the ray's own end and by the scene's box.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Estimators {
    /// Of the table's means: two-point-adaptive.
    pub table: EstimateError,
    /// Of one length for all rays: two-point.
    pub constant: EstimateError,
    /// That length before it is cut, unit lengths.
    pub constant_length: f32,
}

impl Estimators {
    /// Of the rays of a queue, whose traced lengths are `lengths`; `None` if no ray has one.
    pub fn of(traced: &Traced, lengths: &[f32], table: &StoredTable, constant_length: f32) -> Option<Self> {
        let of = |estimate: &(dyn Fn(&Ray) -> f32 + Sync)| {
            let bounded = |ray: &Ray| {
                bounded_length(traced.unit(), ray, traced.unit().point(ray.origin), estimate(ray))
            };
            let estimates: Vec<f32> =
                traced.rays().par_iter().with_min_len(RAYS_PER_TASK).map(bounded).collect();
            EstimateError::of(estimates.into_iter().zip(lengths.iter().copied()))
        };
        Some(Self {
            table: of(&|ray| table.mean(ray))?,
            constant: of(&|_| constant_length)?,
            constant_length,
        })
    }
}
