//! Means over rays that end near each other: single rays are noise in which no surface stands out.

use std::collections::HashMap;

use formats::metrics::capsule::Point;

/// Rays that share a cell of the grid, about: surfaces have as many cells as the scene's largest side has, squared.
const SHARE: f64 = 10.0;

/// Gives each value, of the ray that ends at each point of unit space, the mean over those in the same cell of a
/// grid. NaN, where a value is not known, counts nowhere and stays.
pub fn take_means(ends: impl Iterator<Item = Point>, values: &mut [f32]) {
    let along_side = (values.len() as f64 / SHARE).sqrt();
    let cells: Vec<[i32; 3]> = ends.map(|end| end.map(|along| (along * along_side) as i32)).collect();
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
