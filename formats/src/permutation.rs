//! Checks on permutations: a bijection, ascending in the keys, stable.

/// What is wrong with a permutation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[expect(missing_docs, reason = "each message says what it and its fields mean")]
pub enum PermutationError {
    #[error("the permutation has {found} places, expected {expected}")]
    Length { found: usize, expected: usize },
    #[error("place {place} holds ray {ray}, but there are only {rays} rays")]
    OutOfRange { place: usize, ray: u32, rays: usize },
    #[error("ray {ray} stands at place {place} and at an earlier one")]
    Repeated { place: usize, ray: u32 },
    #[error("the key at place {place} is smaller than the one before it")]
    Descending { place: usize },
    #[error("place {place} breaks a tie against canonical order")]
    Unstable { place: usize },
}

/// Checks that `permutation` holds each of 0..`rays` once.
///
/// # Errors
/// The first place at which it does not.
pub fn check_bijection(permutation: &[u32], rays: usize) -> Result<(), PermutationError> {
    if permutation.len() != rays {
        return Err(PermutationError::Length { found: permutation.len(), expected: rays });
    }
    let mut seen = vec![0u64; rays.div_ceil(64)];
    for (place, &ray) in permutation.iter().enumerate() {
        if ray as usize >= rays {
            return Err(PermutationError::OutOfRange { place, ray, rays });
        }
        let (word, bit) = (ray as usize / 64, 1u64 << (ray % 64));
        if seen[word] & bit != 0 {
            return Err(PermutationError::Repeated { place, ray });
        }
        seen[word] |= bit;
    }
    Ok(())
}

/// Checks that keys ascend along a `permutation` that is a bijection, ties in canonical order; `key` gives the
/// key of a ray by its canonical index.
///
/// # Errors
/// The first place at which they do not.
pub fn check_order(permutation: &[u32], key: impl Fn(usize) -> u64) -> Result<(), PermutationError> {
    for (place, pair) in permutation.windows(2).enumerate() {
        let (before, after) = (key(pair[0] as usize), key(pair[1] as usize));
        if after < before {
            return Err(PermutationError::Descending { place: place + 1 });
        }
        if after == before && pair[1] < pair[0] {
            return Err(PermutationError::Unstable { place: place + 1 });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_fault_is_found() {
        assert_eq!(check_bijection(&[2, 0, 1], 3), Ok(()));
        assert_eq!(check_bijection(&[0, 1], 3), Err(PermutationError::Length { found: 2, expected: 3 }));
        assert_eq!(
            check_bijection(&[0, 3, 1], 3),
            Err(PermutationError::OutOfRange { place: 1, ray: 3, rays: 3 })
        );
        assert_eq!(check_bijection(&[0, 1, 0], 3), Err(PermutationError::Repeated { place: 2, ray: 0 }));
        let key = |ray: usize| [5, 5, 1][ray];
        assert_eq!(check_order(&[2, 0, 1], key), Ok(()));
        assert_eq!(check_order(&[0, 2, 1], key), Err(PermutationError::Descending { place: 1 }));
        assert_eq!(check_order(&[2, 1, 0], key), Err(PermutationError::Unstable { place: 2 }));
    }
}
