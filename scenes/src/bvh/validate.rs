//! What traversal relies on, checked after building and after loading: kernels then need no
//! bounds checks of their own.

use std::ops::Range;

use super::{BVH2_STACK, Bvh, Bvh2Node, CWBVH_STACK, CwbvhNode, WIDE_LEVELS, WideNode, node::Child};
use crate::{Scene, bounds::Bounds};

/// Most triangles in a leaf of a [`Bvh2Node`]; a stack entry keeps the count in four bits.
const LEAF_LIMIT: u32 = 15;

/// What is wrong with a hierarchy.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[expect(missing_docs, reason = "each message says what it and its fields mean")]
pub enum Defect {
    /// The leaf slots do not number the scene's triangles; `slot` is their number if that is wrong.
    #[error(
        "leaf slot {slot} holds triangle {triangle}, which is out of range or in another slot as well ({slots} slots for {triangles} triangles)"
    )]
    Order { slot: usize, triangle: u32, slots: usize, triangles: usize },
    #[error("node {node} refers to something that does not exist or cannot be there")]
    Reference { node: usize },
    /// A node or leaf slot is reached by two ways, or by none; then `node` is the number of nodes.
    #[error("node {node} or what is in it is reached more than once, or not at all")]
    Shared { node: usize },
    #[error("node {node} is more than {limit} levels below the root")]
    Depth { node: usize, limit: usize },
    #[error("the box of node {node} does not hold everything below it")]
    Box { node: usize },
}

/// Checks that every triangle of the scene is in exactly one leaf, every node but the unused one
/// is reached exactly once, children come after their parents, no node is deeper than the
/// traversal stack, and every box strictly holds its triangles.
///
/// # Errors
/// The first [`Defect`] found.
pub fn validate(bvh: &Bvh, scene: &Scene) -> Result<(), Defect> {
    check_order(bvh.order(), scene.triangles.len())?;
    let around = |slots: Range<u32>| {
        let corners = slots.map(|slot| scene.corners(bvh.order()[slot as usize] as usize));
        corners.fold(Bounds::EMPTY, |all, corners| all.union(&Bounds::of(&corners)))
    };
    let (nodes, limit, unused) = match bvh {
        Bvh::Bvh2 { nodes, .. } => (nodes.len(), BVH2_STACK, Some(1)),
        Bvh::Cwbvh { nodes, .. } => (nodes.len(), CWBVH_STACK, None),
        Bvh::Wide { nodes, .. } => (nodes.len(), WIDE_LEVELS, None),
    };
    check_tree(nodes, bvh.order().len(), limit, unused, |index| match bvh {
        Bvh::Bvh2 { nodes, .. } => bvh2_children(&nodes[index]),
        Bvh::Cwbvh { nodes, .. } => std::array::from_fn(|slot| nodes[index].child(slot)),
        Bvh::Wide { nodes, .. } => std::array::from_fn(|slot| nodes[index].child(slot)),
    })?;
    // From the back, so that what is below a node has been seen before the node.
    let mut exact = vec![Bounds::EMPTY; nodes];
    for index in (0..nodes).rev() {
        let holds_all = match bvh {
            Bvh::Bvh2 { nodes, .. } => check_bvh2_box(index, nodes, &mut exact, around),
            Bvh::Cwbvh { nodes, .. } => {
                let node = &nodes[index];
                check_boxes(index, |slot| node.child(slot), |slot| cwbvh_box(node, slot), &mut exact, around)
            }
            Bvh::Wide { nodes, .. } => {
                let node = &nodes[index];
                check_boxes(index, |slot| node.child(slot), |slot| wide_box(node, slot), &mut exact, around)
            }
        };
        if !holds_all {
            return Err(Defect::Box { node: index });
        }
    }
    Ok(())
}

/// Whether the leaf slots are a permutation of the triangles.
fn check_order(order: &[u32], triangles: usize) -> Result<(), Defect> {
    let defect = |slot, triangle| Defect::Order { slot, triangle, slots: order.len(), triangles };
    let mut is_seen = vec![false; triangles];
    for (slot, &triangle) in order.iter().enumerate() {
        match is_seen.get_mut(triangle as usize) {
            Some(seen) if !*seen => *seen = true,
            _ => return Err(defect(slot, triangle)),
        }
    }
    if order.len() == triangles { Ok(()) } else { Err(defect(order.len(), u32::MAX)) }
}

/// Everything that a node refers to; at most eight of each.
type Children = [Child; 8];

