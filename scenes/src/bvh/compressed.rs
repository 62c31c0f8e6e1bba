//! From topology to [`CwbvhNode`]s: obvhs groups the children and gives them their slots, the
//! quantised planes are ours.
//!
//! Why obvhs' own planes are not used: it divides `child − p` in f32 and rounds the quotient
//! outward, but the difference has been rounded before, so a plane may end up inside its child's
//! box by up to half an ulp of the node's size; its traversal adds errors of the same size
//! (`q·(2^e/d) + (p − o)/d`) without any padding, ignores hits nearer than a fixed 1e-4 and
//! clamps reciprocals of directions at 2^23. Rays through the edge of a box are lost that way:
//! one in half a million in a kitchen full of axis-aligned cupboards.

use obvhs::{bvh2::Bvh2, cwbvh::bvh2_to_cwbvh::bvh2_to_cwbvh};

use super::{
    Bvh, CwbvhNode,
    boxes::{Boxes, f32_below},
    node::Child,
};
use crate::bounds::Bounds;

/// Most triangles in a leaf; the unary count has three bits.
const LEAF_TRIANGLES: u32 = 3;

/// Distance in steps of the grid that a plane keeps from what it bounds: the kernels compute
/// `(q − (o − p)/step)·(step/d)`, where rounding `o − p` costs up to 2^-16 steps that scaling the
/// far planes does not cover.
const MARGIN: f64 = 1.0 / (1 << 15) as f64;

/// The smallest step as a part of the scene's magnitude: small enough for the padding of flat
/// boxes, large enough for `(o − p)/step` never to overflow.
const STEP_OF_MAGNITUDE: f64 = 1.0 / (1u64 << 63) as f64 / 32.0;

/// Groups the binary tree's nodes and quantises their boxes.
pub(super) fn flatten(tree: Bvh2, boxes: &Boxes) -> Bvh {
    let wide = bvh2_to_cwbvh(&tree, LEAF_TRIANGLES, true, false);
    drop(tree);
    let order = wide.primitive_indices;
    let mut nodes: Vec<CwbvhNode> = bytemuck::cast_vec(wide.nodes);
    let smallest_exponent = exponent_at_least(boxes.magnitude * STEP_OF_MAGNITUDE);
    // Children come after their parents: one pass from the back.
    let mut bounds = vec![Bounds::EMPTY; nodes.len()];
    for index in (0..nodes.len()).rev() {
        let children: [Bounds; 8] = std::array::from_fn(|slot| match nodes[index].child(slot) {
            Child::Inner(child) => bounds[child as usize],
            Child::Leaf { first, count } => boxes.around(&order[first as usize..(first + count) as usize]),
            Child::Empty | Child::Broken => Bounds::EMPTY,
        });
        bounds[index] = children.iter().fold(Bounds::EMPTY, |all, child| all.union(child));
        quantise(&mut nodes[index], &children, &bounds[index], smallest_exponent);
    }
    Bvh::Cwbvh { nodes, order }
}

/// Biased exponent of the smallest power of two that is at least `value`, kept where both it and
/// its reciprocal are normal numbers.
fn exponent_at_least(value: f64) -> u8 {
    (value.log2().ceil() as i32 + 127).clamp(1, 253) as u8
}

/// Gives a node the finest grid on which 255 steps reach across it, and its children planes on
/// that grid which hold their boxes with [`MARGIN`] to spare.
fn quantise(node: &mut CwbvhNode, children: &[Bounds; 8], all: &Bounds, smallest_exponent: u8) {
    for axis in 0..3 {
        let (low, high) = (f64::from(all.min[axis]), f64::from(all.max[axis]));
        let mut exponent = exponent_at_least((high - low) / 255.0).max(smallest_exponent);
        let (start, step) = loop {
            let step = f64::from(f32::from_bits(u32::from(exponent) << 23));
            let start = f32_below(low - MARGIN * step);
            if (high - f64::from(start)) / step + MARGIN <= 255.0 {
                break (start, step);
            }
            exponent += 1;
        };
        node.p[axis] = start;
        node.e[axis] = exponent;
        let (lows, highs) = planes_mut(node, axis);
        for (slot, child) in children.iter().enumerate() {
            // An empty slot gets planes in the wrong order, which hardly any ray is between.
            let is_empty = child.min[axis] > child.max[axis];
            let steps = |value: f32| (f64::from(value) - f64::from(start)) / step;
            lows[slot] = if is_empty { 255 } else { (steps(child.min[axis]) - MARGIN).floor() as u8 };
            highs[slot] = if is_empty { 0 } else { (steps(child.max[axis]) + MARGIN).ceil() as u8 };
        }
    }
}

/// The quantised planes of one axis: low ones, high ones.
fn planes_mut(node: &mut CwbvhNode, axis: usize) -> (&mut [u8; 8], &mut [u8; 8]) {
    match axis {
        0 => (&mut node.child_min_x, &mut node.child_max_x),
        1 => (&mut node.child_min_y, &mut node.child_max_y),
        _ => (&mut node.child_min_z, &mut node.child_max_z),
    }
}
