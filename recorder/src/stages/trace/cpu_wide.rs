//! Traversal of the wide hierarchy on a thread: eight boxes in f32 and four triangles at a time, the children by
//! distance.

use std::ops::Range;

use bytemuck::{Pod, Zeroable};
use formats::pages::room_on_huge_pages;
use formats::prefetch::{prefetch_at, prefetch_whole_at};
use rayon::prelude::*;
use scenes::bvh::{WIDE_LEVELS, WideNode};

use super::cpu_query::{Query, Tree, Variant};
use super::triangle::{LeafTriangle, TriangleBlock};

/// The nodes, with blocks of triangles in place of leaf slots.
#[derive(Clone, Debug)]
pub(super) struct WideTree {
    /// Of a node [`LINES`] after each other.
    lines: Vec<Line>,
    blocks: Vec<TriangleBlock>,
}

/// A part of a node. Where a node begins is a shift away from its number, where a multiplication would keep all
/// that follows waiting.
#[repr(C, align(32))]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Line([u32; 8]);

/// How many make a node.
const LINES: usize = size_of::<Node>() / size_of::<Line>();

/// [`WideNode`]; an inner node is named by its first line, a leaf's children count blocks and name the first one.
#[repr(C, align(32))]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(super) struct Node {
    pub(super) planes: [[[f32; 8]; 2]; 3],
    pub(super) children: [u32; 8],
}

/// Each level leaves at most seven children that wait; the last one pushes up to eight.
const STACK: usize = (7 * (WIDE_LEVELS + 1) + 8).next_power_of_two();

/// Children that wait. As aligned as a cache line: else the compiler aligns what a thread keeps beside it, vectors
/// that it has no registers for, to 16 bytes, and every other one of 32 lies in two lines.
#[repr(C, align(64))]
pub(super) struct Stack([u64; STACK]);

/// Blocks of a leaf; none of an inner node.
fn blocks_in(child: u32) -> u32 {
    WideNode::leaf(child).0.div_ceil(TriangleBlock::TRIANGLES)
}

/// The leaf slots of each of them.
fn blocks_of(child: u32) -> impl Iterator<Item = Range<u32>> {
    let (count, first) = WideNode::leaf(child);
    let starts = (first..first + count).step_by(TriangleBlock::TRIANGLES as usize);
    starts.map(move |start| start..(start + TriangleBlock::TRIANGLES).min(first + count))
}

impl WideTree {
    /// From nodes as they come from the builder; `triangle` gives that of a leaf slot.
    pub(super) fn new(nodes: &[WideNode], triangle: impl Fn(u32) -> LeafTriangle + Sync) -> Self {
        assert!(nodes.len() * LINES <= 1 << WideNode::FIRST_BITS, "lines of nodes that 28 bits can name");
        // The slots of each block, in the order in which nodes name them.
        let leaves: Vec<Range<u32>> =
            nodes.par_iter().flat_map_iter(|node| node.children.into_iter().flat_map(blocks_of)).collect();
        let mut blocks = room_on_huge_pages(leaves.len());
        let block = |slots: &Range<u32>| TriangleBlock::new(slots.clone().map(&triangle));
        leaves.par_iter().map(block).collect_into_vec(&mut blocks);
        // The first block of each node.
        let mut firsts: Vec<u32> =
            nodes.par_iter().map(|node| node.children.map(blocks_in).iter().sum()).collect();
        let mut first_block = 0;
        for first in &mut firsts {
            first_block += std::mem::replace(first, first_block);
        }
        let pack = |(node, &first): (&WideNode, &u32)| {
            let mut first_block = first;
            let children = node.children.map(|child| {
                let (count, first) = WideNode::leaf(child);
                if count == 0 {
                    return first * LINES as u32;
                }
                let blocks = blocks_in(child);
                first_block += blocks;
                blocks << WideNode::FIRST_BITS | (first_block - blocks)
            });
            Node { planes: node.planes, children }
        };
        let mut packed = room_on_huge_pages(nodes.len());
        nodes.par_iter().zip(&firsts).map(pack).collect_into_vec(&mut packed);
        Self { lines: bytemuck::cast_vec(packed), blocks }
    }

