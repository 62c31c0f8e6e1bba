//! The longest jumps of an order: after which places the next ray starts farthest away.

use std::ops::Range;

use formats::metrics::quantity::{OrderedRays, Quantity};
use rayon::prelude::*;

use crate::filter::Passing;

/// The places in a range, of those that pass the filter, with the longest jumps to the next place of the order;
/// ascending. Rays that start where the next one does have none.
pub fn longest(
    rays: &OrderedRays<'_>,
    range: &Range<usize>,
    passing: Option<&Passing>,
    wanted: usize,
) -> Vec<usize> {
    let length = Quantity::Jump.value();
    let jump = |place: usize| Some((length(rays.at(place)), place)).filter(|(length, _)| *length > 0.0);
    let mut jumps: Vec<(f64, usize)> = match passing {
        None => range.clone().into_par_iter().filter_map(jump).collect(),
        Some(passing) => {
            let places = passing.places()[passing.between(range)].par_iter();
            places.filter_map(|&place| jump(place as usize)).collect()
        }
    };
    if wanted < jumps.len() {
        jumps.select_nth_unstable_by(wanted, |a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        jumps.truncate(wanted);
    }
    let mut places: Vec<usize> = jumps.into_iter().map(|(_, place)| place).collect();
    places.sort_unstable();
    places
}
