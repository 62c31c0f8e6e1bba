//! A binary tree from the top down: boxes are parted where the surface area heuristic is least, evaluated between
//! bins of their centres (Wald 2007, "On fast Construction of SAH-based Bounding Volume Hierarchies").

use glam::Vec3A;
use obvhs::{
    aabb::Aabb,
    bvh2::{Bvh2, node::Bvh2Node},
};
use rayon::prelude::*;

/// Bins along each axis.
const BINS: usize = 32;

/// Boxes that a thread puts into bins at once.
const CHUNK: usize = 1 << 14;

/// The bounds of some boxes, and their indices.
type Part<'a> = (Aabb, &'a mut [u32]);

/// Builds a tree with a leaf for each box, of which there is one at least. Its nodes lie level by level.
pub(super) fn build(boxes: &[Aabb]) -> Bvh2 {
    let mut indices: Vec<u32> = (0..boxes.len() as u32).collect();
    let mut tree = Bvh2 {
        primitive_indices: indices.clone(),
        nodes: Vec::with_capacity(2 * boxes.len() - 1),
        children_are_ordered_after_parents: true,
        ..Bvh2::default()
    };
    // The nodes of a level that are no leaves, and what lies below each.
    let mut level = Vec::new();
    let all = (bounds_of(boxes, &indices), indices.as_mut_slice());
    add(&mut tree.nodes, &mut level, all);
    let mut levels = 1;
    while !level.is_empty() {
        levels += 1;
        let parted: Vec<_> =
            level.into_par_iter().map(|(node, part): (usize, _)| (node, part_in_two(boxes, part))).collect();
        level = Vec::with_capacity(2 * parted.len());
        for (node, halves) in parted {
            tree.nodes[node].first_index = tree.nodes.len() as u32;
            halves.into_iter().for_each(|half| add(&mut tree.nodes, &mut level, half));
        }
    }
    tree.max_depth = tree.max_depth.max(levels);
    tree
}

/// Adds a node; one of several boxes is to be parted with the next level.
fn add<'a>(nodes: &mut Vec<Bvh2Node>, level: &mut Vec<(usize, &'a mut [u32])>, (bounds, part): Part<'a>) {
    if let [index] = *part {
        nodes.push(Bvh2Node::new(bounds, 1, index));
    } else {
        level.push((nodes.len(), part));
        nodes.push(Bvh2Node::new(bounds, 0, 0));
    }
}

/// Parts two or more boxes where it costs least, or by halves where all centres lie in one bin.
fn part_in_two<'a>(boxes: &[Aabb], part: &'a mut [u32]) -> [Part<'a>; 2] {
    let grid = Grid::around(boxes, part);
    let bins =
        part.par_chunks(CHUNK).map(|part| Bins::of(&grid, boxes, part)).reduce(Bins::empty, Bins::merged);
    let Some(cut) = bins.cheapest_cut() else {
        let (low, high) = part.split_at_mut(part.len() / 2);
        return [low, high].map(|half| (bounds_of(boxes, half), half));
    };
    let mut middle = 0;
    for at in 0..part.len() {
        if grid.bins(&boxes[part[at] as usize])[cut.axis] < cut.bin {
            part.swap(at, middle);
            middle += 1;
        }
    }
    let (low, high) = part.split_at_mut(middle);
    let [low_bounds, high_bounds] = cut.bounds;
    [(low_bounds, low), (high_bounds, high)]
}

fn bounds_of(boxes: &[Aabb], part: &[u32]) -> Aabb {
    part.iter().fold(Aabb::empty(), |all, &index| all.union(&boxes[index as usize]))
}

/// Where each bin is.
struct Grid {
    low: Vec3A,
    bins_per_unit: Vec3A,
}

impl Grid {
    /// From the lowest to the highest centre along each axis.
    fn around(boxes: &[Aabb], part: &[u32]) -> Self {
        let of_chunk = |part: &[u32]| {
            let centres = part.iter().map(|&index| Aabb::from_point(boxes[index as usize].center()));
            centres.fold(Aabb::empty(), |all, centre| all.union(&centre))
        };
        let all = part.par_chunks(CHUNK).map(of_chunk).reduce(Aabb::empty, |a, b| a.union(&b));
        Self { low: all.min, bins_per_unit: BINS as f32 / all.diagonal() }
    }

