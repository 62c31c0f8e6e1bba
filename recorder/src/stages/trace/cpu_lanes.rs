//! Eight rays in lockstep, as a GPU's subgroup traces them: each lane walks the binary hierarchy with its own
//! stack, and waits while others do something else.
//!
//! A *step* is one thing that all lanes do which are there to do it: test both children of their nodes, or test
//! one of the triangles of their leaves. As in the loop of Aila and Laine 2009, "Understanding the Efficiency of
//! Ray Traversal on GPUs", §3, nodes are visited until every lane that works has a leaf, and then triangles are
//! tested until none has one left. The hierarchy is the binary one, as in that kernel: a lane's step is short there,
//! and needs no order of eight children. Each ray does what it would do alone by the kernel `bvh2`, in the
//! same order, so that hits, distances of shadow rays and work are the same.

use formats::intersect::Shear;
use formats::ray::Hit;
use scenes::bvh::BVH2_STACK;

use super::cpu_bvh2::BinaryTree;
use super::cpu_group::{BoxLanes, Group, lanes_of};
use super::cpu_part::Part;
use super::cpu_query::{Query, Searcher, Variant};
#[cfg(target_arch = "x86_64")]
use super::cpu_vector::Avx2;
use super::cpu_vector::{Portable, Vector};
use super::mask::Masks;
use super::triangle::ShearLanes;

/// The binary hierarchy, walked by eight rays at a time.
#[derive(Clone, Debug)]
pub(super) struct LaneTree(pub BinaryTree);

impl LaneTree {
    /// Rays of a group.
    pub(super) const WIDTH: usize = 8;
}

/// For each lane what waits: references, and where the ray enters.
type Stacks = [[(u32, f32); BVH2_STACK]; 8];

impl Searcher<Shear> for LaneTree {
    #[inline(always)]
    fn search<S: Variant<Ray = Shear>, T>(
        &self,
        masks: &Masks,
        part: Part<'_, T>,
        account: &S::Account,
        mut keep: impl FnMut(&T, Hit, S::Account),
    ) -> usize {
        let mut stacks = [[(0, 0.0); BVH2_STACK]; 8];
        for first in (0..part.len()).step_by(Self::WIDTH) {
            let mut group = Group::<S, T, 8>::new(&part, first, account, masks);
            let working = group.working();
            #[cfg(target_arch = "x86_64")]
            if S::AVX2 {
                Lockstep::<Avx2, S>::new(&self.0, &mut group.queries, &mut stacks).walk(working);
                group.keep(&mut keep);
                continue;
            }
            Lockstep::<Portable, S>::new(&self.0, &mut group.queries, &mut stacks).walk(working);
            group.keep(&mut keep);
        }
        part.len()
    }
}

/// Eight rays on their way.
struct Lockstep<'a, 'm, V: Vector, S: Variant> {
    tree: &'a BinaryTree,
    queries: &'a mut [Query<'m, S>; 8],
    stacks: &'a mut Stacks,
    boxes: BoxLanes<V>,
    triangles: ShearLanes<V>,
    /// Per lane how many wait, where it is (of a leaf what is left), and beyond what it need not look.
    waiting: [usize; 8],
    current: [u32; 8],
    limit: [f32; 8],
    /// Lanes at a node, and in a leaf.
    nodes: u32,
    leaves: u32,
}

