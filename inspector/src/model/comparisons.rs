//! Comparisons, found on another thread.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use formats::manifest::QueueId;

use super::background::{Background, Waker};
use super::comparison::{Comparison, Difference};
use super::order::Order;
use crate::analysis::GroupWidth;

/// One side: the opening of a recording, a queue and a method.
pub type Side = (u64, QueueId, String);

/// What is compared, and what colours stand for.
#[derive(Clone, Debug, PartialEq)]
pub struct Wanted {
    /// Left and right.
    pub sides: [Side; 2],
    /// Rays of a group.
    pub width: GroupWidth,
    /// What each ray has a number for.
    pub difference: Option<Difference>,
}

/// A comparison with the numbers of its rays.
pub struct Compared {
    /// The comparison.
    pub comparison: Comparison,
    /// A number for each ray, left and right, if one was wanted.
    pub values: Option<[Arc<Vec<f32>>; 2]>,
    /// Size below which nearly all of the right side's numbers are; 0 without numbers.
    pub nearly_largest: f32,
    /// Differs from that of all others.
    pub id: u64,
}

/// The last comparison, and the one that is being found.
#[derive(Default)]
pub struct Comparisons(Background<Wanted, Arc<Compared>, 1>);

impl Comparisons {
    /// The comparison of two orders; `None` while it is being found.
    pub fn of(&mut self, wanted: &Wanted, orders: [&Arc<Order>; 2], waker: &Waker) -> Option<Arc<Compared>> {
        static MADE: AtomicU64 = AtomicU64::new(0);
        let [left, right] = orders.map(Arc::clone);
        let (width, difference) = (wanted.width, wanted.difference);
        let make = move || {
            let comparison = Comparison::of(&left, &right, width);
            let values = difference.map(|difference| comparison.values(difference).map(Arc::new));
            let nearly_largest = values.as_ref().map_or(0.0, |[_, right]| nearly_largest(right));
            let id = MADE.fetch_add(1, Ordering::Relaxed);
            Arc::new(Compared { comparison, values, nearly_largest, id })
        };
        self.0.of(wanted.clone(), waker, make).ok().cloned()
    }
}

/// The 98th percentile of the sizes of numbers.
fn nearly_largest(values: &[f32]) -> f32 {
    let mut sizes: Vec<f32> =
        values.iter().map(|value| value.abs()).filter(|size| size.is_finite()).collect();
    let at = sizes.len() * 98 / 100;
    if sizes.is_empty() { 0.0 } else { *sizes.select_nth_unstable_by(at, f32::total_cmp).1 }
}
