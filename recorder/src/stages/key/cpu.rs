//! Keys on threads.

use formats::key::{Encoder, Facts, NO_FACTS, Termination, Word};
use formats::length_table::LengthTable;
use formats::prefetch::prefetch_cell;
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

/// Encodes a queue into keys that have room for it. Lights and paths are by canonical index; a light is 0 where
/// there is none.
///
/// # Panics
/// If there are not as many keys as rays.
pub fn encode(
    encoder: &Encoder,
    rays: &[Ray],
    facts: &Facts<Lengths<'_>, impl Fn(usize) -> u32 + Sync, impl Fn(usize) -> u32 + Sync>,
    keys: &mut Keys,
) {
    match &mut keys.words {
        Words::Narrow(keys) => encode_into(encoder, rays, facts, keys),
        Words::Wide(keys) => encode_into(encoder, rays, facts, keys),
    }
}

fn encode_into<W: Word + Send>(
    encoder: &Encoder,
    rays: &[Ray],
    facts: &Facts<Lengths<'_>, impl Fn(usize) -> u32 + Sync, impl Fn(usize) -> u32 + Sync>,
    keys: &mut [W],
) {
    assert_eq!(rays.len(), keys.len(), "a key for each ray");
    rays.par_chunks(CHUNK).zip(keys.par_chunks_mut(CHUNK)).enumerate().for_each(|(number, (rays, keys))| {
        let first = number * CHUNK;
        let (light, path) = (|at| (facts.light)(first + at), |at| (facts.path)(first + at));
        match facts.length {
            Lengths::Fixed(length) => {
                encoder.encode_all(rays, &Facts { length: |_| length, light, path }, keys);
            }
            Lengths::Adaptive(table, cells) => {
                let means = mean_lengths(table, cells, rays);
                encoder.encode_all(rays, &Facts { length: |at| means[at], light, path }, keys);
            }
            Lengths::Real(real) => {
                encoder.encode_all(rays, &Facts { length: |at| real(first + at), light, path }, keys);
            }
        }
    });
}

/// What the table says of all rays of a chunk, whose cells lie far apart.
fn mean_lengths(table: &LengthTable, cells: &Encoder, rays: &[Ray]) -> [f32; CHUNK] {
    let (mut cell_of, mut means) = ([0; CHUNK], [0.0; CHUNK]);
    let cell_of = &mut cell_of[..rays.len()];
    cells.encode_all(rays, &NO_FACTS, cell_of);
    cell_of.iter().for_each(|&cell| prefetch_cell(table, cell));
    means.iter_mut().zip(cell_of).for_each(|(mean, cell)| *mean = table.mean(*cell));
    means
}
