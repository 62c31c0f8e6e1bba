//! Means over rays that end near each other: single rays are noise in which no surface stands out.

use std::collections::HashMap;

use super::order::Order;

/// Rays that share a cell of the grid, about: surfaces have as many cells as the scene's largest side has, squared.
const SHARE: f64 = 10.0;

/// Gives each value, of the ray at each place, the mean over those whose rays end in the same cell of a grid. NaN,
/// where a value is not known, counts nowhere and stays.
pub fn take_means(order: &Order, places: impl Iterator<Item = usize>, values: &mut [f32]) {
    let along_side = (values.len() as f64 / SHARE).sqrt();
    let cell = |place: usize| {
        order.queue.segment(order.places.ray(place)).end.map(|along| (along * along_side) as i32)
    };
    let cells: Vec<[i32; 3]> = places.map(cell).collect();
    let mut sums: HashMap<[i32; 3], (f64, u32)> = HashMap::new();
    for (cell, value) in cells.iter().zip(&*values).filter(|(_, value)| !value.is_nan()) {
        let sum = sums.entry(*cell).or_default();
        *sum = (sum.0 + f64::from(*value), sum.1 + 1);
    }
    for (cell, value) in cells.iter().zip(values).filter(|(_, value)| !value.is_nan()) {
        if let Some((sum, count)) = sums.get(cell) {
            *value = (sum / f64::from(*count)) as f32;
        }
    }
}
