//! Traversal of the compressed wide hierarchy on a thread (Ylitie et al. 2017), eight boxes at a
//! time.

use formats::pages::on_huge_pages;
use scenes::bvh::{CWBVH_STACK, CwbvhNode};

use super::cpu_query::{Query, Tree, Variant};
use super::triangle::LeafTriangle;

/// The nodes, and the triangles by leaf slots.
#[derive(Clone, Debug)]
pub(super) struct CompressedTree {
    nodes: Vec<Node>,
    triangles: Vec<LeafTriangle>,
}

/// [`CwbvhNode`] with its eight-byte fields as integers, low byte first, in 16-byte units so that each lies in two
/// cache lines.
#[repr(C, align(16))]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
pub(super) struct Node {
    p: [f32; 3],
    e: [u8; 3],
    imask: u8,
    child_base: u32,
    triangle_base: u32,
    meta: [u8; 8],
    /// Per axis the low and the high planes of the slots.
    planes: [[[u8; 8]; 2]; 3],
}

impl CompressedTree {
    /// From nodes as they come from the builder.
    pub(super) fn new(nodes: &[CwbvhNode], triangles: Vec<LeafTriangle>) -> Self {
        Self { nodes: on_huge_pages(nodes.iter().map(|&node| bytemuck::cast(node))), triangles }
    }

    #[inline(always)]
    fn walk<T: CompressedTest, S: Variant>(
        &self,
        query: &mut Query<'_, S>,
        stack: &mut <Self as Tree>::Stack,
    ) {
        let test = T::new(query.origin, query.inverse, query.t_min);
        let is_positive = query.inverse.map(|inverse| u32::from(inverse > 0.0));
        let octant = is_positive[0] << 2 | is_positive[1] << 1 | is_positive[2];
        // What waits: the index of a first inner child, and in the top byte which of them, the next one highest; in
        // the low byte which slots have inner children.
        let mut waiting = 0;
        let mut current = 0;
        loop {
            query.visit(current as usize);
            let node = &self.nodes[current as usize];
            let hits = test.test(node, query.limit(), query.padding());
            let imask = u32::from(node.imask);
            let mut triangles = triangles(node, hits & !imask);
            while triangles != 0 {
                let offset = triangles.ilog2();
                triangles ^= 1 << offset;
                let slot = (node.triangle_base + offset) as usize;
                query.visit_leaf(slot, || 1);
                if query.test(&self.triangles[slot]) {
                    return;
                }
            }
            let mut group = (node.child_base, in_order(hits & imask, octant) << 24 | imask);
            if group.1 >> 24 == 0 {
                if waiting == 0 {
                    return;
                }
                waiting -= 1;
                group = stack[waiting % CWBVH_STACK];
            }
            let place = group.1.ilog2();
            group.1 ^= 1 << place;
            if group.1 >> 24 != 0 {
                // The depth was checked when the tree was built; the remainder only saves a check.
                stack[waiting % CWBVH_STACK] = group;
                waiting += 1;
            }
            let slot = (place - 24) ^ octant;
            let below = group.1 & 0xff & ((1 << slot) - 1);
            current = group.0 + below.count_ones();
        }
    }
}

impl Tree for CompressedTree {
    const BYTES: [usize; 2] = [size_of::<Node>(), size_of::<LeafTriangle>()];

    type Stack = [(u32, u32); CWBVH_STACK];

