//! Keys on threads.

use formats::key::{Encoder, Termination};
use formats::length_table::LengthTable;
use formats::ray::Ray;
use rayon::prelude::*;

/// Rays that one task encodes.
const CHUNK: usize = 1 << 14;

/// Keys in canonical order, in the width that a dump stores.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Keys {
    /// Up to 32 bits.
    Narrow(Vec<u32>),
    /// Up to 64 bits.
    Wide(Vec<u64>),
}

/// The estimate of a ray's length that a method sorts by.
pub enum Lengths<'a> {
    /// The same for all rays.
    Fixed(f32),
    /// The mean of the ray's cell; the encoder gives the cell.
    Adaptive(&'a LengthTable, &'a Encoder),
    /// Traced length of a ray by canonical index.
    Real(&'a (dyn Fn(usize) -> f32 + Sync)),
}

impl<'a> Lengths<'a> {
    /// The source that `termination` names.
    pub fn of(
        termination: Termination,
        fixed: f32,
        table: &'a LengthTable,
        cells: &'a Encoder,
        real: &'a (dyn Fn(usize) -> f32 + Sync),
    ) -> Self {
        match termination {
            Termination::Unused | Termination::Fixed => Self::Fixed(fixed),
            Termination::Adaptive => Self::Adaptive(table, cells),
            Termination::Real => Self::Real(real),
        }
    }
}

/// Encodes a queue. `light` gives the light of a ray by canonical index (0 where it has none).
pub fn encode(
    encoder: &Encoder,
    key_bits: u32,
    rays: &[Ray],
    lengths: &Lengths<'_>,
    light: impl Fn(usize) -> u32 + Sync,
) -> Keys {
    let key = |index: usize| {
        let ray = &rays[index];
        let length = match lengths {
            Lengths::Fixed(length) => *length,
            Lengths::Adaptive(table, cells) => table.mean(cells.encode(ray, 0.0, 0) as u32),
            Lengths::Real(real) => real(index),
        };
        encoder.encode(ray, length, light(index))
    };
    if key_bits <= 32 {
        Keys::Narrow(
            (0..rays.len()).into_par_iter().with_min_len(CHUNK).map(|index| key(index) as u32).collect(),
        )
    } else {
        Keys::Wide((0..rays.len()).into_par_iter().with_min_len(CHUNK).map(key).collect())
    }
}
