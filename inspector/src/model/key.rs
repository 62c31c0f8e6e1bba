//! A key field by field, in words.

use formats::key::Bit;
use formats::key::decode::{DecodedField, decode};

use super::order::Order;

/// The key of a ray, read back.
#[derive(Clone, Debug, PartialEq)]
pub struct ReadKey {
    /// The key.
    pub key: u64,
    /// Its bits.
    pub key_bits: u32,
    /// What each bit comes from, most significant bit first.
    pub bits: Vec<Bit>,
    /// Its fields, in the layout's order.
    pub fields: Vec<DecodedField>,
}

impl ReadKey {
    /// The key of a ray in an order.
    ///
    /// # Errors
    /// Why it has none.
    pub fn of(order: &Order, ray: usize) -> Result<Self, String> {
        let (keys, layout) = order.keys.as_ref().map_err(String::clone)?;
        let key = keys.at(ray);
        let bits = layout.layout.bits().iter().take(layout.key_bits as usize);
        Ok(Self {
            key,
            key_bits: layout.key_bits,
            bits: bits.cloned().collect(),
            fields: decode(&layout.layout, layout.key_bits, key),
        })
    }

    /// Hexadecimal, with as many digits as its bits take.
    pub fn hexadecimal(&self) -> String {
        format!("{:0digits$x}", self.key, digits = self.key_bits.div_ceil(4) as usize)
    }

    /// The number of the field that a bit is of; of a curve's bits, that of its first coordinate.
    pub fn field_of(&self, bit: &Bit) -> Option<usize> {
        let first = bit.sources().first().and_then(|source| source.axes().first());
        let is_field = |field: &DecodedField| field.bit == *bit || field.bit.coordinate().as_ref() == first;
        self.fields.iter().position(is_field)
    }

    /// Whether a bit is set; 0 is the most significant one.
    pub fn bit(&self, at: usize) -> bool {
        let from_below = (self.key_bits as usize).saturating_sub(at + 1);
        from_below < 64 && self.key >> from_below & 1 == 1
    }
}

/// A field in words: `ox 0.297–0.313`, or its bits where `^` hides the range: `ox ^ ex 10110`.
pub fn field_text(field: &DecodedField) -> String {
    let Some((low, high)) = field.range() else {
        return format!("{} {:0bits$b}", field.bit, field.value, bits = field.bits as usize);
    };
    let decimals = (f64::from(field.bits) * 0.302).ceil() as usize + 1;
    format!("{} {low:.decimals$} – {high:.decimals$}", field.bit)
}
