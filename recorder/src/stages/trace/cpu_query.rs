//! A ray on its way through a hierarchy on a thread: what all traversals ask of it.

use std::marker::PhantomData;

use formats::intersect::{Intersection, farthest, reciprocal};
use formats::ray::{Hit, Ray, Work};

use super::BoxTest;
use super::cpu_part::Part;
use super::mask::Masks;
use super::triangle::{LeafTriangle, TriangleBlock, TriangleRay};

/// What is kept of a ray's way beside its hit; nothing where rates are measured.
pub(super) trait Account: Clone {
    /// Whether anything is.
    const IS_KEPT: bool = true;
    /// The children of a node are tested.
    fn node(&mut self, index: usize);
    /// Triangles that lie together at a place among the leaves are tested.
    fn leaf(&mut self, place: usize, triangles: impl Fn() -> u32);
    /// All rays that are traced together do a step, those that wait, too; one of them counts it.
    #[inline(always)]
    fn step(&mut self) {}
}

impl Account for () {
    const IS_KEPT: bool = false;

    #[inline(always)]
    fn node(&mut self, _index: usize) {}

    #[inline(always)]
    fn leaf(&mut self, _place: usize, _triangles: impl Fn() -> u32) {}
}

impl Account for Work {
    #[inline(always)]
    fn node(&mut self, _index: usize) {
        self.nodes += 1;
    }

    #[inline(always)]
    fn leaf(&mut self, _place: usize, triangles: impl Fn() -> u32) {
        self.triangles += triangles();
    }
}

/// What a ray does by itself, and the steps of its group that it counts for all.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Steps {
    pub(super) own: u64,
    pub(super) together: u64,
}

impl Account for Steps {
    #[inline(always)]
    fn node(&mut self, _index: usize) {
        self.own += 1;
    }

    #[inline(always)]
    fn leaf(&mut self, _place: usize, triangles: impl Fn() -> u32) {
        self.own += u64::from(triangles());
    }

    #[inline(always)]
    fn step(&mut self) {
        self.together += 1;
    }
}

/// What a ray reads on its way.
#[derive(Clone, Debug)]
pub struct Trail {
    node_bytes: usize,
    leaf_bytes: usize,
    /// Address and bytes of each read, in order. Triangles lie far behind all nodes.
    pub reads: Vec<(u64, u32)>,
}

/// Where the triangles start in the addresses of a [`Trail`].
const TRIANGLES_START: u64 = 1 << 40;

impl Trail {
    /// Of a ray that has read nothing yet, of nodes and leaves of so many bytes.
    pub(super) fn new([node_bytes, leaf_bytes]: [usize; 2]) -> Self {
        Self { node_bytes, leaf_bytes, reads: Vec::new() }
    }
}

impl Account for Trail {
    fn node(&mut self, index: usize) {
        self.reads.push(((index * self.node_bytes) as u64, self.node_bytes as u32));
    }

    fn leaf(&mut self, place: usize, _triangles: impl Fn() -> u32) {
        self.reads.push((TRIANGLES_START + (place * self.leaf_bytes) as u64, self.leaf_bytes as u32));
    }
}

/// What a search is compiled for, so that it looks at nothing that it need not; `S` where a type has one.
pub(super) trait Variant {
    /// What is kept of a ray's way.
    type Account: Account;
    /// The triangle test.
    type Ray: TriangleRay;
    /// Whether boxes are padded: see [`BoxTest`].
    const PADDED: bool;
    /// Whether the search ends at the first hit.
    const ANY: bool;
    /// Whether triangles may have holes.
    const MASKS: bool;
    /// Whether the caller has AVX2 and what comes with it; the results are the same.
    const AVX2: bool;
}

/// The [`Variant`] with these answers.
pub(super) struct Compiled<A, R, const PADDED: bool, const ANY: bool, const MASKS: bool, const AVX2: bool>(
    PhantomData<(A, R)>,
);

impl<A: Account, R: TriangleRay, const PADDED: bool, const ANY: bool, const MASKS: bool, const AVX2: bool>
    Variant for Compiled<A, R, PADDED, ANY, MASKS, AVX2>
{
    type Account = A;
    type Ray = R;
    const PADDED: bool = PADDED;
    const ANY: bool = ANY;
    const MASKS: bool = MASKS;
    const AVX2: bool = AVX2;
}

/// A ray on its way through a hierarchy, and what it has found.
pub(super) struct Query<'a, S: Variant> {
    /// Where the ray starts.
    pub origin: [f32; 3],
    /// Reciprocals of its direction.
    pub inverse: [f32; 3],
    /// Nearest distance that counts.
    pub t_min: f32,
    triangle_ray: S::Ray,
    best: Hit,
    account: S::Account,
    masks: &'a Masks,
}

impl<'a, S: Variant> Query<'a, S> {
    #[inline(always)]
    pub(super) fn new(ray: &Ray, account: S::Account, masks: &'a Masks) -> Self {
        let inverse = ray.direction.map(reciprocal);
        Self {
            origin: ray.origin,
            inverse,
            t_min: ray.t_min,
            triangle_ray: S::Ray::new(ray, inverse),
            best: Hit { t: farthest(ray), ..Hit::MISS },
            account,
            masks,
        }
    }

