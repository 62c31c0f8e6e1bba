//! Traversal of the binary hierarchy on a thread: both children of a node are tested together.

use scenes::bvh::{BVH2_STACK, Bvh2Node};

use super::PADDING;
use super::cpu::Query;

/// Bits of a reference that hold the first leaf slot or node pair; those above hold the number of
/// triangles, 0 for an inner node.
const FIRST_BITS: u32 = 28;

/// The nodes in pairs.
#[derive(Clone, Debug)]
pub(super) struct BinaryTree {
    root: u32,
    pairs: Vec<Pair>,
}

/// A node's box and the reference to what is in it.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
struct Child {
    min: [f32; 3],
    reference: u32,
    max: [f32; 3],
    unused: u32,
}

/// Two siblings, in one cache line.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug)]
pub(super) struct Pair([Child; 2]);

/// What waits on the stack: a reference and the distance of its box.
type Waiting = (u32, f32);

impl BinaryTree {
    /// From nodes as they come from the builder.
    pub(super) fn new(nodes: &[Bvh2Node]) -> Self {
        let reference = |node: &Bvh2Node| match node.count {
            0 => node.first / 2 - 1,
            count => count << FIRST_BITS | node.first,
        };
        let child =
            |node: &Bvh2Node| Child { min: node.min, reference: reference(node), max: node.max, unused: 0 };
        let pairs = nodes[1..].get(1..).unwrap_or_default().chunks_exact(2);
        Self {
            root: reference(&nodes[0]),
            pairs: pairs.map(|pair| Pair([child(&pair[0]), child(&pair[1])])).collect(),
        }
    }

    /// Finds what the query asks for.
    #[inline(always)]
    pub(super) fn traverse<T: PairTest, const ANY: bool, const COUNT: bool, const MASKS: bool>(
        &self,
        query: &mut Query<'_, ANY, COUNT, MASKS>,
    ) {
        let test = T::new(query.origin, query.inverse, query.t_min);
        let mut stack: [Waiting; BVH2_STACK] = [(0, 0.0); BVH2_STACK];
        let mut waiting = 0;
        let mut current = self.root;
        loop {
            let first = (current & ((1 << FIRST_BITS) - 1)) as usize;
            let count = (current >> FIRST_BITS) as usize;
            if count == 0 {
                query.count_node();
                let pair = &self.pairs[first];
                let (near, is_hit) = test.test(pair, query.limit());
                let references = [pair.0[0].reference, pair.0[1].reference];
                if is_hit == 0b11 {
                    let nearer = usize::from(near[1] < near[0]);
                    // The depth was checked when the tree was built; the mask only saves a check.
                    stack[waiting % BVH2_STACK] = (references[1 - nearer], near[1 - nearer]);
                    waiting += 1;
                    current = references[nearer];
                    continue;
                }
                if is_hit != 0 {
                    current = references[(is_hit >> 1) as usize];
                    continue;
                }
            } else if (first..first + count).any(|slot| query.test(slot)) {
                return;
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

/// A way to test both boxes of a pair.
pub(super) trait PairTest {
    /// Prepares for a ray.
    fn new(origin: [f32; 3], inverse: [f32; 3], t_min: f32) -> Self;

    /// Where the ray enters both boxes, and bit i set if it enters box i before `limit`.
    fn test(&self, pair: &Pair, limit: f32) -> ([f32; 2], u32);
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

    fn test(&self, pair: &Pair, limit: f32) -> ([f32; 2], u32) {
        let test = |child: &Child| {
            let (mut near, mut far) = (self.t_min, f32::INFINITY);
            for axis in 0..3 {
                let low = (child.min[axis] - self.origin[axis]) * self.inverse[axis];
                let high = (child.max[axis] - self.origin[axis]) * self.inverse[axis];
                near = near.max(low.min(high));
                far = far.min(low.max(high));
            }
            (near, near <= (far * PADDING).min(limit))
        };
        let [(near_0, is_hit_0), (near_1, is_hit_1)] = [test(&pair.0[0]), test(&pair.0[1])];
        ([near_0, near_1], u32::from(is_hit_0) | u32::from(is_hit_1) << 1)
    }
}

#[cfg(target_arch = "x86_64")]
pub(super) use avx2::Avx2;

#[cfg(target_arch = "x86_64")]
mod avx2 {
    use std::arch::x86_64::*;

    use super::{Pair, PairTest};
    use crate::stages::trace::PADDING;

    /// Both boxes at once; made and used by functions with AVX2 alone.
    pub(in super::super) struct Avx2 {
        /// Twice x, y, z, and 1 in the lanes where a node has no plane.
        origin: __m256,
        inverse: __m256,
        t_min: __m256,
    }

    impl PairTest for Avx2 {
        #[inline(always)]
        fn new(origin: [f32; 3], inverse: [f32; 3], t_min: f32) -> Self {
            // SAFETY: the caller has AVX2, by this type's contract.
            unsafe { prepare(origin, inverse, t_min) }
        }

        #[inline(always)]
        fn test(&self, pair: &Pair, limit: f32) -> ([f32; 2], u32) {
            // SAFETY: the caller has AVX2, by this type's contract.
            unsafe { test(self, pair, limit) }
        }
    }

    #[inline]
    #[target_feature(enable = "avx2")]
    fn prepare([ox, oy, oz]: [f32; 3], [ix, iy, iz]: [f32; 3], t_min: f32) -> Avx2 {
        Avx2 {
            // The lane between the corners holds integers, most of them denormal numbers, which
            // are slow to multiply: subtracting 1 makes them −1.
            origin: _mm256_setr_ps(ox, oy, oz, 1.0, ox, oy, oz, 1.0),
            inverse: _mm256_setr_ps(ix, iy, iz, 1.0, ix, iy, iz, 1.0),
            t_min: _mm256_set1_ps(t_min),
        }
    }

    #[inline]
    #[target_feature(enable = "avx2")]
    fn test(ray: &Avx2, pair: &Pair, limit: f32) -> ([f32; 2], u32) {
        let boxes: [__m256; 2] = bytemuck::cast(pair.0);
        let planes = boxes.map(|planes| _mm256_mul_ps(_mm256_sub_ps(planes, ray.origin), ray.inverse));
        let low = _mm256_permute2f128_ps::<0x20>(planes[0], planes[1]);
        let high = _mm256_permute2f128_ps::<0x31>(planes[0], planes[1]);
        let near = _mm256_blend_ps::<0x88>(_mm256_min_ps(low, high), ray.t_min);
        let far = _mm256_blend_ps::<0x88>(_mm256_max_ps(low, high), _mm256_set1_ps(f32::INFINITY));
        let near = _mm256_max_ps(near, _mm256_shuffle_ps::<0b10_11_00_01>(near, near));
        let far = _mm256_min_ps(far, _mm256_shuffle_ps::<0b10_11_00_01>(far, far));
        let near = _mm256_max_ps(near, _mm256_shuffle_ps::<0b01_00_11_10>(near, near));
        let far = _mm256_min_ps(far, _mm256_shuffle_ps::<0b01_00_11_10>(far, far));
        let far = _mm256_min_ps(_mm256_mul_ps(far, _mm256_set1_ps(PADDING)), _mm256_set1_ps(limit));
        let is_hit = _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(near, far)) as u32;
        let first = _mm_cvtss_f32(_mm256_castps256_ps128(near));
        let second = _mm_cvtss_f32(_mm256_extractf128_ps::<1>(near));
        ([first, second], is_hit & 1 | is_hit >> 3 & 2)
    }
}