    fn stack() -> Self::Stack {
        [Default::default(); CWBVH_STACK]
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

/// One bit per triangle of the leaf children in `hits`, by its offset from the node's first.
#[inline(always)]
fn triangles(node: &Node, mut hits: u32) -> u32 {
    let mut triangles = 0;
    while hits != 0 {
        let meta = u32::from(node.meta[hits.trailing_zeros() as usize & 7]);
        hits &= hits - 1;
        triangles |= (meta >> 5) << (meta & 31);
    }
    triangles
}

/// Moves bit `slot` to bit `slot ^ octant`.
#[inline(always)]
fn in_order(mut slots: u32, octant: u32) -> u32 {
    if octant & 1 != 0 {
        slots = slots >> 1 & 0x55 | slots << 1 & 0xaa;
    }
    if octant & 2 != 0 {
        slots = slots >> 2 & 0x33 | slots << 2 & 0xcc;
    }
    if octant & 4 != 0 {
        slots = slots >> 4 & 0x0f | slots << 4 & 0xf0;
    }
    slots
}

/// A way to test the eight boxes of a node.
pub(super) trait CompressedTest {
    /// Prepares for a ray.
    fn new(origin: [f32; 3], inverse: [f32; 3], t_min: f32) -> Self;

    /// Bit `slot` set if the ray enters that child's box before `limit`; `padding` scales where it leaves. For empty slots it may be
    /// set or not.
    fn test(&self, node: &Node, limit: f32, padding: f32) -> u32;
}

/// One box after the other.
pub(super) struct Portable {
    origin: [f32; 3],
    inverse: [f32; 3],
    t_min: f32,
}

impl CompressedTest for Portable {
    fn new(origin: [f32; 3], inverse: [f32; 3], t_min: f32) -> Self {
        Self { origin, inverse, t_min }
    }

    fn test(&self, node: &Node, limit: f32, padding: f32) -> u32 {
        let mut near = [self.t_min; 8];
        let mut far = [f32::INFINITY; 8];
        for axis in 0..3 {
            let exponent = u32::from(node.e[axis]);
            let origin = (self.origin[axis] - node.p[axis]) * f32::from_bits((254 - exponent) << 23);
            let inverse = self.inverse[axis] * f32::from_bits(exponent << 23);
            let is_negative = usize::from(inverse < 0.0);
            for slot in 0..8 {
                let plane = |side: usize| (f32::from(node.planes[axis][side][slot]) - origin) * inverse;
                near[slot] = near[slot].max(plane(is_negative));
                far[slot] = far[slot].min(plane(1 - is_negative));
            }
        }
        (0..8).fold(0, |hits, slot| hits | u32::from(near[slot] <= (far[slot] * padding).min(limit)) << slot)
    }
}

#[cfg(target_arch = "x86_64")]
pub(super) use avx2::Avx2;

#[cfg(target_arch = "x86_64")]
mod avx2 {
    use std::arch::x86_64::*;

    use super::{CompressedTest, Node};

    /// Eight boxes at once; made and used by functions with AVX2 alone.
    pub(in super::super) struct Avx2 {
        /// x, y, z, and 0.
        origin: __m128,
        /// x, y, z, and 0.
        inverse: __m128,
        t_min: __m256,
        /// Per axis 0 if the low planes are the near ones, else 1.
        is_negative: [usize; 3],
    }

    impl CompressedTest for Avx2 {
        #[inline(always)]
        fn new(origin: [f32; 3], inverse: [f32; 3], t_min: f32) -> Self {
            // SAFETY: the caller has AVX2, by this type's contract.
            unsafe { prepare(origin, inverse, t_min) }
        }

        #[inline(always)]
        fn test(&self, node: &Node, limit: f32, padding: f32) -> u32 {
            // SAFETY: the caller has AVX2, by this type's contract.
            unsafe { test(self, node, limit, padding) }
        }
    }

    #[inline]
    #[target_feature(enable = "avx2")]
    fn prepare(origin: [f32; 3], inverse: [f32; 3], t_min: f32) -> Avx2 {
        Avx2 {
            origin: _mm_setr_ps(origin[0], origin[1], origin[2], 0.0),
            inverse: _mm_setr_ps(inverse[0], inverse[1], inverse[2], 0.0),
            t_min: _mm256_set1_ps(t_min),
            is_negative: inverse.map(|inverse| usize::from(inverse < 0.0)),
        }
    }

    /// The quantised planes of one axis and side.
    #[inline]
    #[target_feature(enable = "avx2")]
    fn decode(planes: &[u8; 8]) -> __m256 {
        let bytes = _mm_cvtsi64_si128(i64::from_le_bytes(*planes));
        _mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(bytes))
    }

    #[inline]
    #[target_feature(enable = "avx2")]
    fn test(ray: &Avx2, node: &Node, limit: f32, padding: f32) -> u32 {
        let p = _mm_setr_ps(node.p[0], node.p[1], node.p[2], 0.0);
        let packed = i32::from_le_bytes([node.e[0], node.e[1], node.e[2], node.imask]);
        let exponent = _mm_cvtepu8_epi32(_mm_cvtsi32_si128(packed));
        let step = _mm_castsi128_ps(_mm_slli_epi32::<23>(exponent));
        let steps = _mm_castsi128_ps(_mm_slli_epi32::<23>(_mm_sub_epi32(_mm_set1_epi32(254), exponent)));
        let origin = _mm_mul_ps(_mm_sub_ps(ray.origin, p), steps);
        let inverse = _mm_mul_ps(ray.inverse, step);
        let origin = _mm256_insertf128_ps::<1>(_mm256_castps128_ps256(origin), origin);
        let inverse = _mm256_insertf128_ps::<1>(_mm256_castps128_ps256(inverse), inverse);
        let axis = |axis: usize, origin: __m256, inverse: __m256| {
            let [low, high] = &node.planes[axis];
            let (near, far) = if ray.is_negative[axis] == 0 { (low, high) } else { (high, low) };
            let distance = |planes| _mm256_mul_ps(_mm256_sub_ps(decode(planes), origin), inverse);
            (distance(near), distance(far))
        };
        let x = axis(0, _mm256_permute_ps::<0x00>(origin), _mm256_permute_ps::<0x00>(inverse));
        let y = axis(1, _mm256_permute_ps::<0x55>(origin), _mm256_permute_ps::<0x55>(inverse));
        let z = axis(2, _mm256_permute_ps::<0xaa>(origin), _mm256_permute_ps::<0xaa>(inverse));
        let near = _mm256_max_ps(_mm256_max_ps(x.0, y.0), _mm256_max_ps(z.0, ray.t_min));
        let far = _mm256_mul_ps(_mm256_min_ps(_mm256_min_ps(x.1, y.1), z.1), _mm256_set1_ps(padding));
        let far = _mm256_min_ps(far, _mm256_set1_ps(limit));
        _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(near, far)) as u32
    }
}
