//! Values as bytes of a page, in Parquet's encodings. The library's own encoders take several times as long.

use std::ops::BitOr;

/// Whole numbers, or the bits of others.
pub(super) trait Word: Copy + Default + BitOr<Output = Self> {
    /// The same bits with a sign.
    type Signed: Ord + Copy + Default + Into<i64>;
    /// Its bytes.
    const BYTES: usize = size_of::<Self>();
    /// One of them, from the lowest on.
    fn byte(self, at: usize) -> u8;
    /// The difference, wrapped around.
    fn minus(self, other: Self) -> Self;
    /// The same bits with a sign.
    fn signed(self) -> Self::Signed;
    /// The same bits without it.
    fn unsigned(signed: Self::Signed) -> Self;
    /// Bits without the zeros before them.
    fn width(self) -> usize;
    /// The lowest `width` bits of each, without gaps.
    fn pack(words: &[Self; PACKED], width: usize, page: &mut Vec<u8>);
}

macro_rules! words {
    ($($word:ty as $signed:ty, $pack:path;)*) => { $(impl Word for $word {
        type Signed = $signed;
        fn byte(self, at: usize) -> u8 { (self >> (8 * at)) as u8 }
        fn minus(self, other: Self) -> Self { self.wrapping_sub(other) }
        fn signed(self) -> $signed { self as $signed }
        fn unsigned(signed: $signed) -> Self { signed as $word }
        fn width(self) -> usize { (<$word>::BITS - self.leading_zeros()) as usize }
        fn pack(words: &[Self; PACKED], width: usize, page: &mut Vec<u8>) { $pack(words, width, page) }
    })* };
}

words! {
    u32 as i32, pack_narrow;
    u64 as i64, pack_wide;
}

/// BYTE_STREAM_SPLIT: all lowest bytes, then all second ones and so on, of which some are alike.
pub(super) fn split<W: Word>(words: &[W], page: &mut Vec<u8>) {
    for at in 0..W::BYTES {
        page.extend(words.iter().map(|word| word.byte(at)));
    }
}

/// Differences whose smallest is written once.
const BLOCK: usize = 128;
/// Differences of equally many bits.
const PACKED: usize = 32;

/// DELTA_BINARY_PACKED: each word as its difference from the one before, of as many bits as the largest near it.
pub(super) fn differences<W: Word>(words: &[W], page: &mut Vec<u8>) {
    for number in [BLOCK, BLOCK / PACKED, words.len()] {
        variable(number as u64, page);
    }
    let first = words.first().copied().unwrap_or_default();
    variable(zigzag(first.signed().into()), page);
    let others = words.get(1..).unwrap_or_default();
    for (words, before) in others.chunks(BLOCK).zip(words.chunks(BLOCK)) {
        let mut block = [W::default(); BLOCK];
        let differences = words.iter().zip(before).map(|(word, &before)| word.minus(before));
        block.iter_mut().zip(differences).for_each(|(to, difference)| *to = difference);
        let used = &mut block[..words.len()];
        let least = used.iter().map(|difference| difference.signed()).min().unwrap_or_default();
        used.iter_mut().for_each(|difference| *difference = difference.minus(W::unsigned(least)));
        variable(zigzag(least.into()), page);
        let widths = page.len();
        page.extend([0; BLOCK / PACKED]);
        let packs = block.as_chunks::<PACKED>().0.iter().take(words.len().div_ceil(PACKED));
        for (at, pack) in packs.enumerate() {
            let width = pack.iter().fold(W::default(), |all, &difference| all | difference).width();
            page[widths + at] = width as u8;
            W::pack(pack, width, page);
        }
    }
}

/// Code of its own for each width, in which all shifts are known.
fn pack_narrow(words: &[u32; PACKED], width: usize, page: &mut Vec<u8>) {
    macro_rules! by_width {
        ($($width:literal)*) => { match width { $($width => pack::<$width>(words, page),)* _ => {} } };
    }
    by_width!(1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26 27 28 29 30 31 32);
}

#[inline(always)]
fn pack<const WIDTH: usize>(words: &[u32; PACKED], page: &mut Vec<u8>) {
    let mut packed = [[0; 4]; WIDTH];
    let (mut held, mut bits, mut at) = (0u64, 0, 0);
    for &word in words {
        held |= u64::from(word) << bits;
        bits += WIDTH;
        if bits >= 32 {
            packed[at] = (held as u32).to_le_bytes();
            (held, bits, at) = (held >> 32, bits - 32, at + 1);
        }
    }
    page.extend_from_slice(packed.as_flattened());
}

fn pack_wide(words: &[u64; PACKED], width: usize, page: &mut Vec<u8>) {
    let (mut held, mut bits) = (0u128, 0);
    for &word in words {
        held |= u128::from(word) << bits;
        bits += width;
        while bits >= 8 {
            page.push(held as u8);
            (held, bits) = (held >> 8, bits - 8);
        }
    }
}

/// Bits, the first the lowest of a byte.
pub(super) fn bits(values: &[bool], page: &mut Vec<u8>) {
    let byte = |bits: &[bool; 8]| bits.iter().rev().fold(0, |byte, &bit| byte << 1 | u8::from(bit));
    let (bytes, rest) = values.as_chunks();
    page.extend(bytes.iter().map(byte));
    if !rest.is_empty() {
        let mut last = [false; 8];
        last[..rest.len()].copy_from_slice(rest);
        page.push(byte(&last));
    }
}

/// Of a hybrid of runs and bits: the same value, of so many bytes, for so many rows.
pub(super) fn run(rows: usize, value: u32, bytes: usize, page: &mut Vec<u8>) {
    variable((rows as u64) << 1, page);
    page.extend_from_slice(&value.to_le_bytes()[..bytes]);
}

/// Of the same hybrid: for each row whether it has a value.
pub(super) fn presence(present: &[bool], page: &mut Vec<u8>) {
    variable((present.len().div_ceil(8) as u64) << 1 | 1, page);
    bits(present, page);
}

/// Seven bits a byte, the lowest first; all but the last byte have the eighth.
fn variable(mut number: u64, page: &mut Vec<u8>) {
    while number >= 1 << 7 {
        page.push(number as u8 | 1 << 7);
        number >>= 7;
    }
    page.push(number as u8);
}

/// Small numbers of either sign as small ones.
fn zigzag(number: i64) -> u64 {
    (number << 1 ^ number >> 63) as u64
}
