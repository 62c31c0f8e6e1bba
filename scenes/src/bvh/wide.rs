//! From topology to [`WideNode`]s: which nodes of the binary tree become children of which wide node, and which
//! subtrees become leaves, by the least expected cost (dynamic programming over the tree, as Ylitie et al. 2017,
//! §3.2, with the surface area heuristic).

use obvhs::bvh2::Bvh2;

use super::{Bvh, WIDE_LEAF, WideNode, boxes::Boxes, node::Child, topology::preorder};
use crate::bounds::Bounds;

/// Triangles that a kernel tests at once.
const BLOCK: u32 = 4;

/// What testing a block of triangles costs, as a multiple of what testing the boxes of a node does: found by
/// measuring. Fewer nodes for more triangles also mean less memory to read.
const BLOCK_COST: f32 = 0.3;

/// Children of a node.
const SLOTS: usize = 8;

/// Groups the binary tree's nodes.
pub(super) fn flatten(tree: &Bvh2, boxes: &Boxes) -> Bvh {
    let plan = Plan::new(tree);
    let mut nodes = Vec::new();
    let mut order = Vec::with_capacity(tree.primitive_indices.len());
    // What becomes a node, and the child that it is of its parent.
    let mut pending = vec![(0, None)];
    while let Some((root, parent)) = pending.pop() {
        let index = nodes.len();
        let mut node = WideNode::EMPTY;
        if let Some((parent, slot)) = parent {
            let parent: &mut WideNode = &mut nodes[parent];
            parent.children[slot] = index as u32;
        }
        for (slot, &child) in plan.children(root).iter().enumerate() {
            if plan.is_leaf(child) {
                let first = order.len();
                let below = preorder(tree, child).into_iter().map(|node| &tree.nodes[node as usize]);
                let leaves = below.filter(|node| node.is_leaf()).map(|leaf| leaf.first_index as usize);
                order.extend(leaves.map(|first| tree.primitive_indices[first]));
                node.children[slot] = ((order.len() - first) as u32) << WideNode::FIRST_BITS | first as u32;
                set_box(&mut node, slot, &boxes.around(&order[first..]));
            } else {
                // Its box comes later; until then it only counts as there.
                set_box(&mut node, slot, &Bounds { min: [0.0; 3], max: [0.0; 3] });
                pending.push((child, Some((index, slot))));
            }
        }
        nodes.push(node);
    }
    fit_boxes(&mut nodes);
    Bvh::Wide { nodes, order }
}

fn set_box(node: &mut WideNode, slot: usize, bounds: &Bounds) {
    for axis in 0..3 {
        node.planes[axis][0][slot] = bounds.min[axis];
        node.planes[axis][1][slot] = bounds.max[axis];
    }
}

/// Children come after their parents, so one pass from the back fits every box.
fn fit_boxes(nodes: &mut [WideNode]) {
    let mut bounds = vec![Bounds::EMPTY; nodes.len()];
    for index in (0..nodes.len()).rev() {
        for slot in 0..SLOTS {
            if let Child::Inner(child) = nodes[index].child(slot) {
                set_box(&mut nodes[index], slot, &bounds[child as usize]);
            }
            if !nodes[index].is_empty(slot) {
                bounds[index] = bounds[index].union(&nodes[index].bounds(slot));
            }
        }
    }
}

/// What is cheapest for each node of the binary tree.
struct Plan<'a> {
    tree: &'a Bvh2,
    /// Per node the least expected cost of what is below it as at most 1, 2, … 7 children.
    costs: Vec<[f32; SLOTS - 1]>,
    /// Per node whether it is a leaf where it is one child.
    is_leaf: Vec<bool>,
}

impl<'a> Plan<'a> {
    fn new(tree: &'a Bvh2) -> Self {
        let count = tree.nodes.len();
        let (mut triangles, costs, is_leaf) =
            (vec![1; count], vec![[0.0; SLOTS - 1]; count], vec![true; count]);
        let mut plan = Self { tree, costs, is_leaf };
        for &index in preorder(tree, 0).iter().rev() {
            let index = index as usize;
            let node = &tree.nodes[index];
            let area = node.aabb().half_area();
            if node.is_leaf() {
                plan.costs[index] = [BLOCK_COST * area; SLOTS - 1];
                continue;
            }
            let first = node.first_index as usize;
            let below: u32 = triangles[first] + triangles[first + 1];
            triangles[index] = below;
            let as_node = area + plan.split(index, SLOTS).1;
            let as_leaf = BLOCK_COST * area * below.div_ceil(BLOCK) as f32;
            plan.is_leaf[index] = below <= WIDE_LEAF && as_leaf <= as_node;
            let mut least = if plan.is_leaf[index] { as_leaf } else { as_node };
            plan.costs[index][0] = least;
            for slots in 2..SLOTS {
                least = least.min(plan.split(index, slots).1);
                plan.costs[index][slots - 1] = least;
            }
        }
        plan
    }

    /// How many of so many slots the first child of an inner node takes at best, and what both then cost.
    fn split(&self, index: usize, slots: usize) -> (usize, f32) {
        let first = self.tree.nodes[index].first_index as usize;
        let cost = |taken: usize| self.costs[first][taken - 1] + self.costs[first + 1][slots - taken - 1];
        let choices = (1..slots).map(|taken| (taken, cost(taken)));
        choices
            .reduce(|best, other| if other.1 < best.1 { other } else { best })
            .unwrap_or((1, f32::INFINITY))
    }

    fn is_leaf(&self, node: u32) -> bool {
        self.is_leaf[node as usize]
    }

    /// The children of a wide node that begins at a node of the binary tree, the costliest first: rays that look for
    /// any hit take them from the last one on, so that a hit that is cheap to find spares the rest.
    fn children(&self, root: u32) -> Vec<u32> {
        let mut found = Vec::with_capacity(SLOTS);
        let mut pending = vec![(root, SLOTS)];
        while let Some((node, slots)) = pending.pop() {
            let index = node as usize;
            // As many slots as it takes to be that cheap, but for the root, which is a node.
            let slots = match self.costs[index].get(slots - 1) {
                Some(least) => 1 + self.costs[index].iter().take_while(|&cost| cost > least).count(),
                None => slots,
            };
            if slots == 1 || self.tree.nodes[index].is_leaf() {
                found.push(node);
            } else {
                let first = self.tree.nodes[index].first_index;
                let (taken, _) = self.split(index, slots);
                pending.extend([(first, taken), (first + 1, slots - taken)]);
            }
        }
        // What a ray that enters a child is expected to cost.
        let cost =
            |&node: &u32| self.costs[node as usize][0] / self.tree.nodes[node as usize].aabb().half_area();
        found.sort_by(|a, b| cost(b).total_cmp(&cost(a)));
        found
    }
}
