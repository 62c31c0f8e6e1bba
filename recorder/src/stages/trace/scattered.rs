//! Results that many threads write in any order, each to its own place.

use std::sync::atomic::{AtomicU32, AtomicU64, Ordering::Relaxed};

use formats::ray::Hit;
use rayon::prelude::*;

/// Fewest results that are worth a thread of their own when counting differences.
const CHUNK: usize = 1 << 14;

/// Hits in canonical order, written in another.
#[derive(Debug)]
pub struct ScatteredHits(Vec<[AtomicU64; 2]>);

impl ScatteredHits {
    /// `count` hits of unknown value.
    pub fn new(count: usize) -> Self {
        Self((0..count).map(|_| [const { AtomicU64::new(0) }; 2]).collect())
    }

    /// Stores a hit; every place is written by one thread alone.
    #[inline]
    pub fn store(&self, index: u32, hit: Hit) {
        let halves: [u64; 2] = bytemuck::cast(hit);
        let place = &self.0[index as usize];
        place[0].store(halves[0], Relaxed);
        place[1].store(halves[1], Relaxed);
    }

    /// How many hits differ in any bit from the canonical ones.
    pub fn differences(&self, canonical: &[Hit]) -> u64 {
        let differs = |(place, hit): (&[AtomicU64; 2], &Hit)| {
            bytemuck::cast::<_, [u64; 2]>(*hit) != [place[0].load(Relaxed), place[1].load(Relaxed)]
        };
        self.0.par_iter().zip(canonical).with_min_len(CHUNK).filter(|&pair| differs(pair)).count() as u64
    }
}

/// Distances of shadow rays in canonical order, written in another.
#[derive(Debug)]
pub struct ScatteredDistances(Vec<AtomicU32>);

impl ScatteredDistances {
    /// `count` distances of unknown value.
    pub fn new(count: usize) -> Self {
        Self((0..count).map(|_| AtomicU32::new(0)).collect())
    }

    /// Stores a distance; every place is written by one thread alone.
    #[inline]
    pub fn store(&self, index: u32, distance: f32) {
        self.0[index as usize].store(distance.to_bits(), Relaxed);
    }

    /// How many rays are blocked here and not there, or the other way round.
    pub fn differences(&self, canonical: &[f32]) -> u64 {
        let is_free = |place: &AtomicU32| f32::from_bits(place.load(Relaxed)).is_infinite();
        let differs = |(place, distance): (&AtomicU32, &f32)| is_free(place) != distance.is_infinite();
        self.0.par_iter().zip(canonical).with_min_len(CHUNK).filter(|&pair| differs(pair)).count() as u64
    }
}
