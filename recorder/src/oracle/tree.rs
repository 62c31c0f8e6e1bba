//! A hierarchy of boxes for double precision: exact boxes, tested so that no crossing is lost.

use super::line::{Line, minus};

/// Triangles in a leaf.
const LEAF: usize = 4;
/// Intervals in which a split is looked for.
const BINS: usize = 16;
/// Levels that are split by cost; below them the halves have equal numbers, so that the stack suffices.
const LEVELS_BY_COST: usize = 64;
/// Entries of the stack: one per level, the numbers of triangles being below 2^32.
const STACK: usize = LEVELS_BY_COST + 32;
/// Distances to planes round twice; this is more.
const MARGIN: f64 = 8.0 * f64::EPSILON;

#[derive(Clone, Debug)]
pub(super) struct Tree {
    nodes: Vec<Node>,
    /// Triangle of each leaf slot.
    order: Vec<u32>,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    bounds: Box3,
    /// First leaf slot, or the first of two children.
    first: u32,
    /// Triangles of a leaf, 0 for an inner node.
    count: u32,
}

#[derive(Clone, Copy, Debug)]
struct Box3 {
    min: [f32; 3],
    max: [f32; 3],
}

impl Box3 {
    const EMPTY: Self = Self { min: [f32::INFINITY; 3], max: [f32::NEG_INFINITY; 3] };

    fn union(self, other: Self) -> Self {
        Self {
            min: [0, 1, 2].map(|axis| self.min[axis].min(other.min[axis])),
            max: [0, 1, 2].map(|axis| self.max[axis].max(other.max[axis])),
        }
    }

    fn area(&self) -> f64 {
        let [x, y, z] = [0, 1, 2].map(|axis| f64::from(self.max[axis]) - f64::from(self.min[axis]));
        x * y + y * z + z * x
    }

    /// Where a line enters it, if it does so before `limit`. The box is widened by `reach` of its largest
    /// coordinate as seen from the line's origin.
    fn entry(&self, line: &Line, limit: f64, reach: f64) -> Option<f64> {
        let (mut near, mut far) = (line.t_min, limit);
        let seen = [self.min, self.max].map(|corner| minus(corner.map(f64::from), line.origin));
        let margin = reach * seen.iter().flatten().fold(0.0f64, |most, x| most.max(x.abs()));
        for axis in 0..3 {
            let (origin, direction) = (line.origin[axis], line.direction[axis]);
            let (min, max) = (f64::from(self.min[axis]) - margin, f64::from(self.max[axis]) + margin);
            if direction == 0.0 {
                if origin < min || origin > max {
                    return None;
                }
                continue;
            }
            let (a, b) = ((min - origin) / direction, (max - origin) / direction);
            let (low, high) = (a.min(b), a.max(b));
            near = near.max(low - low.abs() * MARGIN);
            far = far.min(high + high.abs() * MARGIN);
        }
        (near <= far).then_some(near)
    }
}

impl Tree {
    pub(super) fn new(corners: &[[[f32; 3]; 3]]) -> Self {
        let boxes: Vec<Box3> = corners
            .iter()
            .map(|corners| {
                corners.iter().fold(Box3::EMPTY, |all, &corner| all.union(Box3 { min: corner, max: corner }))
            })
            .collect();
        let mut tree = Self { nodes: Vec::new(), order: (0..corners.len() as u32).collect() };
        if corners.is_empty() {
            return tree;
        }
        let node = Node { bounds: Box3::EMPTY, first: 0, count: 0 };
        tree.nodes.push(node);
        let mut pending = vec![(0, 0..corners.len(), 0)];
        while let Some((index, range, level)) = pending.pop() {
            let slots = &mut tree.order[range.clone()];
            let bounds = slots.iter().fold(Box3::EMPTY, |all, &slot| all.union(boxes[slot as usize]));
            if slots.len() <= LEAF {
                tree.nodes[index] = Node { bounds, first: range.start as u32, count: slots.len() as u32 };
                continue;
            }
            let middle = range.start + split(slots, &boxes, level);
            let first = tree.nodes.len();
            tree.nodes[index] = Node { bounds, first: first as u32, count: 0 };
            tree.nodes.extend([node; 2]);
            pending.push((first, range.start..middle, level + 1));
            pending.push((first + 1, middle..range.end, level + 1));
        }
        tree
    }

    /// Calls `visit` for every triangle whose box the line enters before a limit: at first the line's
    /// `t_max`, then what `visit` returned last. Nearer boxes come first.
    pub(super) fn walk(&self, line: &Line, visit: impl FnMut(u32) -> f64) {
        self.walk_near(line, 0.0, visit);
    }

