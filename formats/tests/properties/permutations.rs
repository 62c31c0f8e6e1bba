//! Checks on permutations against sorting: they accept what a stable sort gives, and nothing else.

use formats::permutation::{check_bijection, check_order};
use proptest::prelude::*;

use crate::cases;

/// Keys of few values, so that there are ties.
fn keys() -> impl Strategy<Value = Vec<u32>> {
    prop::collection::vec(0u32..12, 0..200)
}

fn stably_sorted(keys: &[u32]) -> Vec<u32> {
    let mut order: Vec<u32> = (0..keys.len() as u32).collect();
    order.sort_by_key(|&ray| keys[ray as usize]);
    order
}

proptest! {
    #![proptest_config(cases(1000))]

    #[test]
    fn a_stable_sort_is_accepted_and_any_other_order_is_not(
        keys in keys(),
        swap in (any::<prop::sample::Index>(), any::<prop::sample::Index>()),
    ) {
        let sorted = stably_sorted(&keys);
        prop_assert_eq!(check_bijection(&sorted, keys.len()), Ok(()));
        prop_assert_eq!(check_order(&sorted, |ray| u64::from(keys[ray])), Ok(()));
        if keys.len() < 2 {
            return Ok(());
        }
        let mut other = sorted.clone();
        other.swap(swap.0.index(keys.len()), swap.1.index(keys.len()));
        prop_assert_eq!(check_bijection(&other, keys.len()), Ok(()));
        prop_assert_eq!(check_order(&other, |ray| u64::from(keys[ray])).is_ok(), other == sorted, "{:?}", other);
    }

    #[test]
    fn a_bijection_is_what_sorts_to_all_indices(
        rays in 0usize..150,
        order in prop::collection::vec(0u32..160, 0..150),
        changes in prop::collection::vec((any::<prop::sample::Index>(), 0u32..160), 0..3),
    ) {
        // Numbers without any plan are hardly ever a bijection; a few changes of one often are.
        let mut nearly: Vec<u32> = (0..rays as u32).rev().collect();
        for (place, ray) in changes {
            if rays > 0 {
                nearly[place.index(rays)] = ray;
            }
        }
        for order in [order, nearly] {
            let mut sorted = order.clone();
            sorted.sort_unstable();
            let expected = sorted.into_iter().eq(0..rays as u32);
            prop_assert_eq!(check_bijection(&order, rays).is_ok(), expected, "{:?} of {}", order, rays);
        }
    }
}
