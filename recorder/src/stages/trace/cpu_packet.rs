//! Sixteen rays that share one traversal of the binary hierarchy: one stack, whose entries say which of them enter
//! a box.
//!
//! A box is visited if any ray enters it before what that ray has found, and only by those that do. Nearest hits
//! do not depend on the order in which boxes are visited, so the packet goes first where most of its rays are nearer.
//!
//! **Shadow rays** must end at an occluder that does not depend on the others of the packet. They visit the
//! children of a node in an order that depends on the node alone, the smaller box first, and a ray has no say in the
//! boxes that it does not enter itself: it ends at the first triangle on its own way in that order.
//!
//! **Work** is what a ray takes in a packet of its own: what it takes among others depends on them.

use formats::intersect::Shear;
use formats::ray::Hit;
use scenes::bvh::BVH2_STACK;

use super::cpu_bvh2::{BinaryTree, Pair};
use super::cpu_group::{BoxLanes, Group, lanes_of};
use super::cpu_part::Part;
use super::cpu_query::{Query, Searcher, Variant};
#[cfg(target_arch = "x86_64")]
use super::cpu_vector::Avx2;
use super::cpu_vector::{Portable, Vector};
use super::mask::Masks;
use super::triangle::{LeafTriangle, ShearLanes};

/// The binary hierarchy, walked by packets.
#[derive(Clone, Debug)]
pub(super) struct PacketTree(pub BinaryTree);

impl PacketTree {
    /// Rays of a packet: two vectors.
    pub(super) const WIDTH: usize = 16;
}

impl Searcher<Shear> for PacketTree {
    #[inline(always)]
    fn search<S: Variant<Ray = Shear>, T>(
        &self,
        masks: &Masks,
        part: Part<'_, T>,
        account: &S::Account,
        mut keep: impl FnMut(&T, Hit, S::Account),
    ) -> usize {
        #[cfg(target_arch = "x86_64")]
        if S::AVX2 {
            return search::<Avx2, S, T>(&self.0, masks, &part, account, &mut keep);
        }
        search::<Portable, S, T>(&self.0, masks, &part, account, &mut keep)
    }
}

#[inline(always)]
fn search<V: Vector, S: Variant<Ray = Shear>, T>(
    tree: &BinaryTree,
    masks: &Masks,
    part: &Part<'_, T>,
    account: &S::Account,
    keep: &mut impl FnMut(&T, Hit, S::Account),
) -> usize {
    let mut stack = [Waiting { reference: 0, rays: 0, near: [V::splat(0.0); 2] }; BVH2_STACK];
    for first in (0..part.len()).step_by(PacketTree::WIDTH) {
        let mut group = Group::<S, T, 16>::new(part, first, account, masks);
        let working = group.working();
        Packet::<V, S>::new(&mut group.queries, working).walk(tree, &mut stack);
        group.keep(&mut *keep);
    }
    part.len()
}

/// What waits: a reference, the rays that enter its box, and where.
#[derive(Clone, Copy)]
struct Waiting<V> {
    reference: u32,
    rays: u32,
    near: [V; 2],
}

/// Sixteen rays on their way.
struct Packet<'a, 'm, V: Vector, S: Variant> {
    queries: &'a mut [Query<'m, S>; 16],
    boxes: [BoxLanes<V>; 2],
    triangles: [ShearLanes<V>; 2],
    /// Beyond what each ray need not look.
    limit: [[f32; 8]; 2],
    /// The rays that are not done.
    working: u32,
}

