//! Trace: the nearest hit of each ray of a queue, or for shadow rays any hit.
//!
//! Three hierarchies ([`scenes::bvh`]) and two backends follow the same arithmetic, so that on devices
//! whose self-check finds rays and keys exact nearest hits are equal bit for bit, and with the same hierarchy what
//! blocks a shadow ray and the work counters are, too, but for `packet`, which has an order of its own. A ray's
//! result depends on that ray alone, also where others are traced with it.
//!
//! **Ray.** Per axis the reciprocal `i = 1/d` if |d| > 2^-80, else 2^80 with the sign bit of `d`:
//! with coordinates up to [`scenes::bvh::COORDINATE_LIMIT`] and origins up to [`formats::ray::ORIGIN_LIMIT`] no NaN
//! arises in a box test.
//!
//! **Boxes.** Slabs in the form `(b − o)·i`: a difference of two floats has the right sign and is
//! monotonic, and the form leaves nothing to contract. `near = max(t_min, near planes)`,
//! `far = min(far planes)·`[`PADDING`], in the wide hierarchy with the padding in the far planes' reciprocals:
//! `(b − o)·(i·PADDING)`. A box is entered if `near <= min(far, t·PADDING)` with `t` the
//! nearest hit so far, at first `t_max`. So boxes at equal `t` are still entered (ties), and the
//! rounding of all of the above and of the triangle test is covered (Ize 2013, "Robust BVH Ray
//! Traversal"; errors that grow with a triangle and not with its distance are covered by the
//! padding of the boxes themselves). In compressed wide nodes the grid is scaled instead of the
//! planes, by powers of two and therefore exactly: `(q − (o − p)/step)·(i·step)`.
//!
//! **Order.** Binary: the nearer child first, the first at equal distance; the other one waits on
//! the stack with its distance and is dropped if a nearer hit has been found meanwhile. Compressed: the
//! triangles of a node first, the last slot first, then the inner children in descending order of
//! `slot ^ octant`. Wide, on threads alone: eight boxes in f32 at a time, the nearest child first, the others
//! wait and are dropped as in the binary one; triangles in blocks of four, of which those whose signs allow a
//! hit are tested by themselves. Shadow rays visit first what is expected to cost least. On threads alone, too, several
//! rays together over the binary one: `lanes` keeps each ray's own order; `packet` goes where most rays are nearer, and
//! with shadow rays to the smaller box.
//!
//! **Triangles.** Woop, Benthin and Wald 2013, "Watertight Ray/Triangle Intersection", without
//! culling: see [`formats::intersect`]. `t_min <= t <= t_max` counts as a hit, both ends included, if t is
//! finite. Of equal t the lowest triangle index wins. Edges belong to both of their triangles.
//!
//! **Alpha masks.** Where a scene has them (a const generic, a variant of the WGSL), a hit in a hole
//! is no hit: see [`mask`].
//!
//! **Shadow rays** end at the first hit that the order above comes upon; its `t` is the result,
//! `+inf` if there is none.
//!
//! **Work.** `nodes` counts the nodes whose children were tested (a leaf or a single-leaf tree
//! counts none), `triangles` the triangle tests.

pub mod cpu;
mod cpu_bundle;
mod cpu_bvh2;
mod cpu_cwbvh;
mod cpu_group;
mod cpu_lanes;
mod cpu_packet;
mod cpu_part;
mod cpu_query;
pub mod cpu_strangers;
mod cpu_vector;
mod cpu_wide;
mod driver;
pub mod gpu;
pub mod hits;
mod leaves;
pub mod mask;
pub mod moeller_trumbore;
pub mod triangle;
pub mod variant;

#[cfg(test)]
mod tests;

use formats::intersect::PADDING;
use scenes::Scene;
use scenes::bvh::{Bvh, BvhError, BvhKind, Source};

pub use self::leaves::LeafForm;

/// How triangles are tested.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TriangleTest {
    /// Woop, Benthin and Wald 2013: see [`formats::intersect`].
    #[default]
    Watertight,
    /// Möller and Trumbore 1997: see [`moeller_trumbore`]. Loses rays at edges; to be measured against.
    MoellerTrumbore,
}

/// How boxes are tested.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BoxTest {
    /// Far planes and the nearest hit are scaled by [`PADDING`].
    #[default]
    Padded,
    /// They are as they are rounded; to be measured against.
    Plain,
}

