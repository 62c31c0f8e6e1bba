//! Properties that hold for any input: keys, length tables, permutations and capsules against
//! oracles that share no code with them.
#![allow(clippy::unwrap_used, reason = "this is test code, also outside test functions")]

mod capsules;
mod keys;
mod length_tables;
mod oracle;
mod permutations;

use proptest::test_runner::{Config, RngSeed};

/// Every case comes from this seed, and again in the next run.
const SEED: u64 = 0x5eed_cafe;

/// So many cases, always the same.
fn cases(cases: u32) -> Config {
    Config { cases, rng_seed: RngSeed::Fixed(SEED), failure_persistence: None, ..Config::default() }
}
