//! An order of a queue's rays: which ray is at each place, and by which key.

use rayon::prelude::*;

use crate::key::method::UNSORTED;
use crate::manifest::{MethodArray, Place, QueueId};
use crate::permutation::check_bijection;
use crate::reader::{Dump, Loaded};

/// Places that a thread takes at a time: a multiple of every group width and of every lane width.
const CHUNK: usize = 8192;

/// The places of an order, whose indices are all in range.
#[derive(Debug)]
pub enum Places {
    /// Canonical order of this many rays.
    Canonical(usize),
    /// A method's order.
    Sorted(Loaded<u32>),
    /// An order that was not recorded.
    Made(Vec<u32>),
}

impl Places {
    /// Of the order by a method, or canonical order, of a queue of `rays` rays.
    ///
    /// # Errors
    /// If its permutation was not kept, is damaged, or does not hold each ray once.
    pub fn open(dump: &Dump, queue: QueueId, method: &str, rays: usize) -> Result<Self, String> {
        if method == UNSORTED {
            return Ok(Self::Canonical(rays));
        }
        let place = Place::Method(queue, method.to_owned(), MethodArray::Permutation);
        let permutation = dump.array(&place).map_err(|error| error.to_string())?;
        Self::sorted(permutation, rays)
            .map_err(|problem| format!("{}/{place}: {problem}", dump.root().display()))
    }

    /// Of a permutation of `rays` rays.
    ///
    /// # Errors
    /// If it does not hold each ray once.
    pub fn sorted(permutation: Loaded<u32>, rays: usize) -> Result<Self, String> {
        check_bijection(&permutation, rays)
            .map_err(|error| format!("{error}; `inspector verify` says what is wrong"))?;
        Ok(Self::Sorted(permutation))
    }

    /// Rays of the order.
    pub fn len(&self) -> usize {
        match self {
            Self::Canonical(rays) => *rays,
            Self::Sorted(permutation) => permutation.len(),
            Self::Made(permutation) => permutation.len(),
        }
    }

    /// Whether it has no rays.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Canonical index of the ray at a place.
    ///
    /// # Panics
    /// If there is no such place.
    #[inline]
    pub fn ray(&self, place: usize) -> usize {
        match self {
            Self::Canonical(rays) => {
                assert!(place < *rays, "place {place} of {rays}");
                place
            }
            Self::Sorted(permutation) => permutation[place] as usize,
            Self::Made(permutation) => permutation[place] as usize,
        }
    }

    /// What `of` makes of each chunk of places, given the canonical indices there, in order. Chunks are whole
    /// groups, and the same ones for any number of threads.
    pub fn chunks<T: Send>(&self, of: impl Fn(&[u32]) -> T + Sync) -> Vec<T> {
        let chunk = |at: usize| {
            let (first, end) = (at * CHUNK, self.len().min((at + 1) * CHUNK));
            match self {
                Self::Canonical(_) => of(&(first as u32..end as u32).collect::<Vec<_>>()),
                Self::Sorted(permutation) => of(&permutation[first..end]),
                Self::Made(permutation) => of(&permutation[first..end]),
            }
        };
        (0..self.len().div_ceil(CHUNK)).into_par_iter().map(chunk).collect()
    }
}

/// Keys of a queue's rays in canonical order.
#[derive(Debug)]
pub enum Keys {
    /// Not recorded, of any number of bits.
    Made(Vec<u64>),
    /// Of up to 32 bits.
    Narrow(Loaded<u32>),
    /// Of more.
    Wide(Loaded<u64>),
}

impl Keys {
    /// The key of a ray.
    ///
    /// # Panics
    /// If there is no such ray.
    pub fn at(&self, ray: usize) -> u64 {
        match self {
            Self::Made(keys) => keys[ray],
            Self::Narrow(keys) => u64::from(keys[ray]),
            Self::Wide(keys) => keys[ray],
        }
    }

    /// How many keys.
    pub fn len(&self) -> usize {
        match self {
            Self::Made(keys) => keys.len(),
            Self::Narrow(keys) => keys.len(),
            Self::Wide(keys) => keys.len(),
        }
    }

    /// Whether there is no key.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::lanes::WIDTHS;

    #[test]
    fn chunks_are_whole_groups() {
        for width in WIDTHS.into_iter().chain([32, 64, 128]) {
            assert_eq!(CHUNK % width, 0);
        }
        let places = Places::Canonical(2 * CHUNK + 5);
        let lengths = places.chunks(<[u32]>::len);
        assert_eq!(lengths, [CHUNK, CHUNK, 5]);
        assert_eq!(places.chunks(|indices| indices[0]), [0, CHUNK as u32, 2 * CHUNK as u32]);
    }
}
