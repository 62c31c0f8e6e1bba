//! Traversal of the binary hierarchy on a thread: both children of a node are tested together.

use formats::pages::on_huge_pages;
use scenes::bvh::{BVH2_STACK, Bvh2Node};

use super::cpu_query::{Query, Tree, Variant};
use super::triangle::LeafTriangle;

/// Bits of a reference that hold the first leaf slot or node pair; those above hold the number of
/// triangles, 0 for an inner node.
const FIRST_BITS: u32 = 28;

/// The nodes in pairs, and the triangles by leaf slots.
#[derive(Clone, Debug)]
pub(super) struct BinaryTree {
    root: u32,
    pairs: Vec<Pair>,
    triangles: Vec<LeafTriangle>,
}

/// Two siblings in one cache line, axis by axis, so that one vector holds the planes of both.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug)]
pub(super) struct Pair {
    /// Per axis: lower plane of the first box and of the second, upper plane of the first and of the second.
    pub(super) planes: [[f32; 4]; 3],
    pub(super) references: [u32; 2],
    /// 1 if the second box has the smaller surface, else 0.
    second_is_smaller: u32,
    unused: u32,
}

impl Pair {
    fn new(nodes: &[Bvh2Node]) -> Self {
        let (first, second) = (&nodes[0], &nodes[1]);
        let planes = |axis: usize| [first.min[axis], second.min[axis], first.max[axis], second.max[axis]];
        Self {
            planes: [planes(0), planes(1), planes(2)],
            references: [reference(first), reference(second)],
            second_is_smaller: u32::from(half_area(second) < half_area(first)),
            unused: 0,
        }
    }

    /// Whether the second box has the smaller surface.
    #[inline(always)]
    pub(super) fn is_second_smaller(&self) -> bool {
        self.second_is_smaller != 0
    }
}

/// Half of the surface of a node's box.
fn half_area(node: &Bvh2Node) -> f32 {
    let [x, y, z] = [0, 1, 2].map(|axis| node.max[axis] - node.min[axis]);
    x * y + y * z + z * x
}

fn reference(node: &Bvh2Node) -> u32 {
    match node.count {
        0 => node.first / 2 - 1,
        count => count << FIRST_BITS | node.first,
    }
}

impl BinaryTree {
    /// From nodes as they come from the builder.
    pub(super) fn new(nodes: &[Bvh2Node], triangles: Vec<LeafTriangle>) -> Self {
        let pairs = nodes[1..].get(1..).unwrap_or_default().chunks_exact(2);
        Self { root: reference(&nodes[0]), pairs: on_huge_pages(pairs.map(Pair::new)), triangles }
    }

    /// Where rays start.
    #[inline(always)]
    pub(super) fn root(&self) -> u32 {
        self.root
    }

    /// The children of a node.
    #[inline(always)]
    pub(super) fn pair(&self, place: usize) -> &Pair {
        &self.pairs[place]
    }

    /// The triangle in a leaf slot.
    #[inline(always)]
    pub(super) fn triangle(&self, slot: usize) -> &LeafTriangle {
        &self.triangles[slot]
    }

    /// Number of triangles of a reference, 0 for an inner node, and its first leaf slot or node pair.
    #[inline(always)]
    pub(super) fn leaf(reference: u32) -> (usize, usize) {
        ((reference >> FIRST_BITS) as usize, (reference & ((1 << FIRST_BITS) - 1)) as usize)
    }

    /// A leaf without its first triangle, if there are more.
    #[inline(always)]
    pub(super) fn rest(leaf: u32) -> Option<u32> {
        let rest = leaf - (1 << FIRST_BITS) + 1;
        (rest >> FIRST_BITS > 0).then_some(rest)
    }

    #[inline(always)]
    fn walk<T: PairTest, S: Variant>(&self, query: &mut Query<'_, S>, stack: &mut <Self as Tree>::Stack) {
        let test = T::new(query.origin, query.inverse, query.t_min);
        let mut waiting = 0;
        let mut current = self.root;
        loop {
            let (count, first) = Self::leaf(current);
            if count == 0 {
                query.visit(first);
                let pair = &self.pairs[first];
                let (near, is_hit) = test.test(pair, query.limit(), query.padding());
                let [first, second] = pair.references;
                if is_hit == 0b11 {
                    let is_swapped = near[1] < near[0];
                    let farther = if is_swapped { (first, near[0]) } else { (second, near[1]) };
                    // The depth was checked when the tree was built; the remainder only saves a check.
                    stack[waiting % BVH2_STACK] = farther;
                    waiting += 1;
                    current = if is_swapped { second } else { first };
                    continue;
                }
                if is_hit != 0 {
                    current = if is_hit == 0b10 { second } else { first };
                    continue;
                }
            } else {
                for slot in first..first + count {
                    query.visit_leaf(slot, || 1);
                    if query.test(&self.triangles[slot]) {
                        return;
                    }
                }
            }
            loop {
                if waiting == 0 {
                    return;
                }
                waiting -= 1;
                let (reference, near) = stack[waiting % BVH2_STACK];
                if near <= query.limit() {
                    current = reference;
                    break;
                }
            }
        }
    }
}