    /// The node that begins with a line.
    #[inline(always)]
    pub(super) fn node(&self, line: u32) -> &Node {
        let first = line as usize;
        let Some(lines) = self.lines[first..first + LINES].first_chunk::<LINES>() else {
            unreachable!("as many as a node has")
        };
        bytemuck::cast_ref(lines)
    }

    /// Asks for a child ahead of its visit.
    #[inline(always)]
    pub(super) fn ask(&self, child: u32) {
        match WideNode::leaf(child) {
            (0, line) => {
                (0..LINES).step_by(2).for_each(|part| prefetch_at(&self.lines, line as usize + part))
            }
            (_, first) => prefetch_whole_at(&self.blocks, first as usize),
        }
    }

    /// Tests the triangles of a leaf; true if the search is over.
    #[inline(always)]
    pub(super) fn test_leaf<S: Variant>(&self, query: &mut Query<'_, S>, leaf: u32) -> bool {
        let (count, first) = WideNode::leaf(leaf);
        for place in first as usize..(first + count) as usize {
            let block = &self.blocks[place];
            query.visit_leaf(place, || block.count());
            let mut lanes = query.candidates(block);
            while lanes != 0 {
                let lane = (lanes.trailing_zeros() % TriangleBlock::TRIANGLES) as usize;
                lanes &= lanes - 1;
                if query.test_candidate(&block.triangle(lane, |triangle| query.mask(triangle))) {
                    return true;
                }
            }
        }
        false
    }

    #[inline(always)]
    fn walk<T: WideTest, S: Variant>(&self, query: &mut Query<'_, S>, stack: &mut <Self as Tree>::Stack) {
        let test = T::new(query.origin, query.inverse, query.t_min, query.padding());
        let mut waiting = Waiting::new(stack);
        let mut current = 0;
        loop {
            while current >> WideNode::FIRST_BITS == 0 {
                query.visit(current as usize / LINES);
                let node = self.node(current);
                let (near, hits) = test.test(node, query.limit());
                let child = |slot: usize| node.children[slot];
                let ask = |_: usize, child: u32| self.ask(child);
                current = match hits {
                    0 => match waiting.pop::<S>(query.limit()) {
                        Some(child) => child,
                        None => return,
                    },
                    _ if S::ANY => waiting.cheapest_of(child, hits, ask),
                    _ => waiting.nearest_of(child, &near, hits, ask),
                };
            }
            if self.test_leaf(query, current) {
                return;
            }
            match waiting.pop::<S>(query.limit()) {
                Some(child) => current = child,
                None => return,
            }
        }
    }
}

impl Tree for WideTree {
    const BYTES: [usize; 2] = [size_of::<Node>(), size_of::<TriangleBlock>()];

    type Stack = Stack;

    fn stack() -> Self::Stack {
        Stack([0; STACK])
    }

    #[inline(always)]
    fn traverse<S: Variant>(&self, query: &mut Query<'_, S>, stack: &mut Self::Stack) {
        #[cfg(target_arch = "x86_64")]
        if S::AVX2 {
            return self.walk::<Avx2, S>(query, stack);
        }
        self.walk::<Portable, S>(query, stack);
    }
}

/// Children that wait: the bits of where the ray enters each in the upper half, so that integers are in the order
/// of distances, the child in the lower half.
pub(super) struct Waiting<'a> {
    stack: &'a mut [u64; STACK],
    count: usize,
}

impl<'a> Waiting<'a> {
    /// None yet.
    #[inline(always)]
    pub(super) fn new(stack: &'a mut Stack) -> Self {
        Self { stack: &mut stack.0, count: 0 }
    }

