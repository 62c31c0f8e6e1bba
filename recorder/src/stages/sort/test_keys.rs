//! Keys that sorts are tested with, and the order that the standard library gives them.

/// The seed of all keys here; failures repeat, since it is fixed.
const SEED: u64 = 0x0DD5_0F7E_57ED;

/// The order of a stable sort.
pub(crate) fn expected(keys: &[u64]) -> Vec<u32> {
    let mut order: Vec<u32> = (0..keys.len() as u32).collect();
    order.sort_by_key(|&index| keys[index as usize]);
    order
}

/// Random keys of `bits` bits.
pub(crate) fn random(count: usize, bits: u32, salt: u64) -> Vec<u64> {
    let mut random = fastrand::Rng::with_seed(SEED ^ salt);
    (0..count).map(|_| random.u64(..) >> (64 - bits)).collect()
}

/// Description, bits and keys: every kind of order at every width that a recording can have.
pub(crate) fn cases(count: usize) -> Vec<(&'static str, u32, Vec<u64>)> {
    let mut cases = Vec::new();
    for bits in [8, 12, 14, 15, 16, 24, 31, 32, 33, 40, 48, 63, 64] {
        cases.push(("random keys", bits, random(count, bits, u64::from(bits))));
    }
    for bits in [16, 32, 64] {
        let top = u64::MAX >> (64 - bits);
        let mut sorted = random(count, bits, 7);
        sorted.sort_unstable();
        let reversed = sorted.iter().rev().copied().collect();
        // Few values, many of each: only a stable sort keeps their order.
        let few = random(count, bits, 8).iter().map(|key| key % 3 * (top / 2)).collect();
        // Only the top digit, or one in the middle, varies: the passes before it are skipped.
        let top_digit = random(count, bits, 9).iter().map(|key| key | (top >> 8)).collect();
        let one_bit = random(count, bits, 10).iter().map(|key| key & (1 << (bits / 2))).collect();
        let ends = random(count, bits, 11).iter().map(|key| key & (0xFF | 0xFF << (bits - 8))).collect();
        cases.extend([
            ("presorted keys", bits, sorted),
            ("reversed keys", bits, reversed),
            ("equal keys", bits, vec![top / 3; count]),
            ("few keys", bits, few),
            ("keys that differ in the top digit", bits, top_digit),
            ("keys that differ in one bit", bits, one_bit),
            ("keys that differ in the first and last digit", bits, ends),
        ]);
    }
    cases
}
