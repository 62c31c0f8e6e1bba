//! Keys as the key stage writes them and the sort reads them.

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
    /// Up to 32 bits.
    Narrow(Vec<u32>),
    /// Up to 64 bits.
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

    /// How many there are.
    pub fn len(&self) -> usize {
        match &self.words {
            Words::Narrow(words) => words.len(),
            Words::Wide(words) => words.len(),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
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

impl Default for Words {
    fn default() -> Self {
        Self::Narrow(Vec::new())
    }
}
