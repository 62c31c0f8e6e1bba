//! Accumulate on threads, which part the table among themselves: two that add to one cell at a time would hand its cache
//! line back and forth, and each addition would keep what follows waiting.

use fearless_simd::{Level, dispatch};
use formats::key::{Encoder, NO_FACTS};
use formats::length_table::{LengthTable, TABLE_BITS_MIN, fixed_point};
use formats::pages::make_room;
use formats::ray::{Kind, Ray};
use formats::unit_space::UnitSpace;
use rayon::prelude::*;

use crate::stages::trace::hits::Hits;

/// Parts of the table, by the highest bits of a cell's address: all tables have so many, and what a part of the usual
/// ones takes stays in a core's cache.
const PARTS: usize = 1 << TABLE_BITS_MIN;

/// Rays that one task sorts by part, at most: their cells stay in a core's cache.
const CHUNK: usize = 1 << 14;
/// Fewest: of fewer, finding the 256 parts takes longer than adding their rays.
const FEWEST: usize = 1 << 10;
/// Rays whose lengths are found at once.
const BLOCK: usize = 64;
/// Tasks for each thread, so that none waits long for the others.
const TASKS_PER_THREAD: usize = 4;

/// Adds traced lengths to a table, in memory that it keeps for the next time.
#[derive(Debug, Default)]
pub struct Accumulator {
    /// Cell of each ray.
    cells: Vec<u32>,
    /// Traced length of each, unit lengths.
    lengths: Vec<f32>,
    /// Cell and fixed-point length of each ray, those of a chunk by part.
    sorted: Vec<[u32; 2]>,
    /// Where each part ends within a chunk, chunk by chunk.
    ends: Vec<u32>,
}

impl Accumulator {
    /// Makes and touches the memory that so many rays take.
    pub fn make_room(&mut self, rays: usize) {
        make_room(&mut self.sorted, rays);
        make_room(&mut self.ends, rays.div_ceil(chunk_of(rays)) * PARTS);
        make_room(&mut self.cells, rays);
        make_room(&mut self.lengths, rays);
    }

    /// Adds each ray's traced length to its cell.
    ///
    /// # Panics
    /// If [`Accumulator::make_room`] did not come before.
    pub fn accumulate(
        &mut self,
        table: &mut LengthTable,
        cells: &Encoder,
        unit: &UnitSpace,
        (rays, hits): (&[Ray], &Hits),
    ) {
        let level = Level::new();
        assert_eq!(rays.len(), self.sorted.len(), "room for as many rays");
        let shift = table.bits() - TABLE_BITS_MIN;
        let chunk = chunk_of(rays.len());
        let sorted = self.sorted.par_chunks_mut(chunk).zip(self.ends.par_chunks_mut(PARTS));
        let found = self.cells.par_chunks_mut(chunk).zip(self.lengths.par_chunks_mut(chunk));
        let tasks = rays.par_chunks(chunk).zip(sorted).zip(found).enumerate();
        tasks.for_each(|(number, ((rays, (sorted, ends)), (cell_of, length_of)))| {
            ends.fill(0);
            cells.encode_all(rays, &NO_FACTS, cell_of);
            cell_of.iter().for_each(|&cell| ends[cell as usize >> shift] += 1);
            let mut start = 0;
            for end in ends.iter_mut() {
                (*end, start) = (start, start + *end);
            }
            dispatch!(level, _ => lengths(unit, (rays, hits), number * chunk, length_of));
            for (&cell, &length) in cell_of.iter().zip(length_of.iter()) {
                let end = &mut ends[cell as usize >> shift];
                sorted[*end as usize] = [cell, fixed_point(length)];
                *end += 1;
            }
        });
        let parts = table.cells_mut().par_chunks_mut(1 << shift);
        parts.enumerate().for_each(|(part, cells)| {
            for (sorted, ends) in self.sorted.chunks(chunk).zip(self.ends.chunks(PARTS)) {
                let start = if part == 0 { 0 } else { ends[part - 1] };
                for &[cell, length] in &sorted[start as usize..ends[part] as usize] {
                    cells[cell as usize % (1 << shift)].add(length);
                }
            }
        });
    }
}

