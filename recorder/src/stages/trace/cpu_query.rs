//! A ray on its way through a hierarchy on a thread: what both traversals ask of it.

use formats::ray::{Hit, Ray, Work};

use super::mask::Masks;
use super::triangle::{LeafTriangle, TriangleRay};
use super::{BoxTest, farthest, reciprocal};

/// What is kept of a ray's way beside its hit; nothing where rates are measured.
pub(super) trait Account {
    /// The children of a node are tested.
    fn node(&mut self, index: usize);
    /// The triangle in a leaf slot is tested.
    fn triangle(&mut self, slot: usize);
}

impl Account for () {
    #[inline(always)]
    fn node(&mut self, _index: usize) {}

    #[inline(always)]
    fn triangle(&mut self, _slot: usize) {}
}

impl Account for Work {
    #[inline(always)]
    fn node(&mut self, _index: usize) {
        self.nodes += 1;
    }

    #[inline(always)]
    fn triangle(&mut self, _slot: usize) {
        self.triangles += 1;
    }
}

/// What a ray reads on its way.
#[derive(Clone, Debug)]
pub struct Trail {
    node_bytes: usize,
    /// Address and bytes of each read, in order. Triangles lie far behind all nodes.
    pub reads: Vec<(u64, u32)>,
}

/// Where the triangles start in the addresses of a [`Trail`].
const TRIANGLES_START: u64 = 1 << 40;

impl Trail {
    /// Of a ray that has read nothing yet.
    pub(super) fn new(node_bytes: usize) -> Self {
        Self { node_bytes, reads: Vec::new() }
    }
}

impl Account for Trail {
    fn node(&mut self, index: usize) {
        self.reads.push(((index * self.node_bytes) as u64, self.node_bytes as u32));
    }

    fn triangle(&mut self, slot: usize) {
        let bytes = size_of::<LeafTriangle>();
        self.reads.push((TRIANGLES_START + (slot * bytes) as u64, bytes as u32));
    }
}

/// A ray on its way through a hierarchy, and what it has found.
///
/// `R`: triangle test. `PADDED`: see [`BoxTest`]. `ANY`: ends at the first hit. `MASKS`: looks for holes.
pub(super) struct Query<
    'a,
    A: Account,
    R: TriangleRay,
    const PADDED: bool,
    const ANY: bool,
    const MASKS: bool,
> {
    /// Where the ray starts.
    pub origin: [f32; 3],
    /// Reciprocals of its direction.
    pub inverse: [f32; 3],
    /// Nearest distance that counts.
    pub t_min: f32,
    triangle_ray: R,
    best: Hit,
    account: A,
    triangles: &'a [LeafTriangle],
    masks: &'a Masks,
}

impl<'a, A: Account, R: TriangleRay, const PADDED: bool, const ANY: bool, const MASKS: bool>
    Query<'a, A, R, PADDED, ANY, MASKS>
{
    #[inline(always)]
    pub(super) fn new(ray: &Ray, account: A, triangles: &'a [LeafTriangle], masks: &'a Masks) -> Self {
        Self {
            origin: ray.origin,
            inverse: ray.direction.map(reciprocal),
            t_min: ray.t_min,
            triangle_ray: R::new(ray),
            best: Hit { t: farthest(ray), ..Hit::MISS },
            account,
            triangles,
            masks,
        }
    }

    /// The factor on far planes and on the nearest hit.
    #[inline(always)]
    pub(super) const fn padding(&self) -> f32 {
        if PADDED { BoxTest::Padded } else { BoxTest::Plain }.padding()
    }

    /// Boxes beyond this distance need not be entered.
    #[inline(always)]
    pub(super) fn limit(&self) -> f32 {
        self.best.t * self.padding()
    }

    /// Counts a node whose children are tested.
    #[inline(always)]
    pub(super) fn visit(&mut self, index: usize) {
        self.account.node(index);
    }

    /// Tests the triangle in a leaf slot; true if the search is over.
    #[inline(always)]
    pub(super) fn test(&mut self, slot: usize) -> bool {
        let leaf = &self.triangles[slot];
        self.account.triangle(slot);
        let Some(at) = self.triangle_ray.intersect(leaf) else {
            return false;
        };
        let triangle = leaf.triangle();
        let is_nearer = at.t < self.best.t || (at.t == self.best.t && triangle < self.best.triangle);
        if !(at.t >= self.t_min && is_nearer) {
            return false;
        }
        if MASKS && leaf.mask() != 0 && self.masks.is_hole(leaf.mask(), at.u, at.v) {
            return false;
        }
        // No distance is negative here, but it may be a negative zero.
        self.best = Hit { t: at.t.abs(), triangle, u: at.u, v: at.v };
        ANY
    }

    #[inline(always)]
    pub(super) fn result(self) -> (Hit, A) {
        (if self.best.is_hit() { self.best } else { Hit::MISS }, self.account)
    }
}