/// How carefully rays are traced: the defaults, unless what they cost and save is to be measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Precision {
    /// Triangle test.
    pub triangles: TriangleTest,
    /// Box test.
    pub boxes: BoxTest,
}

impl Precision {
    /// All combinations, the default first.
    pub const ALL: [Self; 4] = [
        Self { triangles: TriangleTest::Watertight, boxes: BoxTest::Padded },
        Self { triangles: TriangleTest::Watertight, boxes: BoxTest::Plain },
        Self { triangles: TriangleTest::MoellerTrumbore, boxes: BoxTest::Padded },
        Self { triangles: TriangleTest::MoellerTrumbore, boxes: BoxTest::Plain },
    ];
}

impl TriangleTest {
    /// Name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Watertight => "watertight",
            Self::MoellerTrumbore => "moeller-trumbore",
        }
    }
}

impl BoxTest {
    /// Name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Padded => "padded",
            Self::Plain => "plain",
        }
    }

    /// The factor on far planes and on the nearest hit.
    pub const fn padding(self) -> f32 {
        match self {
            Self::Padded => PADDING,
            Self::Plain => 1.0,
        }
    }
}

/// The order in which rays are traced. `P` is a permutation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order<P> {
    /// As they lie, results likewise.
    Stored,
    /// The i-th ray to trace, and its result, lie at place `permutation[i]`.
    Indirect(P),
}

impl<P> Order<P> {
    /// The same order by another form of its permutation.
    pub fn map<Q>(self, form: impl FnOnce(P) -> Q) -> Order<Q> {
        match self {
            Self::Stored => Order::Stored,
            Self::Indirect(permutation) => Order::Indirect(form(permutation)),
        }
    }
}

/// What walks which hierarchy.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum TraceKernel {
    /// Eight-wide hierarchy with boxes in f32, on threads.
    Wide,
    /// Eight-wide compressed hierarchy (Ylitie et al. 2017).
    Cwbvh,
    /// Binary hierarchy.
    Bvh2,
    /// Eight rays in lockstep over the binary hierarchy, as a GPU's subgroup traces them, on threads.
    Lanes,
    /// Sixteen rays that share one traversal of the binary hierarchy, on threads.
    Packet,
    /// The driver's own, on GPUs that offer ray queries.
    RayQuery,
}

impl TraceKernel {
    /// Name on the command line and in recordings, the hierarchy that it walks, and how it does so on the GPU.
    fn row(self) -> (&'static str, Option<BvhKind>, Option<&'static str>) {
        match self {
            Self::Wide => ("wide", Some(BvhKind::Wide), None),
            Self::Cwbvh => ("cwbvh", Some(BvhKind::Cwbvh), Some(include_str!("cwbvh.wgsl"))),
            Self::Bvh2 => ("bvh2", Some(BvhKind::Bvh2), Some(include_str!("bvh2.wgsl"))),
            Self::Lanes => ("lanes", Some(BvhKind::Bvh2), None),
            Self::Packet => ("packet", Some(BvhKind::Bvh2), None),
            Self::RayQuery => ("ray-query", None, Some(include_str!("ray_query.wgsl"))),
        }
    }

    /// Name on the command line and in recordings.
    pub fn name(self) -> &'static str {
        self.row().0
    }

    /// The hierarchy that it walks; `ray-query` has the driver's own.
    pub fn bvh_kind(self) -> Option<BvhKind> {
        self.row().1
    }

    /// Whether it is ours: counts what it visits and finds the same on all devices, as the driver's does not.
    pub fn is_ours(self) -> bool {
        self.bvh_kind().is_some()
    }

    /// Whether GPUs have it.
    pub fn is_for_gpus(self) -> bool {
        self.wgsl().is_some()
    }

    /// `fn traverse(query: ptr<function, Query>)` over the hierarchy, where it is for GPUs.
    pub(super) fn wgsl(self) -> Option<&'static str> {
        self.row().2
    }

    /// A scene's hierarchy, from the cache where it is there, and where it came from.
    ///
    /// # Errors
    /// If it cannot be built.
    pub fn hierarchy(self, scene: &Scene) -> Result<Option<(Bvh, Source)>, BvhError> {
        let folder = scenes::bvh::default_cache_folder();
        let load = |kind| scenes::bvh::load_or_build(scene, kind, folder.as_deref());
        self.bvh_kind().map(load).transpose()
    }
}