/// Finds [`UnitSpace::closest_length`] or [`UnitSpace::shadow_length`] of rays, whose results in their queue begin at
/// `first`, in loops without branches, which processors with vectors run several rays at a time.
#[inline(always)]
fn lengths(unit: &UnitSpace, (rays, hits): (&[Ray], &Hits), first: usize, lengths: &mut [f32]) {
    for (number, (rays, lengths)) in rays.chunks(BLOCK).zip(lengths.chunks_mut(BLOCK)).enumerate() {
        let (mut origin, mut direction) = ([[0.0; BLOCK]; 3], [[0.0; BLOCK]; 3]);
        let (mut t_max, mut distance) = ([0.0; BLOCK], [0.0; BLOCK]);
        for (at, ray) in rays.iter().enumerate() {
            let point = unit.point(ray.origin);
            for axis in 0..3 {
                (origin[axis][at], direction[axis][at]) = (point[axis], ray.direction[axis]);
            }
            (t_max[at], distance[at]) = (ray.t_max, hits.distance(first + number * BLOCK + at));
        }
        let mut found = [0.0; BLOCK];
        for at in 0..BLOCK {
            let of_lane = |axes: &[[f32; BLOCK]; 3]| [axes[0][at], axes[1][at], axes[2][at]];
            let exit = unit.exit(of_lane(&origin), of_lane(&direction));
            let length = distance[at] * unit.scale;
            found[at] = match hits.kind() {
                Kind::Closest if distance[at] < f32::INFINITY => length,
                Kind::Closest => exit,
                Kind::Shadow => length.min(t_max[at] * unit.scale).min(exit),
            };
        }
        lengths.copy_from_slice(&found[..rays.len()]);
    }
}

/// Rays of a task, of so many in all.
fn chunk_of(rays: usize) -> usize {
    (rays / (TASKS_PER_THREAD * rayon::current_num_threads())).clamp(FEWEST, CHUNK)
}

#[cfg(test)]
mod tests {
    use std::array::from_fn;

    use formats::ray::Hit;

    use super::*;

    #[test]
    fn lengths_are_those_of_their_rays() {
        let unit = UnitSpace::from_bounds([-2.0, 1.0, 10.0], [6.0, 5.0, 12.0]);
        let mut random = fastrand::Rng::with_seed(5);
        let (mut rays, mut nearest) = (Vec::new(), Vec::new());
        for _ in 0..4_003 {
            // Some outside, on the sides of the box, or along them.
            let origin = from_fn(|axis| {
                let at = random.f32() * 1.5 - 0.25;
                let at = if random.u8(0..4) == 0 { at.round() } else { at };
                unit.min[axis] + at * unit.sides[axis] / unit.scale
            });
            let direction = from_fn(|_| if random.u8(0..4) == 0 { 0.0 } else { random.f32() - 0.5 });
            let t_max = if random.bool() { f32::INFINITY } else { random.f32() * 20.0 };
            rays.push(Ray { origin, t_min: 0.0, direction, t_max });
            let hit = Hit { t: random.f32() * 10.0, triangle: 3, u: 0.0, v: 0.0 };
            nearest.push(if random.bool() { hit } else { Hit::MISS });
        }
        let distances: Vec<f32> = nearest.iter().map(|hit| hit.t).collect();
        for hits in [
            Hits::from_bytes(Kind::Closest, bytemuck::cast_slice(&nearest)),
            Hits::from_bytes(Kind::Shadow, bytemuck::cast_slice(&distances)),
        ] {
            let mut found = vec![0.0; rays.len()];
            dispatch!(Level::new(), _ => lengths(&unit, (&rays, &hits), 0, &mut found));
            for (index, length) in found.into_iter().enumerate() {
                let expected = hits.length(&unit, &rays[index], index);
                assert_eq!(length, expected, "{:?} {:?}", rays[index], nearest[index]);
            }
        }
    }
}
