//! Scatter on threads.

use std::sync::atomic::{AtomicU32, AtomicU64, Ordering::Relaxed};

use formats::prefetch::{AHEAD, prefetch_to_write};
use rayon::prelude::*;

use crate::stages::trace::hits::Hits;

/// Results that one task moves.
const CHUNK: usize = 1 << 12;

/// `home[permutation[i]] = hits[i]`.
///
/// # Panics
/// If there are not as many places as results, or results of two kinds.
pub fn scatter(hits: &Hits, permutation: &[AtomicU32], home: &Hits) {
    match (hits, home) {
        (Hits::Closest(hits), Hits::Closest(home)) => {
            let copy = |from: &AtomicU64, to: &AtomicU64| to.store(from.load(Relaxed), Relaxed);
            scattered(hits, permutation, home, |from, to| {
                copy(&from[0], &to[0]);
                copy(&from[1], &to[1]);
            });
        }
        (Hits::Shadow(hits), Hits::Shadow(home)) => {
            scattered(hits, permutation, home, |from, to| to.store(from.load(Relaxed), Relaxed));
        }
        _ => panic!("hits of closest rays and distances of shadow rays"),
    }
}

fn scattered<T: Sync>(hits: &[T], permutation: &[AtomicU32], home: &[T], copy: impl Fn(&T, &T) + Sync) {
    assert!(hits.len() == permutation.len() && hits.len() == home.len(), "a place for each result");
    permutation.par_chunks(CHUNK).zip(hits.par_chunks(CHUNK)).for_each(|(places, hits)| {
        let place = |at: usize| places[at].load(Relaxed) as usize;
        for (at, hit) in hits.iter().enumerate() {
            if at + AHEAD < places.len() {
                prefetch_to_write(home, place(at + AHEAD));
            }
            copy(hit, &home[place(at)]);
        }
    });
}
