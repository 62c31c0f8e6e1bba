//! Direction spread: how much the directions of a group differ.

/// `1 − |Σ d| / n` of unit vectors: 0 if all are the same, 1 if they cancel. `None` for no directions.
pub fn direction_spread(directions: impl IntoIterator<Item = [f32; 3]>) -> Option<f64> {
    let mut sum = [0.0f64; 3];
    let mut count = 0u64;
    for direction in directions {
        for (sum, along) in sum.iter_mut().zip(direction) {
            *sum += f64::from(along);
        }
        count += 1;
    }
    let length = sum.iter().map(|along| along * along).sum::<f64>().sqrt();
    (count > 0).then(|| 1.0 - length / count as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_opposite_and_orthogonal_directions() {
        let axis = |k: usize| [0, 1, 2].map(|axis| if axis == k { 1.0f32 } else { 0.0 });
        assert_eq!(direction_spread([]), None);
        assert_eq!(direction_spread([axis(1); 64]), Some(0.0));
        assert_eq!(direction_spread([axis(0), axis(0).map(|along| -along)]), Some(1.0));
        let orthogonal = direction_spread([axis(0), axis(1)]).unwrap();
        assert!((orthogonal - (1.0 - 0.5f64.sqrt())).abs() < 1e-12);
    }
}
