//! The length table against exact integers: sums beyond 32 bits, misses only, one cell for all.

use std::collections::BTreeMap;

use formats::length_table::{
    DUMMY_SUM, LENGTH_FRACTION_BITS, LONGEST_SUMMED, LengthCell, LengthTable, LengthTableError,
};
use proptest::prelude::*;

use crate::cases;

const BITS: u32 = 8;

/// Sums and counts in integers that nothing here can overflow.
#[derive(Default)]
struct Exact(BTreeMap<u32, (u128, u128)>);

impl Exact {
    fn add(&mut self, cell: u32, length: f32, times: u128) {
        // Exact in f64: a number of 24 bits times a power of two.
        let scaled =
            f64::from(length).min(f64::from(LONGEST_SUMMED)) * f64::from(1u32 << LENGTH_FRACTION_BITS);
        let (sum, count) = self.0.entry(cell).or_insert((u128::from(DUMMY_SUM), 1));
        *sum += scaled.floor() as u128 * times;
        *count += times;
    }

    fn mean(&self, cell: u32) -> f64 {
        let (sum, count) = self.0.get(&cell).copied().unwrap_or((u128::from(DUMMY_SUM), 1));
        (sum / count / 2) as f64 / f64::from(1u32 << (LENGTH_FRACTION_BITS - 1))
    }

    fn touched(&self) -> Vec<LengthCell> {
        let cell = |(&cell, &(sum, count)): (&u32, &(u128, u128))| LengthCell {
            cell,
            count: u32::try_from(count).unwrap(),
            sum: u64::try_from(sum).unwrap(),
        };
        self.0.iter().map(cell).collect()
    }
}

fn assert_same(table: &LengthTable, exact: &Exact) {
    assert_eq!(table.touched(), exact.touched());
    for cell in 0..1 << BITS {
        assert_eq!(f64::from(table.mean(cell)), exact.mean(cell), "cell {cell}");
    }
}

/// Lengths as rays have them: within the scene, misses, the shortest and the longest.
fn length() -> impl Strategy<Value = f32> {
    prop_oneof![
        0f32..2.5,
        Just(f32::INFINITY),
        Just(f32::MAX),
        Just(0.0),
        Just(-0.0),
        Just(f32::MIN_POSITIVE),
        Just(1e-45),
        Just(2.0),
        Just(2f32.next_down()),
        Just(2f32.next_up()),
    ]
}

proptest! {
    #![proptest_config(cases(200))]

    #[test]
    fn any_rays_in_any_order_give_the_exact_table(
        rays in prop::collection::vec((0u32..1 << BITS, length()), 0..600),
        turn in any::<prop::sample::Index>(),
    ) {
        let (table, turned) = (LengthTable::new(BITS), LengthTable::new(BITS));
        let mut exact = Exact::default();
        for &(cell, length) in &rays {
            table.add(cell, length);
            exact.add(cell, length, 1);
        }
        assert_same(&table, &exact);
        let (before, after) = rays.split_at(if rays.is_empty() { 0 } else { turn.index(rays.len()) });
        after.iter().chain(before).for_each(|&(cell, length)| turned.add(cell, length));
        prop_assert_eq!(turned.touched(), table.touched());
        prop_assert_eq!(LengthTable::from_touched(BITS, &table.touched()).unwrap().touched(), table.touched());
    }

    /// What 2^31 additions leave behind, without making them: stored, read again and added to.
    #[test]
    fn billions_of_rays_are_summed_exactly(
        stored in prop::collection::btree_map(0u32..1 << BITS, (1u32..u32::MAX - 600, length()), 0..20),
        rays in prop::collection::vec((0u32..1 << BITS, length()), 0..500),
    ) {
        let mut exact = Exact::default();
        for (&cell, &(times, length)) in &stored {
            exact.add(cell, length, times.into());
        }
        let table = LengthTable::from_touched(BITS, &exact.touched()).unwrap();
        for &(cell, length) in &rays {
            table.add(cell, length);
            exact.add(cell, length, 1);
        }
        assert_same(&table, &exact);
    }
}

#[test]
fn all_rays_in_one_cell_wrap_32_bits_and_stay_exact() {
    let table = LengthTable::new(BITS);
    let mut exact = Exact::default();
    // Misses that never leave: the longest that can be summed.
    for _ in 0..1_000_000 {
        table.add(17, f32::INFINITY);
    }
    exact.add(17, f32::INFINITY, 1_000_000);
    assert!(exact.touched()[0].sum > 1000 << 32);
    assert_same(&table, &exact);
    assert!((1.99..2.0).contains(&table.mean(17)));
}

/// Rays of at most two unit lengths cannot have summed up to more.
#[test]
fn sums_that_no_rays_have_are_refused() {
    let cell = |count, sum| LengthTable::from_touched(BITS, &[LengthCell { cell: 5, count, sum }]);
    let longest = 2 << LENGTH_FRACTION_BITS;
    assert!(cell(3, DUMMY_SUM + 2 * longest).is_ok() && cell(3, DUMMY_SUM).is_ok());
    assert!(cell(u32::MAX, DUMMY_SUM + u64::from(u32::MAX - 1) * longest).is_ok());
    for (count, sum) in
        [(3, DUMMY_SUM + 2 * longest + 1), (3, DUMMY_SUM - 1), (2, u64::MAX), (u32::MAX, u64::MAX)]
    {
        let error = cell(count, sum).unwrap_err();
        assert!(matches!(error, LengthTableError::Sum { cell: 5, .. }), "{error}");
    }
}