    /// The factor on far planes and on the nearest hit.
    #[inline(always)]
    pub(super) const fn padding(&self) -> f32 {
        if S::PADDED { BoxTest::Padded } else { BoxTest::Plain }.padding()
    }

    /// Boxes beyond this distance need not be entered.
    #[inline(always)]
    pub(super) fn limit(&self) -> f32 {
        self.best.t * self.padding()
    }

    /// Counts a step of all rays that are traced together with this one.
    #[inline(always)]
    pub(super) fn step(&mut self) {
        self.account.step();
    }

    /// As triangle tests take the ray.
    #[inline(always)]
    pub(super) fn triangle_ray(&self) -> &S::Ray {
        &self.triangle_ray
    }

    /// Counts a node whose children are tested.
    #[inline(always)]
    pub(super) fn visit(&mut self, index: usize) {
        self.account.node(index);
    }

    /// Bit `lane` set for each triangle of a block that may be hit.
    #[inline(always)]
    pub(super) fn candidates(&self, block: &TriangleBlock) -> u32 {
        self.triangle_ray.candidates(block, self.best.t)
    }

    /// Counts triangles that lie together at a place among the leaves.
    #[inline(always)]
    pub(super) fn visit_leaf(&mut self, place: usize, triangles: impl Fn() -> u32) {
        self.account.leaf(place, triangles);
    }

    /// Number of a triangle's alpha mask; 0 if it has none.
    #[inline(always)]
    pub(super) fn mask(&self, triangle: u32) -> u32 {
        if S::MASKS { self.masks.number(triangle) } else { 0 }
    }

    /// Tests a triangle; true if the search is over.
    #[inline(always)]
    pub(super) fn test(&mut self, leaf: &LeafTriangle) -> bool {
        let at = self.triangle_ray.intersect(leaf);
        at.filter(|at| self.is_better(leaf, at.t)).is_some_and(|at| self.keep(leaf, at))
    }

    /// The same for a triangle of which [`Query::candidates`] has a bit: weights are made of hits that count, and
    /// where any hit will do, only for holes.
    #[inline(always)]
    pub(super) fn test_candidate(&mut self, leaf: &LeafTriangle) -> bool {
        let counts = |t| self.is_better(leaf, t);
        let at = match S::MASKS || !S::ANY {
            true => self.triangle_ray.confirm::<true>(leaf, counts),
            false => self.triangle_ray.confirm::<false>(leaf, counts),
        };
        at.is_some_and(|at| self.keep(leaf, at))
    }

    /// Whether a hit at that distance is the best so far.
    #[inline(always)]
    fn is_better(&self, leaf: &LeafTriangle, t: f32) -> bool {
        let is_nearer = t < self.best.t || (t == self.best.t && leaf.triangle() < self.best.triangle);
        t >= self.t_min && is_nearer
    }

    /// Takes a hit that is better, unless it is in a hole; true if the search is over.
    #[inline(always)]
    fn keep(&mut self, leaf: &LeafTriangle, at: Intersection) -> bool {
        if S::MASKS && leaf.mask() != 0 && self.masks.is_hole(leaf.mask(), at.u, at.v) {
            return false;
        }
        // No distance is negative here, but it may be a negative zero.
        self.best = Hit { t: at.t.abs(), triangle: leaf.triangle(), u: at.u, v: at.v };
        S::ANY
    }

    #[inline(always)]
    pub(super) fn result(self) -> (Hit, S::Account) {
        (if self.best.is_hit() { self.best } else { Hit::MISS }, self.account)
    }
}

/// A hierarchy with its triangles.
pub(super) trait Tree: Sync {
    /// Bytes that visiting a node reads, and what lies together in a leaf.
    const BYTES: [usize; 2];

    /// What waits to be visited: room for as much as the hierarchy's depth makes possible.
    type Stack;

    /// A stack; what it holds matters to none.
    fn stack() -> Self::Stack;

    /// Finds what the query asks for.
    fn traverse<S: Variant>(&self, query: &mut Query<'_, S>, stack: &mut Self::Stack);
}

/// Traces the rays of a part by a triangle test `R`: each by itself through a [`Tree`], or several at once.
pub(super) trait Searcher<R: TriangleRay>: Sync {
    /// Finds what each ray asks for, most often all of the part, and gives how many those were; `keep` takes the place
    /// of a ray's result, its hit and its account.
    fn search<S: Variant<Ray = R>, T>(
        &self,
        masks: &Masks,
        part: Part<'_, T>,
        account: &S::Account,
        keep: impl FnMut(&T, Hit, S::Account),
    ) -> usize;
}

impl<H: Tree, R: TriangleRay> Searcher<R> for H {
    #[inline(always)]
    fn search<S: Variant<Ray = R>, T>(
        &self,
        masks: &Masks,
        part: Part<'_, T>,
        account: &S::Account,
        mut keep: impl FnMut(&T, Hit, S::Account),
    ) -> usize {
        let mut stack = H::stack();
        for at in 0..part.len() {
            let (ray, place) = part.get(at);
            let mut query = Query::<S>::new(ray, account.clone(), masks);
            self.traverse(&mut query, &mut stack);
            let (hit, account) = query.result();
            keep(place, hit, account);
        }
        part.len()
    }
}