    /// As [`Tree::walk`], with boxes widened by `reach` of their largest coordinate as seen from the origin.
    pub(super) fn walk_near(&self, line: &Line, reach: f64, mut visit: impl FnMut(u32) -> f64) {
        let mut limit = line.t_max;
        let mut stack = [(0, 0.0); STACK];
        let mut waiting = 0;
        if let Some(root) = self.nodes.first()
            && line.is_valid()
            && let Some(entry) = root.bounds.entry(line, limit, reach)
        {
            stack[0] = (0, entry);
            waiting = 1;
        }
        while waiting > 0 {
            waiting -= 1;
            let (index, entry) = stack[waiting];
            if entry > limit {
                continue;
            }
            let node = self.nodes[index as usize];
            if node.count > 0 {
                for slot in node.first..node.first + node.count {
                    limit = visit(self.order[slot as usize]);
                }
                continue;
            }
            let child = |index: u32| (index, self.nodes[index as usize].bounds.entry(line, limit, reach));
            let mut children = [child(node.first), child(node.first + 1)];
            children.sort_by(|a, b| b.1.unwrap_or(f64::INFINITY).total_cmp(&a.1.unwrap_or(f64::INFINITY)));
            for (index, entry) in children {
                if let Some(entry) = entry {
                    stack[waiting] = (index, entry);
                    waiting += 1;
                }
            }
        }
    }
}

/// Orders triangles so that those of the first child come first; returns how many, neither none nor all.
///
/// Splits the widest axis of the centres where the surface area heuristic says (Wald 2007, "On fast
/// Construction of SAH-based Bounding Volume Hierarchies"), or in halves where that does not divide.
fn split(slots: &mut [u32], boxes: &[Box3], level: usize) -> usize {
    let centre = |slot: u32, axis: usize| {
        let bounds = &boxes[slot as usize];
        f64::from(bounds.min[axis]) + f64::from(bounds.max[axis])
    };
    let [x, y, z] = [0, 1, 2].map(|axis| {
        let fold = |(low, high): (f64, f64), &slot: &u32| {
            (low.min(centre(slot, axis)), high.max(centre(slot, axis)))
        };
        slots.iter().fold((f64::INFINITY, f64::NEG_INFINITY), fold)
    });
    let width = |(low, high): (f64, f64)| high - low;
    let axis = if width(x) >= width(y).max(width(z)) { 0 } else { 1 + usize::from(width(z) > width(y)) };
    let (low, high) = [x, y, z][axis];
    if level < LEVELS_BY_COST && high > low {
        let bin =
            |slot: u32| ((((centre(slot, axis) - low) / (high - low)) * BINS as f64) as usize).min(BINS - 1);
        let last = cheapest(slots, boxes, &bin);
        let middle = partition(slots, |slot| bin(slot) <= last);
        if middle > 0 && middle < slots.len() {
            return middle;
        }
    }
    let middle = slots.len() / 2;
    slots
        .select_nth_unstable_by(middle, |&a, &b| centre(a, axis).total_cmp(&centre(b, axis)).then(a.cmp(&b)));
    middle
}

/// The last bin of the first child.
fn cheapest(slots: &[u32], boxes: &[Box3], bin: &impl Fn(u32) -> usize) -> usize {
    let mut bins = [(Box3::EMPTY, 0u32); BINS];
    for &slot in slots {
        let (bounds, count) = &mut bins[bin(slot)];
        *bounds = bounds.union(boxes[slot as usize]);
        *count += 1;
    }
    let side = |bins: &[(Box3, u32)]| {
        let (bounds, count) = bins
            .iter()
            .fold((Box3::EMPTY, 0), |(all, sum), (bounds, count)| (all.union(*bounds), sum + count));
        if count == 0 { f64::INFINITY } else { bounds.area() * f64::from(count) }
    };
    let cost = |last: usize| side(&bins[..=last]) + side(&bins[last + 1..]);
    (0..BINS - 1).min_by(|&a, &b| cost(a).total_cmp(&cost(b))).unwrap_or(0)
}

/// Moves what is `true` to the front; returns how many.
fn partition(slots: &mut [u32], is_first: impl Fn(u32) -> bool) -> usize {
    let mut count = 0;
    for index in 0..slots.len() {
        if is_first(slots[index]) {
            slots.swap(index, count);
            count += 1;
        }
    }
    count
}