fn bvh2_children(node: &Bvh2Node) -> Children {
    let mut children = [Child::Empty; 8];
    if node.count > LEAF_LIMIT || (node.count == 0 && node.first % 2 == 1) {
        children[0] = Child::Broken;
    } else if node.count > 0 {
        children[0] = Child::Leaf { first: node.first, count: node.count };
    } else {
        children[0] = Child::Inner(node.first);
        children[1] = Child::Inner(node.first.saturating_add(1));
    }
    children
}

/// Walks the tree from its root: every reference in range, everything reached once, children after their
/// parents.
fn check_tree(
    nodes: usize,
    slots: usize,
    limit: usize,
    unused: Option<usize>,
    children: impl Fn(usize) -> Children,
) -> Result<(), Defect> {
    if nodes == 0 {
        return Err(Defect::Reference { node: 0 });
    }
    let mut is_node_seen = vec![false; nodes];
    let mut is_slot_seen = vec![false; slots];
    let mut seen_slots = 0;
    let mut pending = vec![(0usize, 0usize)];
    is_node_seen[0] = true;
    if let Some(seen) = unused.and_then(|unused| is_node_seen.get_mut(unused)) {
        *seen = true;
    }
    while let Some((node, depth)) = pending.pop() {
        if depth > limit {
            return Err(Defect::Depth { node, limit });
        }
        for child in children(node) {
            match child {
                Child::Empty => {}
                Child::Broken => return Err(Defect::Reference { node }),
                Child::Inner(child) => {
                    let child = child as usize;
                    if child <= node || child >= nodes {
                        return Err(Defect::Reference { node });
                    }
                    if std::mem::replace(&mut is_node_seen[child], true) {
                        return Err(Defect::Shared { node: child });
                    }
                    pending.push((child, depth + 1));
                }
                Child::Leaf { first, count } => {
                    let range = first as usize..first as usize + count as usize;
                    let Some(seen) = is_slot_seen.get_mut(range) else {
                        return Err(Defect::Reference { node });
                    };
                    if seen.iter().any(|&seen| seen) {
                        return Err(Defect::Shared { node });
                    }
                    seen.fill(true);
                    seen_slots += seen.len();
                }
            }
        }
    }
    if seen_slots < slots || is_node_seen.contains(&false) {
        return Err(Defect::Shared { node: nodes });
    }
    Ok(())
}

/// Whether `outer` holds `inner` with room to spare on every side.
fn holds(outer: Corners, inner: &Bounds) -> bool {
    (0..3).all(|axis| {
        outer[0][axis] < f64::from(inner.min[axis]) && f64::from(inner.max[axis]) < outer[1][axis]
    })
}

fn check_bvh2_box(
    index: usize,
    nodes: &[Bvh2Node],
    exact: &mut [Bounds],
    around: impl Fn(Range<u32>) -> Bounds,
) -> bool {
    let node = &nodes[index];
    if index == 1 {
        return true; // The unused node.
    }
    exact[index] = if node.count > 0 {
        around(node.first..node.first + node.count)
    } else {
        exact[node.first as usize].union(&exact[node.first as usize + 1])
    };
    holds([node.min.map(f64::from), node.max.map(f64::from)], &exact[index])
}

/// The corners of a child's box.
type Corners = [[f64; 3]; 2];

fn cwbvh_box(node: &CwbvhNode, slot: usize) -> Corners {
    let plane = |axis: usize, side: usize| {
        let step = f64::from(f32::from_bits(u32::from(node.e[axis]) << 23));
        f64::from(node.p[axis]) + f64::from(node.planes()[axis][side][slot]) * step
    };
    [0, 1].map(|side| [0, 1, 2].map(|axis| plane(axis, side)))
}

fn wide_box(node: &WideNode, slot: usize) -> Corners {
    let bounds = node.bounds(slot);
    [bounds.min.map(f64::from), bounds.max.map(f64::from)]
}

/// Checks the boxes of a node's children.
fn check_boxes(
    index: usize,
    child: impl Fn(usize) -> Child,
    corners: impl Fn(usize) -> Corners,
    exact: &mut [Bounds],
    around: impl Fn(Range<u32>) -> Bounds,
) -> bool {
    let mut all = Bounds::EMPTY;
    for slot in 0..8 {
        let below = match child(slot) {
            Child::Inner(child) => exact[child as usize],
            Child::Leaf { first, count } => around(first..first + count),
            Child::Empty | Child::Broken => continue,
        };
        if !holds(corners(slot), &below) {
            return false;
        }
        all = all.union(&below);
    }
    exact[index] = all;
    true
}
