//! Columns whose cells are the same for many rows on end: a dictionary, and for how many rows each entry goes.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use parquet::basic::{Encoding, Repetition};

use super::cell::Cell;
use super::encode::{Word, run};
use super::file::Chunk;

/// The cells of a column, run by run.
pub(super) struct Runs<T: Cell>(Vec<(Option<T::Stored>, usize)>);

impl<T: Cell> Runs<T> {
    /// None yet.
    pub(super) fn new() -> Self {
        Self(Vec::new())
    }

    /// Adds the cell of so many rows.
    pub(super) fn add(&mut self, cell: Option<T::Stored>, rows: usize) {
        match self.0.last_mut() {
            Some((last, before)) if *last == cell => *before += rows,
            _ => self.0.push((cell, rows)),
        }
    }

    /// Gives what was added.
    pub(super) fn give(&mut self, repetition: Repetition, chunk: &mut Chunk) {
        let rows = |runs: &[(_, usize)]| runs.iter().map(|run| run.1).sum::<usize>();
        let mut nulls = 0;
        if repetition == Repetition::OPTIONAL {
            chunk.levels(|levels| {
                for runs in self.0.chunk_by(|a, b| a.0.is_some() == b.0.is_some()) {
                    let is_present = runs[0].0.is_some();
                    nulls += if is_present { 0 } else { rows(runs) };
                    run(rows(runs), u32::from(is_present), 1, levels);
                }
            });
        }
        let (mut cells, mut places, mut runs) = (Vec::new(), HashMap::new(), Vec::new());
        for (cell, rows) in self.0.drain(..) {
            let Some(cell) = cell else { continue };
            let place = match places.entry(cell) {
                Entry::Occupied(known) => *known.get(),
                Entry::Vacant(new) => {
                    cells.push(new.key().clone());
                    *new.insert(cells.len() as u32 - 1)
                }
            };
            runs.push((place, rows));
        }
        chunk.statistics = Some(T::statistics(&cells, nulls));
        // An empty dictionary would be none.
        let Some(last) = cells.len().checked_sub(1) else { return chunk.encoding = Encoding::PLAIN };
        let width = (last as u32).width();
        chunk.page.push(width as u8);
        runs.into_iter().for_each(|(place, rows)| run(rows, place, width.div_ceil(8), &mut chunk.page));
        cells.iter().for_each(|cell| T::plain(cell, &mut chunk.dictionary));
        chunk.entries = cells.len();
        chunk.encoding = Encoding::RLE_DICTIONARY;
    }
}