impl<'a, 'm, V: Vector, S: Variant<Ray = Shear>> Lockstep<'a, 'm, V, S> {
    #[inline(always)]
    fn new(tree: &'a BinaryTree, queries: &'a mut [Query<'m, S>; 8], stacks: &'a mut Stacks) -> Self {
        Self {
            boxes: BoxLanes::new(queries.each_ref()),
            triangles: ShearLanes::new(queries.each_ref().map(Query::triangle_ray)),
            waiting: [0; 8],
            current: [tree.root(); 8],
            limit: queries.each_ref().map(Query::limit),
            nodes: 0,
            leaves: 0,
            tree,
            queries,
            stacks,
        }
    }

    #[inline(always)]
    fn walk(&mut self, working: u32) {
        for lane in lanes_of(working) {
            self.arrive(lane, self.tree.root());
        }
        while self.nodes | self.leaves != 0 {
            while self.nodes != 0 {
                self.visit_nodes();
            }
            while self.leaves != 0 {
                self.test_triangles();
            }
        }
    }

    /// A lane is at a node or in a leaf.
    #[inline(always)]
    fn arrive(&mut self, lane: usize, reference: u32) {
        self.current[lane] = reference;
        let is_node = u32::from(BinaryTree::leaf(reference).0 == 0);
        self.nodes |= is_node << lane;
        self.leaves |= (1 - is_node) << lane;
    }

    /// A lane goes on with what waits and is not beyond its limit, or is done.
    #[inline(always)]
    fn pop(&mut self, lane: usize) {
        while self.waiting[lane] > 0 {
            self.waiting[lane] -= 1;
            let (reference, near) = self.stacks[lane][self.waiting[lane] % BVH2_STACK];
            if near <= self.limit[lane] {
                return self.arrive(lane, reference);
            }
        }
    }

    #[inline(always)]
    fn visit_nodes(&mut self) {
        let nodes = std::mem::take(&mut self.nodes);
        self.queries[0].step();
        // Lanes that wait look at any pair.
        let place = |lane: usize| if nodes >> lane & 1 == 1 { self.current[lane] as usize } else { 0 };
        let pairs = std::array::from_fn(|lane| self.tree.pair(place(lane)));
        let [x, y, z] = [0, 1, 2].map(|axis| pairs.map(|pair| &pair.planes[axis]));
        let (x, y, z) = (V::columns(x), V::columns(y), V::columns(z));
        let (limit, padding) = (V::load(&self.limit), self.queries[0].padding());
        let first = [[x[0], x[2]], [y[0], y[2]], [z[0], z[2]]];
        let second = [[x[1], x[3]], [y[1], y[3]], [z[1], z[3]]];
        let (near_first, hits_first) = self.boxes.enter(first, limit, padding);
        let (near_second, hits_second) = self.boxes.enter(second, limit, padding);
        let is_second_nearer = !near_first.le(near_second);
        let goes_second = hits_second & (is_second_nearer | !hits_first);
        let near = [near_first.store(), near_second.store()];
        for lane in lanes_of(nodes) {
            self.queries[lane].visit(self.current[lane] as usize);
            let is = |bits: u32| (bits >> lane & 1) as usize;
            if is(hits_first | hits_second) == 0 {
                self.pop(lane);
                continue;
            }
            let [next, other] = [is(goes_second), 1 - is(goes_second)];
            // The depth was checked when the tree was built; the remainder only saves a check.
            self.stacks[lane][self.waiting[lane] % BVH2_STACK] =
                (pairs[lane].references[other], near[other][lane]);
            self.waiting[lane] += is(hits_first & hits_second);
            self.arrive(lane, pairs[lane].references[next]);
        }
    }

    /// One triangle of each lane's leaf.
    #[inline(always)]
    fn test_triangles(&mut self) {
        let leaves = std::mem::take(&mut self.leaves);
        self.queries[0].step();
        // Lanes that wait look at any triangle.
        let place = |lane: usize| {
            if leaves >> lane & 1 == 1 { BinaryTree::leaf(self.current[lane]).1 } else { 0 }
        };
        let leaf = std::array::from_fn::<_, 8, _>(|lane| self.tree.triangle(place(lane)));
        let axes = self.triangles.axes();
        let row = |axis: usize, lane: usize| leaf[lane].row(axes[axis][lane] as usize);
        let [x, y, z] = [0, 1, 2].map(|axis| std::array::from_fn(|lane| row(axis, lane)));
        let (x, y, z) = (V::columns(x), V::columns(y), V::columns(z));
        let corners = [[x[0], y[0], z[0]], [x[1], y[1], z[1]], [x[2], y[2], z[2]]];
        let candidates = self.triangles.candidates(corners, V::load(&self.limit));
        let mut ended = 0;
        for lane in lanes_of(leaves) {
            self.queries[lane].visit_leaf(BinaryTree::leaf(self.current[lane]).1, || 1);
            if candidates >> lane & 1 == 1 {
                ended |= u32::from(self.queries[lane].test(leaf[lane])) << lane;
                self.limit[lane] = self.queries[lane].limit();
            }
        }
        for lane in lanes_of(leaves & !ended) {
            match BinaryTree::rest(self.current[lane]) {
                Some(rest) => self.arrive(lane, rest),
                None => self.pop(lane),
            }
        }
    }
}
