//! Compare on threads.

use formats::ray::Hit;
use rayon::prelude::*;

use crate::stages::trace::hits::Hits;

/// Fewest results that are worth a thread of their own.
const CHUNK: usize = 1 << 14;

/// How many results of the same queue differ: hits in any bit, shadow rays in whether they are blocked.
pub fn differences(hits: &Hits, others: &Hits) -> u64 {
    let differs = |&index: &usize| match hits {
        Hits::Closest(_) => {
            let bits = |hits: &Hits| bytemuck::cast::<Hit, [u64; 2]>(hits.hit(index));
            bits(hits) != bits(others)
        }
        Hits::Shadow(_) => hits.distance(index).is_infinite() != others.distance(index).is_infinite(),
    };
    (0..hits.len()).into_par_iter().with_min_len(CHUNK).filter(differs).count() as u64
}