    /// The nearest of the children that are hit, one at least, given by their slots; the others wait, the next one
    /// on top.
    #[inline(always)]
    pub(super) fn nearest_of(
        &mut self,
        child: impl Fn(usize) -> u32,
        near: &[f32; 8],
        mut hits: u32,
        ask: impl Fn(usize, u32),
    ) -> u32 {
        let mut next = || {
            let slot = hits.trailing_zeros() as usize % 8;
            hits &= hits.wrapping_sub(1);
            let child = child(slot);
            // The last one, and so the only one, would hardly be sooner there.
            if hits != 0 {
                ask(slot, child);
            }
            (u64::from(near[slot].to_bits()) << 32 | u64::from(child), hits == 0)
        };
        let (first, is_last) = next();
        if is_last {
            return first as u32;
        }
        let (second, is_last) = next();
        let (first, second) = (first.min(second), first.max(second));
        if is_last {
            self.push(second);
            return first as u32;
        }
        let (third, is_last) = next();
        let (second, third) = (second.min(third), second.max(third));
        let (first, second) = (first.min(second), first.max(second));
        self.push(third);
        self.push(second);
        if is_last {
            return first as u32;
        }
        let start = self.count - 2;
        self.push(first);
        loop {
            let (entry, is_last) = next();
            self.insert(start, entry);
            if is_last {
                break;
            }
        }
        self.count -= 1;
        self.stack[self.count % STACK] as u32
    }

    /// The last of the children that are hit, one at least, which is the cheapest to search by the order in which the
    /// builder puts them; the others wait in that order.
    #[inline(always)]
    pub(super) fn cheapest_of(
        &mut self,
        child: impl Fn(usize) -> u32,
        mut hits: u32,
        ask: impl Fn(usize, u32),
    ) -> u32 {
        loop {
            let slot = hits.trailing_zeros() as usize % 8;
            let child = child(slot);
            hits &= hits - 1;
            if hits == 0 {
                return child;
            }
            ask(slot, child);
            self.push(u64::from(child));
        }
    }

    /// Adds what waits to what lies sorted from a place on, the nearest last.
    #[inline(always)]
    fn insert(&mut self, start: usize, entry: u64) {
        let mut place = self.count;
        while place > start && self.stack[(place - 1) % STACK] < entry {
            self.stack[place % STACK] = self.stack[(place - 1) % STACK];
            place -= 1;
        }
        self.stack[place % STACK] = entry;
        self.count += 1;
    }

    /// The depth was checked when the tree was built; the remainder only saves a check.
    #[inline(always)]
    fn push(&mut self, entry: u64) {
        self.stack[self.count % STACK] = entry;
        self.count += 1;
    }

    /// The next child that is not beyond `limit`, as all are until any hit is found.
    #[inline(always)]
    pub(super) fn pop<S: Variant>(&mut self, limit: f32) -> Option<u32> {
        while self.count > 0 {
            self.count -= 1;
            let entry = self.stack[self.count % STACK];
            if S::ANY || f32::from_bits((entry >> 32) as u32) <= limit {
                return Some(entry as u32);
            }
        }
        None
    }
}

/// A way to test the eight boxes of a node.
pub(super) trait WideTest {
    /// Prepares for a ray; `padding` scales where it leaves a box.
    fn new(origin: [f32; 3], inverse: [f32; 3], t_min: f32, padding: f32) -> Self;

    /// Where the ray enters each child's box, and bit `slot` set if it does before it leaves and before `limit`.
    fn test(&self, node: &Node, limit: f32) -> ([f32; 8], u32);
}

/// One box after the other.
pub(super) struct Portable {
    origin: [f32; 3],
    inverse: [f32; 3],
    /// The reciprocals for far planes.
    padded: [f32; 3],
    t_min: f32,
}

impl WideTest for Portable {
    fn new(origin: [f32; 3], inverse: [f32; 3], t_min: f32, padding: f32) -> Self {
        Self { origin, inverse, padded: inverse.map(|inverse| inverse * padding), t_min: t_min + 0.0 }
    }