    /// The bin of a box along each axis; the first one along an axis without extent.
    fn bins(&self, bounds: &Aabb) -> [usize; 3] {
        let place = (bounds.center() - self.low) * self.bins_per_unit;
        // NaN, where all centres are the same, becomes 0.
        place.to_array().map(|place| (place as usize).min(BINS - 1))
    }
}

/// Per axis and bin the bounds of its boxes and how many they are.
struct Bins([[(Aabb, u32); BINS]; 3]);

/// Boxes in lower bins along an axis, and the others.
struct Cut {
    axis: usize,
    /// The first bin of the others.
    bin: usize,
    bounds: [Aabb; 2],
    cost: f32,
}

impl Bins {
    fn empty() -> Self {
        Self([[(Aabb::empty(), 0); BINS]; 3])
    }

    fn of(grid: &Grid, boxes: &[Aabb], part: &[u32]) -> Self {
        let mut bins = Self::empty();
        for &index in part {
            let bounds = &boxes[index as usize];
            for (bins, at) in bins.0.iter_mut().zip(grid.bins(bounds)) {
                bins[at] = (bins[at].0.union(bounds), bins[at].1 + 1);
            }
        }
        bins
    }

    fn merged(mut self, other: Self) -> Self {
        for (bin, other) in self.0.as_flattened_mut().iter_mut().zip(other.0.as_flattened()) {
            *bin = (bin.0.union(&other.0), bin.1 + other.1);
        }
        self
    }

    /// The first of those for which the areas of both sides, each times its boxes, sum to the least.
    fn cheapest_cut(&self) -> Option<Cut> {
        let mut best: Option<Cut> = None;
        for (axis, bins) in self.0.iter().enumerate() {
            let add = |(bounds, count): (Aabb, u32), bin: &(Aabb, u32)| (bounds.union(&bin.0), count + bin.1);
            let cost = |(bounds, count): &(Aabb, u32)| bounds.half_area() * *count as f32;
            let mut above = [(Aabb::empty(), 0); BINS + 1];
            for bin in (0..BINS).rev() {
                above[bin] = add(above[bin + 1], &bins[bin]);
            }
            let mut below = (Aabb::empty(), 0);
            for bin in 1..BINS {
                below = add(below, &bins[bin - 1]);
                if below.1 == 0 || above[bin].1 == 0 {
                    continue;
                }
                let cost = cost(&below) + cost(&above[bin]);
                if best.as_ref().is_none_or(|best| cost < best.cost) {
                    best = Some(Cut { axis, bin, bounds: [below.0, above[bin].0], cost });
                }
            }
        }
        best
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube(low: Vec3A, size: f32) -> Aabb {
        Aabb::new(low, low + size)
    }

    /// Many boxes in one corner and a few anywhere else: the first cut is where the area heuristic has it, not where
    /// it halves their number or their extent.
    #[test]
    fn boxes_are_parted_where_it_costs_least() {
        let mut random = fastrand::Rng::with_seed(1);
        let mut within =
            |low: f32, high: f32| low + (high - low) * Vec3A::from([(); 3].map(|()| random.f32()));
        let mut boxes: Vec<Aabb> = (0..40_000).map(|_| cube(within(0.0, 0.1), 0.01)).collect();
        boxes.extend((0..100).map(|_| cube(within(0.2, 0.9), 0.01)));
        let tree = build(&boxes);
        assert_eq!(tree.nodes.len(), 2 * boxes.len() - 1);
        let cost = |below: &dyn Fn(&Aabb) -> bool| {
            let side = |is_below: bool| {
                let side: Vec<&Aabb> = boxes.iter().filter(|bounds| below(bounds) == is_below).collect();
                side.iter().fold(Aabb::empty(), |all, bounds| all.union(bounds)).half_area()
                    * side.len() as f32
            };
            side(true) + side(false)
        };
        let first = &tree.nodes[tree.nodes[0].first_index as usize];
        let found = cost(&|bounds| first.aabb().union(bounds).half_area() <= first.aabb().half_area());
        // Planes a little way apart, along an axis.
        for step in 10..270 {
            let other = cost(&|bounds| bounds.center().x < step as f32 / 300.0);
            assert!(found <= 1.1 * other, "the first cut costs {found}, one at {step} of 300 costs {other}");
        }
    }
}
