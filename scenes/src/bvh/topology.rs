//! Which triangles lie below which node: a tree from the top down over boxes that are scaled to the unit cube, obvhs'
//! reinsertion and collapsing, and a limit on the depth.
//!
//! They decide on the tree alone; the boxes are thrown away.

use glam::Vec3A;
use obvhs::{
    aabb::Aabb,
    bvh2::{Bvh2, leaf_collapser::collapse, node::Bvh2Node, reinsertion::ReinsertionOptimizer},
};
use rayon::prelude::*;

use super::{BVH2_STACK, CWBVH_STACK, WIDE_LEVELS, boxes::Boxes, top_down};
use crate::bounds::Bounds;

/// The format of a hierarchy.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum BvhKind {
    /// Two children per node, boxes in f32.
    Bvh2,
    /// Up to eight children per node, boxes quantised to 8 bits.
    Cwbvh,
    /// Up to eight children per node, boxes in f32.
    Wide,
}

impl BvhKind {
    /// All formats.
    pub const ALL: [Self; 3] = [Self::Bvh2, Self::Cwbvh, Self::Wide];

    /// Name on the command line and in file names.
    pub fn name(self) -> &'static str {
        match self {
            Self::Bvh2 => "bvh2",
            Self::Cwbvh => "cwbvh",
            Self::Wide => "wide",
        }
    }
}

impl std::fmt::Display for BvhKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(self.name())
    }
}

/// Most triangles in a leaf below a [`Bvh2Node`], and what visiting a node costs as a multiple of a triangle's test:
/// those of obvhs' builds.
const BVH2_LEAF: (u32, f32) = (8, 3.0);

/// How many nodes the first batch of reinsertions takes, within so much of all: a better tree is worth some build time
/// where that is short.
const BATCH: f32 = 200_000.0;
const PART_IN_BATCH: (f32, f32) = (0.05, 0.5);

/// The part of all nodes that the first batch takes once leaves have been collapsed.
const PART_IN_BATCH_OF_COLLAPSED: f32 = 0.1;

/// How many nodes a batch of reinsertions may look at, as a multiple of all nodes.
const SEARCH_BUDGET: f32 = 64.0;

/// Builds the tree. For wide nodes every leaf has one triangle (what groups them merges them, too); no leaf is deeper
/// below the root than the kind's traversal stack has entries.
pub(super) fn find(boxes: &Boxes, kind: BvhKind) -> Bvh2 {
    let mut tree = top_down::build(&in_unit_cube(&boxes.padded));
    let (least, most) = PART_IN_BATCH;
    let part = (BATCH / tree.nodes.len() as f32).clamp(least, most);
    reinsert(&mut tree, part);
    match kind {
        BvhKind::Bvh2 => {
            let (leaf, node_cost) = BVH2_LEAF;
            collapse(&mut tree, leaf, node_cost);
            reinsert(&mut tree, PART_IN_BATCH_OF_COLLAPSED);
            limit_depth(&mut tree, BVH2_STACK);
        }
        // A wide node is never deeper than the binary node that it was made from.
        BvhKind::Cwbvh => limit_depth(&mut tree, CWBVH_STACK),
        BvhKind::Wide => limit_depth(&mut tree, WIDE_LEVELS),
    }
    tree
}

/// The boxes moved and scaled so that the scene fills the unit cube along its largest extent,
/// which keeps areas from overflowing, vanishing or cancelling wherever the scene is and however
/// large it is.
fn in_unit_cube(boxes: &[Bounds]) -> Vec<Aabb> {
    let scene = boxes.par_iter().copied().reduce(|| Bounds::EMPTY, |a, b| a.union(&b));
    let min = scene.min.map(f64::from);
    let extent = [0, 1, 2].map(|axis| f64::from(scene.max[axis]) - min[axis]);
    // Padded boxes are never empty, so neither is the scene's.
    let scale = 1.0 / extent.into_iter().fold(0.0, f64::max);
    let place = |corner: &[f32; 3]| {
        Vec3A::from([0, 1, 2].map(|axis| ((f64::from(corner[axis]) - min[axis]) * scale) as f32))
    };
    boxes.par_iter().map(|bounds| Aabb::new(place(&bounds.min), place(&bounds.max))).collect()
}

