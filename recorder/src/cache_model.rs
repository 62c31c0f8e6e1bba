//! Which part of what an order reads is still in the caches: a model, not a measurement (docs/keys.md).
//!
//! Sampled whole groups of 64 rays walk the hierarchy of the cpu backend in lockstep: first every ray's
//! first read, then every ray's second, and so on. Their addresses go through two set-associative caches
//! with least-recently-used replacement.

use std::sync::Arc;

use formats::manifest::{CacheRecord, QueueId};
use formats::metrics::GROUP_RAYS;
use formats::ray::Ray;
use rayon::prelude::*;

use crate::stages::trace::cpu::CpuTracer;

/// Bytes of a line.
pub const LINE_BYTES: u32 = 128;
/// Bytes of the first level.
pub const L1_BYTES: u64 = 128 << 10;
/// Bytes of the second level unless told otherwise.
pub const L2_BYTES: u64 = 4 << 20;
/// Lines of a set, in both levels.
const WAYS: usize = 16;

/// Stretches of an order that are sampled, evenly apart.
const STRETCHES: usize = 8;
/// Groups of a stretch, one after the other.
const STRETCH_GROUPS: usize = 16;

/// The model of a run: a hierarchy and two caches.
#[derive(Clone, Debug)]
pub struct CacheModel {
    /// Walks the hierarchy.
    pub tracer: Arc<CpuTracer>,
    /// Bytes of the second level.
    pub l2_bytes: u64,
}

impl CacheModel {
    /// What the model says of a queue traced in an order: `place(i)` is the canonical index of the ray at
    /// place i of `count`.
    pub fn record(
        &self,
        id: QueueId,
        method: &str,
        rays: &[Ray],
        place: impl Fn(usize) -> usize,
    ) -> CacheRecord {
        let places = sampled_places(rays.len()).into_iter().flatten();
        let sampled: Vec<Ray> = places.map(|at| rays[place(at)]).collect();
        let mut record = CacheRecord {
            queue: id,
            method: method.to_owned(),
            groups: sampled.len().div_ceil(GROUP_RAYS) as u64,
            rays: sampled.len() as u64,
            line_bytes: LINE_BYTES,
            l1_bytes: L1_BYTES,
            l2_bytes: self.l2_bytes,
            accesses: 0,
            l1_hits: 0,
            l2_hits: 0,
        };
        let mut levels = [Cache::new(L1_BYTES), Cache::new(self.l2_bytes)];
        for group in sampled.chunks(GROUP_RAYS) {
            let trails: Vec<_> = group.par_iter().map(|ray| self.tracer.trail(ray, id.kind).reads).collect();
            let steps = trails.iter().map(Vec::len).max().unwrap_or(0);
            for step in 0..steps {
                for &(address, bytes) in trails.iter().filter_map(|trail| trail.get(step)) {
                    let lines = address / u64::from(LINE_BYTES)
                        ..=(address + u64::from(bytes) - 1) / u64::from(LINE_BYTES);
                    lines.for_each(|line| count_read(&mut record, &mut levels, line));
                }
            }
        }
        record
    }
}

fn count_read(record: &mut CacheRecord, [first, second]: &mut [Cache; 2], line: u64) {
    record.accesses += 1;
    if first.read(line) {
        record.l1_hits += 1;
    } else if second.read(line) {
        record.l2_hits += 1;
    }
}

/// The places of an order that are sampled: ranges of whole groups, ascending and apart.
fn sampled_places(count: usize) -> Vec<std::ops::Range<usize>> {
    let groups = count.div_ceil(GROUP_RAYS);
    let is_small = groups <= STRETCHES * STRETCH_GROUPS;
    let (stretches, length) = if is_small { (1, groups) } else { (STRETCHES, STRETCH_GROUPS) };
    let stretch = |number: usize| {
        let first = (groups - length) * number / (STRETCHES - 1);
        first * GROUP_RAYS..((first + length) * GROUP_RAYS).min(count)
    };
    (0..stretches).map(stretch).collect()
}

/// A set-associative cache; each set holds its lines from the most to the least recently used.
struct Cache {
    sets: Vec<[u64; WAYS]>,
}

/// No line has this number.
const EMPTY: u64 = u64::MAX;

impl Cache {
    fn new(bytes: u64) -> Self {
        let sets = bytes / u64::from(LINE_BYTES) / WAYS as u64;
        Self { sets: vec![[EMPTY; WAYS]; sets.max(1) as usize] }
    }

    /// Whether the line was there; it is afterwards.
    fn read(&mut self, line: u64) -> bool {
        let sets = self.sets.len() as u64;
        // Triangles start at a multiple of every number of sets: fold the high bits in.
        let set = &mut self.sets[((line ^ line >> 33) % sets) as usize];
        let found = set.iter().position(|&known| known == line);
        set[..=found.unwrap_or(WAYS - 1)].rotate_right(1);
        set[0] = line;
        found.is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_recently_used_line_goes_first() {
        let mut cache = Cache::new(u64::from(LINE_BYTES) * WAYS as u64);
        let lines: Vec<u64> = (0..WAYS as u64).collect();
        assert!(lines.iter().all(|&line| !cache.read(line)));
        assert!(lines.iter().all(|&line| cache.read(line)));
        cache.read(0);
        assert!(!cache.read(99));
        assert!(cache.read(0) && !cache.read(1));
    }

    #[test]
    fn a_cache_holds_as_many_lines_as_it_has_bytes_for() {
        let mut cache = Cache::new(L1_BYTES);
        let lines = L1_BYTES / u64::from(LINE_BYTES);
        assert_eq!((0..lines).filter(|&line| cache.read(line)).count(), 0);
        assert_eq!((0..lines).filter(|&line| cache.read(line)).count() as u64, lines);
        // One round robin through more lines than fit defeats it altogether.
        let more = lines + lines / 2;
        let mut cache = Cache::new(L1_BYTES);
        assert_eq!((0..3 * more).filter(|&at| cache.read(at % more)).count() as u64, 0);
    }

    #[test]
    fn samples_are_whole_groups_apart_from_each_other() {
        for count in [0, 1, 64, 8192, 8193, 100_000, 2_073_600] {
            let places = sampled_places(count);
            assert!(places.windows(2).all(|pair| pair[0].end <= pair[1].start), "{count}");
            assert!(places.iter().all(|range| range.start % GROUP_RAYS == 0 && range.end <= count));
            let sampled: usize = places.iter().map(ExactSizeIterator::len).sum();
            assert!(sampled <= count && sampled + GROUP_RAYS > count.min(8192), "{count}: {sampled}");
        }
    }
}
