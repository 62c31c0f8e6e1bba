//! From a quantised coordinate to its bits' places in a key, by tables.

/// Bits of a coordinate that one table lookup spreads over the key.
const CHUNK_BITS: u32 = 8;

/// The bits of one axis of a source, spread to their places.
#[derive(Clone, Debug)]
pub(super) struct Spread {
    /// Shift that brings a quantised coordinate down to the bits that the key uses.
    drop: u32,
    /// One table per chunk of used bits, lowest chunk first.
    tables: Vec<[u64; 1 << CHUNK_BITS]>,
    /// The same in tables that fit a register.
    #[cfg(target_arch = "x86_64")]
    digits: Vec<avx2::Digit>,
}

impl Spread {
    /// Of numbers of `width` bits, whose highest ones go to `positions`, highest first.
    pub(super) fn new(width: u32, positions: &[u32]) -> Self {
        let used = positions.len() as u32;
        let drop = width - used;
        let tables = (0..used.div_ceil(CHUNK_BITS))
            .map(|chunk| {
                std::array::from_fn(|value| spread_digit(positions, chunk * CHUNK_BITS, CHUNK_BITS, value))
            })
            .collect();
        Self {
            drop,
            tables,
            #[cfg(target_arch = "x86_64")]
            digits: avx2::digits(positions, drop),
        }
    }

    /// Adds the bits to keys, by exclusive or.
    #[inline(always)]
    pub(super) fn add_to<const N: usize>(&self, keys: &mut [u64; N], quantised: &[u32; N]) {
        for (chunk, table) in self.tables.iter().enumerate() {
            let shift = self.drop + chunk as u32 * CHUNK_BITS;
            for (key, quantised) in keys.iter_mut().zip(quantised) {
                *key ^= table[(quantised >> shift) as usize & (table.len() - 1)];
            }
        }
    }

    /// The same eight keys at a time; `words` are the lower and the upper halves of the keys.
    #[cfg(target_arch = "x86_64")]
    #[inline]
    #[target_feature(enable = "avx2")]
    pub(super) fn add_to_words<const N: usize>(&self, words: &mut [[u32; N]; 2], quantised: &[u32; N]) {
        self.digits.iter().for_each(|digit| digit.add_to(&mut words[digit.word], quantised));
    }
}

/// Where the bits of a number go that are those from `first` on, `bits` of them, counted from the lowest used one.
fn spread_digit(positions: &[u32], first: u32, bits: u32, number: usize) -> u64 {
    let used = positions.len() as u32;
    (0..bits)
        .filter(|bit| number >> bit & 1 == 1)
        .filter_map(|bit| (used - 1).checked_sub(first + bit))
        .map(|mention| 1u64 << positions[mention as usize])
        .sum()
}

#[cfg(target_arch = "x86_64")]
mod avx2 {
    use std::arch::x86_64::*;

    use super::spread_digit;

    /// Bits of a coordinate that choose one of a register's eight numbers.
    const DIGIT_BITS: u32 = 3;
    /// Keys in a register.
    const LANES: usize = 8;

    /// What three bits of a coordinate are in one half of a key.
    #[derive(Clone, Debug)]
    pub(super) struct Digit {
        shift: u32,
        pub(super) word: usize,
        table: [u32; 1 << DIGIT_BITS],
    }

    pub(super) fn digits(positions: &[u32], drop: u32) -> Vec<Digit> {
        let used = positions.len() as u32;
        let digit = |(first, word): (u32, usize)| Digit {
            shift: drop + first,
            word,
            table: std::array::from_fn(|number| {
                (spread_digit(positions, first, DIGIT_BITS, number) >> (32 * word)) as u32
            }),
        };
        let firsts = (0..used).step_by(DIGIT_BITS as usize);
        let all = firsts.flat_map(|first| [(first, 0), (first, 1)]).map(digit);
        all.filter(|digit| digit.table != [0; 1 << DIGIT_BITS]).collect()
    }

    impl Digit {
        #[inline]
        #[target_feature(enable = "avx2")]
        pub(super) fn add_to<const N: usize>(&self, word: &mut [u32; N], quantised: &[u32; N]) {
            let table: __m256i = bytemuck::cast(self.table);
            let shift = _mm_cvtsi32_si128(self.shift as i32);
            let (word, quantised) = (word.as_chunks_mut::<LANES>().0, quantised.as_chunks::<LANES>().0);
            for (word, &quantised) in word.iter_mut().zip(quantised) {
                // The permutation looks at the lowest three bits of each number.
                let digit = _mm256_srl_epi32(bytemuck::cast(quantised), shift);
                let bits = _mm256_permutevar8x32_epi32(table, digit);
                *word = bytemuck::cast(_mm256_xor_si256(bytemuck::cast(*word), bits));
            }
        }
    }
}
