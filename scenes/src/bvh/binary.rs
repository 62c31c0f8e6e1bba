//! From topology to [`Bvh2Node`]s: laid out depth first, with our own boxes.

use obvhs::bvh2::Bvh2;

use super::{Bvh, Bvh2Node, boxes::Boxes};
use crate::bounds::Bounds;

/// Lays the tree out so that a node's first child and what is below it follow the pair that it is
/// in: what a ray visits next is often in the cache already.
pub(super) fn flatten(tree: &Bvh2, boxes: &Boxes) -> Bvh {
    let mut nodes = Vec::with_capacity(tree.nodes.len() + 1);
    let mut order = Vec::with_capacity(tree.primitive_indices.len());
    nodes.push(Bvh2Node::default());
    if !tree.nodes[0].is_leaf() {
        nodes.push(Bvh2Node::default());
    }
    let mut pending = vec![(0usize, 0usize)];
    while let Some((from, to)) = pending.pop() {
        let source = &tree.nodes[from];
        let first = source.first_index as usize;
        if source.is_leaf() {
            let triangles = &tree.primitive_indices[first..first + source.prim_count as usize];
            nodes[to] =
                Bvh2Node { count: source.prim_count, first: order.len() as u32, ..Default::default() };
            order.extend_from_slice(triangles);
        } else {
            let pair = nodes.len();
            nodes[to] = Bvh2Node { count: 0, first: pair as u32, ..Default::default() };
            nodes.extend([Bvh2Node::default(); 2]);
            pending.extend([(first + 1, pair + 1), (first, pair)]);
        }
    }
    fit_boxes(&mut nodes, &order, boxes);
    Bvh::Bvh2 { nodes, order }
}

/// Children come after their parents, so one pass from the back fits every box.
fn fit_boxes(nodes: &mut [Bvh2Node], order: &[u32], boxes: &Boxes) {
    for index in (0..nodes.len()).rev() {
        let node = nodes[index];
        let first = node.first as usize;
        let bounds = if node.count > 0 {
            boxes.around(&order[first..first + node.count as usize])
        } else if index == 1 {
            continue; // The unused node.
        } else {
            let [a, b] =
                [first, first + 1].map(|child| Bounds { min: nodes[child].min, max: nodes[child].max });
            a.union(&b)
        };
        nodes[index].min = bounds.min;
        nodes[index].max = bounds.max;
    }
}
