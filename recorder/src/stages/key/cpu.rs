//! Keys on threads.

use formats::key::{Encoder, Termination};
use formats::length_table::LengthTable;
use formats::ray::Ray;
use rayon::prelude::*;

use crate::stages::sort::cpu::{Keys, Words};

/// Rays that one task encodes.
const CHUNK: usize = 1 << 12;

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
    let words = if key_bits <= u32::BITS {
        let mut keys = vec![0u32; rays.len()];
        encode_into(encoder, rays, lengths, light, &mut keys, |key| key as u32);
        Words::Narrow(keys)
    } else {
        let mut keys = vec![0u64; rays.len()];
        encode_into(encoder, rays, lengths, light, &mut keys, |key| key);
        Words::Wide(keys)
    };
    Keys { bits: key_bits, words }
}

fn encode_into<T: Send>(
    encoder: &Encoder,
    rays: &[Ray],
    lengths: &Lengths<'_>,
    light: impl Fn(usize) -> u32 + Sync,
    keys: &mut [T],
    narrowed: impl Fn(u64) -> T + Sync,
) {
    rays.par_chunks(CHUNK).zip(keys.par_chunks_mut(CHUNK)).enumerate().for_each(|(number, (rays, keys))| {
        let first = number * CHUNK;
        // The table is asked for all rays of a chunk at once: its cells lie far apart.
        let means: Vec<f32> = match lengths {
            Lengths::Adaptive(table, cells) => {
                let mut means = Vec::with_capacity(rays.len());
                cells.encode_all(rays, |_| 0.0, |_| 0, |_, cell| means.push(table.mean(cell as u32)));
                means
            }
            Lengths::Fixed(_) | Lengths::Real(_) => Vec::new(),
        };
        let length = |at: usize| match lengths {
            Lengths::Fixed(length) => *length,
            Lengths::Adaptive(..) => means[at],
            Lengths::Real(real) => real(first + at),
        };
        encoder.encode_all(rays, length, |at| light(first + at), |at, key| keys[at] = narrowed(key));
    });
}