    fn test(&self, node: &Node, limit: f32) -> ([f32; 8], u32) {
        let (mut near, mut far) = ([f32::NEG_INFINITY; 8], [f32::INFINITY; 8]);
        for axis in 0..3 {
            let is_negative = usize::from(self.inverse[axis] < 0.0);
            let distance = |plane: f32, inverse: f32| (plane - self.origin[axis]) * inverse;
            let [near_planes, far_planes] =
                [is_negative, 1 - is_negative].map(|side| &node.planes[axis][side]);
            for slot in 0..8 {
                near[slot] = near[slot].max(distance(near_planes[slot], self.inverse[axis]));
                far[slot] = far[slot].min(distance(far_planes[slot], self.padded[axis]));
            }
        }
        // The same zero as the instruction gives, which takes its second operand.
        let near = near.map(|near| if near > self.t_min { near } else { self.t_min });
        let is_hit = |slot: usize| near[slot] <= far[slot].min(limit);
        (near, (0..8).fold(0, |hits, slot| hits | u32::from(is_hit(slot)) << slot))
    }
}

#[cfg(target_arch = "x86_64")]
pub(super) use avx2::Avx2;

#[cfg(target_arch = "x86_64")]
mod avx2 {
    use std::arch::x86_64::*;

    use super::{Node, WideTest};

    /// Eight boxes at once; made and used by functions with AVX2 alone.
    pub(in super::super) struct Avx2 {
        origin: [__m256; 3],
        /// Reciprocals with their signs turned, for near planes and, padded, for far ones.
        inverse: [[__m256; 2]; 3],
        t_min: __m256,
        /// Where near planes lie, 0 or [`SIDE`], and where far ones do.
        sides: [[usize; 2]; 3],
    }

    /// Bytes of the planes of one side.
    const SIDE: usize = size_of::<[f32; 8]>();

    impl WideTest for Avx2 {
        #[inline(always)]
        fn new(origin: [f32; 3], inverse: [f32; 3], t_min: f32, padding: f32) -> Self {
            // SAFETY: the caller has AVX2, by this type's contract.
            unsafe { prepare(origin, inverse, t_min, padding) }
        }

        #[inline(always)]
        fn test(&self, node: &Node, limit: f32) -> ([f32; 8], u32) {
            // SAFETY: the caller has AVX2, by this type's contract.
            unsafe { test(self, node, limit) }
        }
    }

    #[inline]
    #[target_feature(enable = "avx2")]
    fn prepare(origin: [f32; 3], inverse: [f32; 3], t_min: f32, padding: f32) -> Avx2 {
        Avx2 {
            origin: origin.map(|origin| _mm256_set1_ps(origin)),
            inverse: inverse.map(|inverse| [_mm256_set1_ps(-inverse), _mm256_set1_ps(-inverse * padding)]),
            t_min: _mm256_set1_ps(t_min + 0.0),
            sides: inverse.map(|inverse| if inverse < 0.0 { [SIDE, 0] } else { [0, SIDE] }),
        }
    }

    #[inline]
    #[target_feature(enable = "avx2")]
    fn test(ray: &Avx2, node: &Node, limit: f32) -> ([f32; 8], u32) {
        let planes: &[u8; 6 * SIDE] = bytemuck::cast_ref(&node.planes);
        let slab = |axis: usize| {
            // Both signs are turned, since it is the second operand that instructions take from memory.
            let distance = |side: usize| {
                let first = 2 * axis * SIDE + (ray.sides[axis][side] & SIDE);
                let planes: __m256 = bytemuck::pod_read_unaligned(&planes[first..first + SIDE]);
                _mm256_mul_ps(_mm256_sub_ps(ray.origin[axis], planes), ray.inverse[axis][side])
            };
            (distance(0), distance(1))
        };
        let (x, y, z) = (slab(0), slab(1), slab(2));
        // In two halves each, so that nothing waits longer than it must.
        let near = _mm256_max_ps(_mm256_max_ps(x.0, y.0), _mm256_max_ps(z.0, ray.t_min));
        let far = _mm256_min_ps(_mm256_min_ps(x.1, y.1), _mm256_min_ps(z.1, _mm256_set1_ps(limit)));
        let hits = _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(near, far)) as u32;
        (bytemuck::cast(near), hits)
    }
}
