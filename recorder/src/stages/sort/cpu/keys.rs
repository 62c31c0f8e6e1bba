//! Keys as the key stage writes them and the sort reads them.

use formats::npy::Dtype;

/// Keys in canonical order.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Keys {
    /// Bits of a key, 1 to 64; all above are 0.
    pub bits: u32,
    /// The keys.
    pub words: Words,
}

/// Keys in the width that a dump stores.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Words {
    /// Up to 32 bits, `<u4`.
    Narrow(Vec<u32>),
    /// Up to 64 bits, `<u8`.
    Wide(Vec<u64>),
}

impl Keys {
    /// Keys of `bits` bits in their width.
    pub fn of(keys: &[u64], bits: u32) -> Self {
        let words = if bits <= u32::BITS {
            Words::Narrow(keys.iter().map(|&key| key as u32).collect())
        } else {
            Words::Wide(keys.to_vec())
        };
        Self { bits, words }
    }

    /// Makes and touches room for so many keys of any value.
    pub fn make_room(&mut self, count: usize, bits: u32) {
        self.bits = bits;
        match &mut self.words {
            Words::Narrow(words) if bits <= u32::BITS => words.resize(count, 0),
            Words::Wide(words) if bits > u32::BITS => words.resize(count, 0),
            words if bits <= u32::BITS => *words = Words::Narrow(vec![0; count]),
            words => *words = Words::Wide(vec![0; count]),
        }
    }
}

impl Words {
    /// How many there are.
    pub fn len(&self) -> usize {
        match self {
            Self::Narrow(words) => words.len(),
            Self::Wide(words) => words.len(),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Bits that each is stored in, 32 or 64.
    pub fn stored_bits(&self) -> u32 {
        match self {
            Self::Narrow(_) => u32::BITS,
            Self::Wide(_) => u64::BITS,
        }
    }

    /// Type of each in a dump.
    pub fn dtype(&self) -> Dtype {
        match self {
            Self::Narrow(_) => Dtype::U4,
            Self::Wide(_) => Dtype::U8,
        }
    }

    /// Their bytes, as a dump stores them.
    pub fn bytes(&self) -> &[u8] {
        match self {
            Self::Narrow(words) => bytemuck::cast_slice(words),
            Self::Wide(words) => bytemuck::cast_slice(words),
        }
    }
}

impl Default for Words {
    fn default() -> Self {
        Self::Narrow(Vec::new())
    }
}