impl Tree for BinaryTree {
    const BYTES: [usize; 2] = [size_of::<Pair>(), size_of::<LeafTriangle>()];

    type Stack = [(u32, f32); BVH2_STACK];

    fn stack() -> Self::Stack {
        [Default::default(); BVH2_STACK]
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

/// A way to test both boxes of a pair.
pub(super) trait PairTest {
    /// Prepares for a ray.
    fn new(origin: [f32; 3], inverse: [f32; 3], t_min: f32) -> Self;

    /// Where the ray enters both boxes, and bit i set if it enters box i before `limit`;
    /// `padding` scales where it leaves.
    fn test(&self, pair: &Pair, limit: f32, padding: f32) -> ([f32; 2], u32);
}

/// One box after the other.
pub(super) struct Portable {
    origin: [f32; 3],
    inverse: [f32; 3],
    t_min: f32,
}

impl PairTest for Portable {
    fn new(origin: [f32; 3], inverse: [f32; 3], t_min: f32) -> Self {
        Self { origin, inverse, t_min }
    }

    fn test(&self, pair: &Pair, limit: f32, padding: f32) -> ([f32; 2], u32) {
        let test = |child: usize| {
            let (mut near, mut far) = (self.t_min, f32::INFINITY);
            for axis in 0..3 {
                let low = (pair.planes[axis][child] - self.origin[axis]) * self.inverse[axis];
                let high = (pair.planes[axis][child + 2] - self.origin[axis]) * self.inverse[axis];
                near = near.max(low.min(high));
                far = far.min(low.max(high));
            }
            (near, near <= (far * padding).min(limit))
        };
        let [(near_0, is_hit_0), (near_1, is_hit_1)] = [test(0), test(1)];
        ([near_0, near_1], u32::from(is_hit_0) | u32::from(is_hit_1) << 1)
    }
}

#[cfg(target_arch = "x86_64")]
pub(super) use avx2::Avx2;

#[cfg(target_arch = "x86_64")]
mod avx2 {
    use std::arch::x86_64::*;

    use super::{Pair, PairTest};

    /// Both boxes at once; made and used by functions with AVX2 alone.
    pub(in super::super) struct Avx2 {
        origin: [__m128; 3],
        inverse: [__m128; 3],
        t_min: __m128,
    }

    impl PairTest for Avx2 {
        #[inline(always)]
        fn new(origin: [f32; 3], inverse: [f32; 3], t_min: f32) -> Self {
            // SAFETY: the caller has AVX2, by this type's contract.
            unsafe { prepare(origin, inverse, t_min) }
        }

        #[inline(always)]
        fn test(&self, pair: &Pair, limit: f32, padding: f32) -> ([f32; 2], u32) {
            // SAFETY: the caller has AVX2, by this type's contract.
            unsafe { test(self, pair, limit, padding) }
        }
    }

    #[inline]
    #[target_feature(enable = "avx2")]
    fn prepare([ox, oy, oz]: [f32; 3], [ix, iy, iz]: [f32; 3], t_min: f32) -> Avx2 {
        Avx2 {
            origin: [_mm_set1_ps(ox), _mm_set1_ps(oy), _mm_set1_ps(oz)],
            inverse: [_mm_set1_ps(ix), _mm_set1_ps(iy), _mm_set1_ps(iz)],
            t_min: _mm_set1_ps(t_min),
        }
    }

    #[inline]
    #[target_feature(enable = "avx2")]
    fn test(ray: &Avx2, pair: &Pair, limit: f32, padding: f32) -> ([f32; 2], u32) {
        let planes: [__m128; 3] = bytemuck::cast(pair.planes);
        let slab = |axis: usize| {
            let at = _mm_mul_ps(_mm_sub_ps(planes[axis], ray.origin[axis]), ray.inverse[axis]);
            let swapped = _mm_movehl_ps(at, at);
            (_mm_min_ps(at, swapped), _mm_max_ps(at, swapped))
        };
        let [(near_x, far_x), (near_y, far_y), (near_z, far_z)] = [slab(0), slab(1), slab(2)];
        let near = _mm_max_ps(_mm_max_ps(near_x, near_y), _mm_max_ps(near_z, ray.t_min));
        let far = _mm_min_ps(_mm_min_ps(far_x, far_y), far_z);
        let far = _mm_min_ps(_mm_mul_ps(far, _mm_set1_ps(padding)), _mm_set1_ps(limit));
        let is_hit = _mm_movemask_ps(_mm_cmple_ps(near, far)) as u32;
        ([_mm_cvtss_f32(near), _mm_cvtss_f32(_mm_movehdup_ps(near))], is_hit & 0b11)
    }
}