/// Moves subtrees to where they cost less (Meister and Bittner 2018, "Parallel Reinsertion for
/// Bounding Volume Hierarchy Optimization"), in obvhs' sequence of ever smaller batches.
///
/// The candidates are chosen here: obvhs sorts them with a parallel unstable radix sort, which
/// may leave nodes of equal area in an order that depends on the number of threads. Where boxes lie on top
/// of each other a search rules out next to nothing: then there are fewer of them.
fn reinsert(tree: &mut Bvh2, batch_ratio: f32) {
    if tree.nodes[0].is_leaf() {
        return;
    }
    let nodes = tree.nodes.len() as f32;
    let wanted_at_first = (nodes * batch_ratio).min(nodes * SEARCH_BUDGET / nodes_per_search(tree));
    let mut optimizer = ReinsertionOptimizer::default();
    for divisor in (1..32).step_by(2) {
        let wanted = wanted_at_first / divisor as f32;
        let wanted = (wanted as usize).clamp(1, tree.nodes.len() - 1);
        // Nodes near the root come first in memory; obvhs takes its candidates from twice as many
        // nodes as it wants, too.
        let considered = (2 * (wanted + 1)).min(tree.nodes.len());
        let area = |node: &u32| tree.nodes[*node as usize].aabb().half_area();
        let mut candidates: Vec<u32> = (1..considered as u32).collect();
        candidates.par_sort_unstable_by(|a, b| area(b).total_cmp(&area(a)).then(a.cmp(b)));
        candidates.truncate(wanted);
        optimizer.run_with_candidates(tree, &candidates, 1);
    }
}

/// About how many nodes a box shares with what lies around it: the areas of all nodes, as a multiple of the
/// root's.
fn nodes_per_search(tree: &Bvh2) -> f32 {
    let area = |node: &Bvh2Node| f64::from(node.aabb().half_area());
    let all: f64 = tree.nodes.iter().map(area).sum();
    (all / area(&tree.nodes[0])).max(1.0) as f32
}

/// Rebuilds subtrees that are too deep as balanced ones, so that no node is more than `limit`
/// levels below the root.
fn limit_depth(tree: &mut Bvh2, limit: usize) {
    let (height, leaves) = measure(tree);
    let mut pending = vec![(0u32, limit as u32)];
    while let Some((node, budget)) = pending.pop() {
        if height[node as usize] <= budget {
            continue;
        }
        let first = tree.nodes[node as usize].first_index;
        let fits = |child: u32| balanced_height(leaves[child as usize]) < budget;
        if fits(first) && fits(first + 1) {
            pending.extend([(first, budget - 1), (first + 1, budget - 1)]);
        } else {
            balance(tree, node);
        }
    }
}

/// Levels below the root of a balanced tree with this many leaves.
fn balanced_height(leaves: u32) -> u32 {
    leaves.next_power_of_two().ilog2()
}

/// Levels below each node, and leaves below each node (1 for a leaf).
fn measure(tree: &Bvh2) -> (Vec<u32>, Vec<u32>) {
    let mut height = vec![0; tree.nodes.len()];
    let mut leaves = vec![1; tree.nodes.len()];
    for &node in preorder(tree, 0).iter().rev() {
        let entry = &tree.nodes[node as usize];
        if !entry.is_leaf() {
            let (a, b) = (entry.first_index as usize, entry.first_index as usize + 1);
            height[node as usize] = 1 + height[a].max(height[b]);
            leaves[node as usize] = leaves[a] + leaves[b];
        }
    }
    (height, leaves)
}

/// All nodes from `root` down, parents before children.
pub(super) fn preorder(tree: &Bvh2, root: u32) -> Vec<u32> {
    let mut found = Vec::new();
    let mut pending = vec![root];
    while let Some(node) = pending.pop() {
        found.push(node);
        let entry = &tree.nodes[node as usize];
        if !entry.is_leaf() {
            pending.extend([entry.first_index + 1, entry.first_index]);
        }
    }
    found
}

/// Rebuilds the subtree below `root` from its leaves in their order, halving them at each level.
/// A binary tree with the same number of leaves has the same number of pairs, so the nodes are
/// used again.
fn balance(tree: &mut Bvh2, root: u32) {
    let below = preorder(tree, root);
    let is_leaf = |node: &u32| tree.nodes[*node as usize].is_leaf();
    let leaves: Vec<Bvh2Node> =
        below.iter().filter(|&node| is_leaf(node)).map(|&node| tree.nodes[node as usize]).collect();
    let mut pairs = below
        .iter()
        .filter(|&node| !is_leaf(node))
        .map(|&node| tree.nodes[node as usize].first_index)
        .collect::<Vec<u32>>();
    let mut pending = vec![(root, 0..leaves.len())];
    while let Some((node, range)) = pending.pop() {
        let bounds = leaves[range.clone()].iter().fold(Aabb::empty(), |all, leaf| all.union(leaf.aabb()));
        if range.len() == 1 {
            tree.nodes[node as usize] = leaves[range.start];
        } else if let Some(first) = pairs.pop() {
            tree.nodes[node as usize] = Bvh2Node::new(bounds, 0, first);
            let middle = range.start + range.len().div_ceil(2);
            pending.extend([(first, range.start..middle), (first + 1, middle..range.end)]);
        }
    }
}
