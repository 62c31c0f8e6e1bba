//! A hierarchy of boxes for double precision: exact boxes, tested so that no crossing is lost.

use super::line::{Line, minus};

/// Triangles in a leaf.
const LEAF: usize = 4;
/// Entries of the stack: one per level, the numbers of triangles being below 2^32.
const STACK: usize = 33;
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
        let mut pending = vec![(0, 0..corners.len())];
        while let Some((index, range)) = pending.pop() {
            let slots = &mut tree.order[range.clone()];
            let bounds = slots.iter().fold(Box3::EMPTY, |all, &slot| all.union(boxes[slot as usize]));
            if slots.len() <= LEAF {
                tree.nodes[index] = Node { bounds, first: range.start as u32, count: slots.len() as u32 };
                continue;
            }
            let middle = range.start + halve(slots, &boxes);
            let first = tree.nodes.len();
            tree.nodes[index] = Node { bounds, first: first as u32, count: 0 };
            tree.nodes.extend([node; 2]);
            pending.push((first, range.start..middle));
            pending.push((first + 1, middle..range.end));
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

/// Orders triangles so that those of the first child come first: half of them, by the widest axis of the
/// centres.
fn halve(slots: &mut [u32], boxes: &[Box3]) -> usize {
    let centre = |slot: u32| {
        let Box3 { min, max } = boxes[slot as usize];
        [0, 1, 2].map(|axis| f64::from(min[axis]) + f64::from(max[axis]))
    };
    let width = |axis: usize| {
        let along = || slots.iter().map(|&slot| centre(slot)[axis]);
        along().fold(f64::NEG_INFINITY, f64::max) - along().fold(f64::INFINITY, f64::min)
    };
    let widths = [0, 1, 2].map(width);
    let axis = (0..3).max_by(|&a, &b| widths[a].total_cmp(&widths[b])).unwrap_or(0);
    let middle = slots.len() / 2;
    slots
        .select_nth_unstable_by(middle, |&a, &b| centre(a)[axis].total_cmp(&centre(b)[axis]).then(a.cmp(&b)));
    middle
}