impl<'a, 'm, V: Vector, S: Variant<Ray = Shear>> Packet<'a, 'm, V, S> {
    #[inline(always)]
    fn new(queries: &'a mut [Query<'m, S>; 16], working: u32) -> Self {
        let halves = [0, 8].map(|first| std::array::from_fn::<_, 8, _>(|lane| &queries[first + lane]));
        Self {
            boxes: [BoxLanes::new(halves[0]), BoxLanes::new(halves[1])],
            triangles: [
                ShearLanes::new(halves[0].map(Query::triangle_ray)),
                ShearLanes::new(halves[1].map(Query::triangle_ray)),
            ],
            limit: halves.map(|half| half.map(Query::limit)),
            queries,
            working,
        }
    }

    #[inline(always)]
    fn walk(&mut self, tree: &BinaryTree, stack: &mut [Waiting<V>; BVH2_STACK]) {
        let (mut current, mut rays, mut waiting) = (tree.root(), self.working, 0);
        loop {
            let (count, first) = BinaryTree::leaf(current);
            if count == 0 {
                let pair = tree.pair(first);
                let near = self.visit(pair, first, rays);
                if near[0].1 | near[1].1 != 0 {
                    let next = goes_second::<V, S>(pair, &near);
                    let (next, other) = (usize::from(next), usize::from(!next));
                    if near[other].1 != 0 {
                        // The depth was checked when the tree was built; the remainder only saves a check.
                        stack[waiting % BVH2_STACK] = Waiting {
                            reference: pair.references[other],
                            rays: near[other].1,
                            near: near[other].0,
                        };
                        waiting += 1;
                    }
                    (current, rays) = (pair.references[next], near[next].1);
                    continue;
                }
            } else {
                for slot in first..first + count {
                    self.test(tree.triangle(slot), slot, rays & self.working);
                }
            }
            loop {
                if waiting == 0 {
                    return;
                }
                waiting -= 1;
                let entry = &stack[waiting % BVH2_STACK];
                rays = entry.rays & self.working & self.not_beyond(&entry.near);
                if rays != 0 {
                    current = entry.reference;
                    break;
                }
            }
        }
    }

    /// The rays for which this is not beyond what they have found.
    #[inline(always)]
    fn not_beyond(&self, near: &[V; 2]) -> u32 {
        near[0].le(V::load(&self.limit[0])) | near[1].le(V::load(&self.limit[1])) << 8
    }

    /// Where rays enter both boxes of a node, and which of them do.
    #[inline(always)]
    fn visit(&mut self, pair: &Pair, place: usize, rays: u32) -> [([V; 2], u32); 2] {
        self.queries[0].step();
        lanes_of(rays).for_each(|ray| self.queries[ray].visit(place));
        let padding = self.queries[0].padding();
        let mut found = [([V::splat(0.0); 2], 0); 2];
        for (child, (near, enter)) in found.iter_mut().enumerate() {
            let mut planes = [[V::splat(0.0); 2]; 3];
            for (planes, both) in planes.iter_mut().zip(&pair.planes) {
                *planes = [V::splat(both[child]), V::splat(both[child + 2])];
            }
            for (half, near) in near.iter_mut().enumerate() {
                let limit = V::load(&self.limit[half]);
                let (entered, hits) = self.boxes[half].enter(planes, limit, padding);
                *near = entered;
                *enter |= hits << (8 * half);
            }
            *enter &= rays;
        }
        found
    }

    /// Tests a triangle for some rays.
    #[inline(always)]
    fn test(&mut self, leaf: &LeafTriangle, slot: usize, rays: u32) {
        if rays == 0 {
            return;
        }
        self.queries[0].step();
        lanes_of(rays).for_each(|ray| self.queries[ray].visit_leaf(slot, || 1));
        let corners = leaf.corners().map(|corner| [corner.x, corner.y, corner.z, 0.0]);
        let mut candidates = 0;
        for half in 0..2 {
            let axes = self.triangles[half].axes();
            // No closures, which lack the instructions of what they are inlined into.
            let mut picked = [[V::splat(0.0); 3]; 3];
            for (corner, picked) in corners.iter().zip(&mut picked) {
                for (axis, picked) in picked.iter_mut().enumerate() {
                    *picked = V::pick(corner, &axes[axis]);
                }
            }
            let limit = V::load(&self.limit[half]);
            candidates |= self.triangles[half].candidates(picked, limit) << (8 * half);
        }
        for ray in lanes_of(candidates & rays) {
            let is_done = self.queries[ray].test(leaf);
            self.working &= !(u32::from(is_done) << ray);
            self.limit[ray / 8][ray % 8] = self.queries[ray].limit();
        }
    }
}

/// Whether a packet goes to the second child first, one of which at least is entered.
#[inline(always)]
fn goes_second<V: Vector, S: Variant>(pair: &Pair, near: &[([V; 2], u32); 2]) -> bool {
    let [(near_first, enter_first), (near_second, enter_second)] = near;
    let both = enter_first & enter_second;
    if *enter_first == 0 || *enter_second == 0 {
        return *enter_first == 0;
    }
    if S::ANY {
        return pair.is_second_smaller();
    }
    let is_first_nearer = near_first[0].le(near_second[0]) | near_first[1].le(near_second[1]) << 8;
    2 * (both & is_first_nearer).count_ones() < both.count_ones()
}
