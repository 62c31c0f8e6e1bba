//! The node formats, byte for byte as they lie in memory, in the cache and in GPU buffers.

use bytemuck::{Pod, Zeroable};

use super::WIDE_LEAF;
use crate::bounds::Bounds;

/// A node with two children, or a leaf; 32 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Bvh2Node {
    /// Lowest corner of the box, world units, strictly below everything in it.
    pub min: [f32; 3],
    /// 0: an inner node. Otherwise a leaf with that many triangles.
    pub count: u32,
    /// Highest corner of the box, world units, strictly above everything in it.
    pub max: [f32; 3],
    /// Inner node: its children are nodes `first` and `first + 1`, `first` is even.
    /// Leaf: its triangles are in the leaf slots `first..first + count`.
    pub first: u32,
}

/// A node with up to eight children, 80 bytes: the compressed wide node of Ylitie, Karras and Laine
/// 2017, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", §3, with the
/// field order of obvhs (planes of one axis together, low before high).
///
/// A child sits in one of eight slots; a ray visits the slots in descending order of
/// `slot ^ octant`, where the octant has bit 2, 1, 0 set for a direction that is not negative in
/// x, y, z. Child `slot` covers, along axis x, the *real* numbers from
/// `p[0] + child_min_x[slot]·2^(e[0] − 127)` to `p[0] + child_max_x[slot]·2^(e[0] − 127)`: nothing
/// in that sum is rounded by the kernels, which scale the ray instead (see the trace stage).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct CwbvhNode {
    /// Where the grid of the quantised planes starts, world units.
    pub p: [f32; 3],
    /// Biased exponent of the grid's step per axis: the step is the f32 with the bits `e << 23`.
    pub e: [u8; 3],
    /// Bit `slot` is set where the child is an inner node.
    pub imask: u8,
    /// Node index of the first inner child; the others follow in ascending order of their slots.
    pub child_base: u32,
    /// Leaf slot of the first triangle that belongs to this node.
    pub triangle_base: u32,
    /// What each slot holds. Empty: 0. Inner node: `0b001_11000 | slot`. Leaf: the top three bits
    /// count its triangles in unary (`001`, `011`, `111`), the low five are the offset of its
    /// first triangle from `triangle_base` (0 to 23): `0b011_00010` holds the triangles 2 and 3.
    pub child_meta: [u8; 8],
    /// Low x planes.
    pub child_min_x: [u8; 8],
    /// High x planes.
    pub child_max_x: [u8; 8],
    /// Low y planes.
    pub child_min_y: [u8; 8],
    /// High y planes.
    pub child_max_y: [u8; 8],
    /// Low z planes.
    pub child_min_z: [u8; 8],
    /// High z planes.
    pub child_max_z: [u8; 8],
}

/// A node with up to eight children and their boxes in f32, 224 bytes.
///
/// Children come first to last without a gap, the one first that costs shadow rays most for what it is likely to
/// block, since they take the last one that they hit (`Plan::children` of the builder); an empty slot's box is
/// inside out, so that no ray enters it.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct WideNode {
    /// Per axis the low and then the high planes of the eight boxes, world units, strictly outside of what is
    /// in them.
    pub planes: [[[f32; 8]; 2]; 3],
    /// The children: see [`WideNode::leaf`].
    pub children: [u32; 8],
}

impl WideNode {
    /// Bits of a child that hold an inner node's index or a leaf's first slot; those above hold the number
    /// of a leaf's triangles, 0 for an inner node.
    pub const FIRST_BITS: u32 = 28;

    /// No children.
    pub(super) const EMPTY: Self =
        Self { planes: [[[f32::INFINITY; 8], [f32::NEG_INFINITY; 8]]; 3], children: [0; 8] };

    /// Number of triangles of a child, 0 for an inner node, and its first leaf slot or its index.
    #[inline(always)]
    pub fn leaf(child: u32) -> (u32, u32) {
        (child >> Self::FIRST_BITS, child & ((1 << Self::FIRST_BITS) - 1))
    }

    /// Whether there is a child in a slot, 0 to 7.
    pub fn is_empty(&self, slot: usize) -> bool {
        self.planes[0][0][slot] == f32::INFINITY
    }

    /// The box of the child in a slot, 0 to 7.
    pub(super) fn bounds(&self, slot: usize) -> Bounds {
        let side = |side: usize| [0, 1, 2].map(|axis| self.planes[axis][side][slot]);
        Bounds { min: side(0), max: side(1) }
    }

    /// Decodes a slot, 0 to 7.
    pub(super) fn child(&self, slot: usize) -> Child {
        if self.is_empty(slot) {
            return Child::Empty;
        }
        match Self::leaf(self.children[slot]) {
            (0, index) => Child::Inner(index),
            (count, first) if count <= WIDE_LEAF => Child::Leaf { first, count },
            _ => Child::Broken,
        }
    }
}

/// What a slot of a [`CwbvhNode`] or a [`WideNode`] holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Child {
    /// Nothing.
    Empty,
    /// The node with this index.
    Inner(u32),
    /// The triangles in these leaf slots.
    Leaf {
        /// First leaf slot.
        first: u32,
        /// 1 to 3, of a [`WideNode`] to [`WIDE_LEAF`].
        count: u32,
    },
    /// Bytes that mean nothing.
    Broken,
}

impl CwbvhNode {
    /// Decodes a slot, 0 to 7.
    pub(super) fn child(&self, slot: usize) -> Child {
        let meta = self.child_meta[slot];
        let is_inner = self.imask >> slot & 1 == 1;
        match (meta, is_inner) {
            (0, false) => Child::Empty,
            (_, true) if meta == 0b001_11000 | slot as u8 => {
                let below = self.imask & !(0xff << slot);
                Child::Inner(self.child_base.saturating_add(below.count_ones()))
            }
            (_, false) if matches!(meta >> 5, 0b001 | 0b011 | 0b111) => {
                let offset = u32::from(meta & 0b11111);
                let count = (meta >> 5).count_ones();
                if offset + count > 24 {
                    return Child::Broken;
                }
                Child::Leaf { first: self.triangle_base.saturating_add(offset), count }
            }
            _ => Child::Broken,
        }
    }

    /// The quantised planes per axis: low ones, high ones.
    pub(super) fn planes(&self) -> [[&[u8; 8]; 2]; 3] {
        [
            [&self.child_min_x, &self.child_max_x],
            [&self.child_min_y, &self.child_max_y],
            [&self.child_min_z, &self.child_max_z],
        ]
    }
}
