//! What cells can hold, and how Parquet has it.

use std::hash::Hash;
use std::sync::Arc;

use parquet::basic::{Encoding, LogicalType, Type};
use parquet::data_type::ByteArray;
use parquet::file::statistics::Statistics;

use super::encode::{self, Word};

/// What a cell can hold.
pub(super) trait Cell: Default {
    /// How columns have it: the same for cells that are the same to the bit.
    type Stored: Clone + Eq + Hash;
    /// Its type in Parquet.
    const KIND: Type;
    /// What that type stands for; nothing where it says enough.
    fn meaning() -> Option<LogicalType>;
    /// The cell as columns have it.
    fn stored(self) -> Self::Stored;
    /// Adds the bytes of one by itself.
    fn plain(cell: &Self::Stored, page: &mut Vec<u8>);
    /// Adds the bytes of many, and says how they are encoded.
    fn encode(cells: &[Self::Stored], page: &mut Vec<u8>) -> Encoding;
    /// The least and the greatest of them, by which engines leave out what cannot meet a condition.
    fn statistics(cells: &[Self::Stored], nulls: usize) -> Statistics;
}

macro_rules! numbers {
    ($($number:ty as $word:ty: $kind:ident, $meaning:expr, $store:expr, $encode:path as $encoding:ident,
        $ends:path, $statistics:path;)*) => { $(impl Cell for $number {
        type Stored = $word;
        const KIND: Type = Type::$kind;
        fn meaning() -> Option<LogicalType> { $meaning }
        fn stored(self) -> $word { $store(self) }
        fn plain(cell: &$word, page: &mut Vec<u8>) { page.extend(cell.to_le_bytes()); }
        fn encode(cells: &[$word], page: &mut Vec<u8>) -> Encoding {
            $encode(cells, page);
            Encoding::$encoding
        }
        fn statistics(cells: &[$word], nulls: usize) -> Statistics {
            let (least, greatest) = $ends(cells).unzip();
            $statistics(least, greatest, None, Some(nulls as u64), false)
        }
    })* };
}

numbers! {
    u32 as u32: INT32, Some(LogicalType::integer(32, false)), |number| number,
        encode::differences as DELTA_BINARY_PACKED, ends_of_words, Statistics::int32;
    u64 as u64: INT64, Some(LogicalType::integer(64, false)), |number| number,
        encode::differences as DELTA_BINARY_PACKED, ends_of_words, Statistics::int64;
    f32 as u32: FLOAT, None, f32::to_bits,
        encode::split as BYTE_STREAM_SPLIT, ends_of_f32, Statistics::float;
    f64 as u64: DOUBLE, None, f64::to_bits,
        encode::split as BYTE_STREAM_SPLIT, ends_of_f64, Statistics::double;
}

/// Ordered without signs, held with one.
fn ends_of_words<W: Word + Ord>(words: &[W]) -> Option<(W::Signed, W::Signed)> {
    let (least, greatest) = (words.iter().min()?, words.iter().max()?);
    Some((least.signed(), greatest.signed()))
}

/// As whole numbers, which are compared many at a time. None if one is not a number.
fn ends_of_f32(bits: &[u32]) -> Option<(f32, f32)> {
    // In the order of the numbers, and back again.
    let turned = |bits: i32| bits ^ ((bits >> 31).cast_unsigned() >> 1).cast_signed();
    let ordered = bits.iter().map(|&bits| turned(bits.cast_signed()));
    let number = |ordered| f32::from_bits(turned(ordered).cast_unsigned());
    let (least, greatest) = (number(ordered.clone().min()?), number(ordered.max()?));
    (!least.is_nan() && !greatest.is_nan()).then_some((least, greatest))
}

fn ends_of_f64(bits: &[u64]) -> Option<(f64, f64)> {
    let numbers = bits.iter().map(|&bits| f64::from_bits(bits));
    let (least, greatest) = (numbers.clone().min_by(f64::total_cmp)?, numbers.max_by(f64::total_cmp)?);
    (!least.is_nan() && !greatest.is_nan()).then_some((least, greatest))
}

impl Cell for bool {
    type Stored = bool;
    const KIND: Type = Type::BOOLEAN;

    fn meaning() -> Option<LogicalType> {
        None
    }

    fn stored(self) -> bool {
        self
    }

    fn plain(cell: &bool, page: &mut Vec<u8>) {
        page.push(u8::from(*cell));
    }

    fn encode(cells: &[bool], page: &mut Vec<u8>) -> Encoding {
        encode::bits(cells, page);
        Encoding::PLAIN
    }

    fn statistics(cells: &[bool], nulls: usize) -> Statistics {
        let (least, greatest) = (cells.iter().min().copied(), cells.iter().max().copied());
        Statistics::boolean(least, greatest, None, Some(nulls as u64), false)
    }
}

impl Cell for Arc<str> {
    type Stored = Self;
    const KIND: Type = Type::BYTE_ARRAY;

    fn meaning() -> Option<LogicalType> {
        Some(LogicalType::String)
    }

    fn stored(self) -> Self {
        self
    }

    fn plain(cell: &Self, page: &mut Vec<u8>) {
        page.extend((cell.len() as u32).to_le_bytes());
        page.extend(cell.as_bytes());
    }

    fn encode(cells: &[Self], page: &mut Vec<u8>) -> Encoding {
        cells.iter().for_each(|cell| Self::plain(cell, page));
        Encoding::PLAIN
    }

    fn statistics(cells: &[Self], nulls: usize) -> Statistics {
        let text = |cell: &Self| ByteArray::from(&**cell);
        let (least, greatest) = (cells.iter().min().map(text), cells.iter().max().map(text));
        Statistics::byte_array(least, greatest, None, Some(nulls as u64), false)
    }
}
