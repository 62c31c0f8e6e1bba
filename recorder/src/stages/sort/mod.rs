//! Stable radix sort of (key, canonical index).
//!
//! Keys of up to 32 bits are one word, longer ones two, so that no 64-bit integers are needed on
//! the GPU. A first look at the keys finds the bits that differ at all; no other digit gets a
//! pass. (Keys that are short get no look: up to 15 bits on threads, where one pass sorts them, and up
//! to two digits on GPUs that do not sweep.) What comes out is the permutation alone: `permutation[i]` is the canonical
//! index of the key at place i.
//!
//! Both sorts move pairs of one 32-bit word and the index. A second word is fetched for the order
//! that the first one gave: fewer bytes than carrying both all the way.
//!
//! - [`gpu`]: lowest digit first, 8 bits a pass: one sweep (Adinets and Merrill 2022) that needs no workgroup to
//!   wait for another; where subgroups do not fit, reduce, then scan (Merrill and Grimshaw 2011)
//! - [`cpu`]: highest digit first, until what shares it fits a core's own cache

pub mod cpu;
pub mod gpu;

#[cfg(test)]
pub(crate) mod test_keys;

/// Which digits get a pass.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Digits {
    /// Those in which some bit differs, which a first look at the keys finds.
    #[default]
    Differing,
    /// All that a key has: of short keys, or to measure what leaving some out saves.
    All,
}

impl Digits {
    /// The bits that differ, for keys of `bits` bits; `look` finds them.
    fn varying(self, bits: u32, look: impl FnOnce() -> u64) -> u64 {
        match self {
            Self::Differing => look(),
            Self::All => u64::MAX >> (u64::BITS - bits),
        }
    }
}

/// Bits that one pass sorts by on a GPU.
pub const DIGIT_BITS: u32 = 8;

/// Values of a digit.
pub const BINS: usize = 1 << DIGIT_BITS;

/// Bits of a number of keys on a GPU: the upper ones of what a tile says are not counts.
pub const COUNT_BITS: u32 = 30;

/// Digits of a word.
const DIGITS_PER_WORD: u32 = u32::BITS / DIGIT_BITS;
