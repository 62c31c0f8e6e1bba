//! Trace on threads: the same arithmetic as the WGSL kernels, with AVX2 for the box tests where
//! the processor has it.

use std::sync::atomic::{AtomicU32, AtomicU64, Ordering::Relaxed};

use formats::ray::{Hit, Kind, Ray, Work};
use rayon::prelude::*;
use scenes::Scene;
use scenes::bvh::Bvh;
use scenes::features::Features;

use super::cpu_bvh2::BinaryTree;
use super::cpu_cwbvh::CompressedTree;
use super::cpu_query::{Account, Query, Trail, Tree};
use super::cpu_wide::WideTree;
use super::hits::{Hits, store};
use super::mask::Masks;
use super::moeller_trumbore::PlainRay;
use super::triangle::{LeafTriangle, Shear, TriangleRay};
use super::{BoxTest, Order, Precision, TriangleTest};
use crate::stages::prefetch::prefetch;

/// Rays that a thread takes at once, and no more: in a sorted order whole stretches cost many times as much as
/// others, and what a thread has begun no other one can take over.
const CHUNK: usize = 256;

/// Traces rays through a hierarchy on the threads of the current rayon pool.
#[derive(Clone, Debug)]
pub struct CpuTracer {
    tree: AnyTree,
    masks: Masks,
    instructions: Instructions,
    precision: Precision,
}

#[derive(Clone, Debug)]
enum AnyTree {
    Binary(BinaryTree),
    Compressed(CompressedTree),
    Wide(WideTree),
}

/// Which instructions the box tests use; the results are the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Instructions {
    Portable,
    #[cfg(target_arch = "x86_64")]
    Avx2,
}

impl Instructions {
    fn best() -> Self {
        #[cfg(target_arch = "x86_64")]
        if is_x86_feature_detected!("avx2")
            && is_x86_feature_detected!("bmi1")
            && is_x86_feature_detected!("bmi2")
            && is_x86_feature_detected!("lzcnt")
            && is_x86_feature_detected!("popcnt")
        {
            return Self::Avx2;
        }
        Self::Portable
    }
}

impl CpuTracer {
    /// A tracer for a scene and a hierarchy that was built over it; both are copied.
    pub fn new(scene: &Scene, bvh: &Bvh) -> Self {
        Self::for_features(scene, bvh, &Features::of(scene))
    }

    /// The same, specialised for features that the scene has or might have.
    pub fn for_features(scene: &Scene, bvh: &Bvh, features: &Features) -> Self {
        let masks = Masks::for_features(scene, features);
        let leaf = |&triangle: &u32| {
            LeafTriangle::new(&scene.corners(triangle as usize), triangle, masks.number(triangle))
        };
        let triangles: Vec<_> = bvh.order().par_iter().map(leaf).collect();
        let tree = match bvh {
            Bvh::Bvh2 { nodes, .. } => AnyTree::Binary(BinaryTree::new(nodes, triangles)),
            Bvh::Cwbvh { nodes, .. } => AnyTree::Compressed(CompressedTree::new(nodes, triangles)),
            Bvh::Wide { nodes, .. } => AnyTree::Wide(WideTree::new(nodes, &triangles)),
        };
        let instructions = Instructions::best();
        Self { tree, masks, instructions, precision: Precision::default() }
    }

    /// The same with other tests of triangles and boxes for the nearest hit; shadow rays, work and trails stay
    /// with the defaults.
    #[must_use]
    pub fn with_precision(self, precision: Precision) -> Self {
        Self { precision, ..self }
    }

    /// The same tracer without special instructions: results are the same.
    #[cfg(test)]
    pub(super) fn portable(mut self) -> Self {
        self.instructions = Instructions::Portable;
        self
    }

    /// Traces rays of the kind that the results are of, the nearest hit of each or any.
    ///
    /// # Panics
    /// If there are not as many results or places as rays.
    pub fn trace(&self, rays: &[Ray], order: Order<&[AtomicU32]>, hits: &Hits) {
        match hits {
            Hits::Closest(hits) => {
                let keep = |place: &[AtomicU64; 2], hit, ()| store(place, hit);
                for_each_part(rays, order, hits, |part| self.nearest(part, keep));
            }
            Hits::Shadow(distances) => {
                let keep = |place: &AtomicU32, hit: Hit, ()| place.store(hit.t.to_bits(), Relaxed);
                for_each_part(rays, order, distances, |part| {
                    self.search::<_, Shear, _, true, true>(part, &(), keep)
                });
            }
        }
    }

    /// What tracing each ray takes.
    pub fn work(&self, rays: &[Ray], kind: Kind) -> Vec<Work> {
        rays.par_chunks(CHUNK).flat_map_iter(|rays| self.accounts(rays, kind, &Work::default())).collect()
    }

    /// What tracing a ray reads, step by step.
    pub fn trail(&self, ray: &Ray, kind: Kind) -> Trail {
        let trail = Trail::new(match &self.tree {
            AnyTree::Binary(_) => BinaryTree::BYTES,
            AnyTree::Compressed(_) => CompressedTree::BYTES,
            AnyTree::Wide(_) => WideTree::BYTES,
        });
        self.accounts(std::slice::from_ref(ray), kind, &trail).pop().unwrap_or(trail)
    }

    /// What is kept of each ray's way beside its hit.
    fn accounts<A: Account>(&self, rays: &[Ray], kind: Kind, account: &A) -> Vec<A> {
        let mut accounts = Vec::with_capacity(rays.len());
        let part = Part { rays, order: Order::Stored, results: &vec![(); rays.len()] };
        let keep = |(): &(), _, account| accounts.push(account);
        match kind {
            Kind::Closest => self.search::<_, Shear, _, true, false>(part, account, keep),
            Kind::Shadow => self.search::<_, Shear, _, true, true>(part, account, keep),
        }
        accounts
    }

    fn nearest<T>(&self, part: Part<'_, T>, keep: impl FnMut(&T, Hit, ())) {
        let Precision { triangles, boxes } = self.precision;
        match (triangles, boxes) {
            (TriangleTest::Watertight, BoxTest::Padded) => {
                self.search::<_, Shear, _, true, false>(part, &(), keep)
            }
            (TriangleTest::Watertight, BoxTest::Plain) => {
                self.search::<_, Shear, _, false, false>(part, &(), keep)
            }
            (TriangleTest::MoellerTrumbore, BoxTest::Padded) => {
                self.search::<_, PlainRay, _, true, false>(part, &(), keep);
            }
            (TriangleTest::MoellerTrumbore, BoxTest::Plain) => {
                self.search::<_, PlainRay, _, false, false>(part, &(), keep);
            }
        }
    }

    /// Traces some rays; `keep` takes the place of a ray's result, its hit and its account.
    fn search<A: Account, R: TriangleRay, T, const PADDED: bool, const ANY: bool>(
        &self,
        part: Part<'_, T>,
        account: &A,
        keep: impl FnMut(&T, Hit, A),
    ) {
        match &self.tree {
            AnyTree::Binary(tree) => self.search_in::<_, A, R, T, PADDED, ANY>(tree, part, account, keep),
            AnyTree::Compressed(tree) => self.search_in::<_, A, R, T, PADDED, ANY>(tree, part, account, keep),
            AnyTree::Wide(tree) => self.search_in::<_, A, R, T, PADDED, ANY>(tree, part, account, keep),
        }
    }

    fn search_in<H: Tree, A: Account, R: TriangleRay, T, const PADDED: bool, const ANY: bool>(
        &self,
        tree: &H,
        part: Part<'_, T>,
        account: &A,
        keep: impl FnMut(&T, Hit, A),
    ) {
        let masks = &self.masks;
        match (self.instructions, masks.is_empty()) {
            (Instructions::Portable, true) => {
                search_part::<H, A, R, T, PADDED, ANY, false, false>(tree, masks, part, account, keep);
            }
            (Instructions::Portable, false) => {
                search_part::<H, A, R, T, PADDED, ANY, true, false>(tree, masks, part, account, keep);
            }
            #[cfg(target_arch = "x86_64")]
            // SAFETY: this variant is made where the processor has these instructions.
            (Instructions::Avx2, true) => unsafe {
                search_avx2::<H, A, R, T, PADDED, ANY, false>(tree, masks, part, account, keep);
            },
            #[cfg(target_arch = "x86_64")]
            // SAFETY: as above.
            (Instructions::Avx2, false) => unsafe {
                search_avx2::<H, A, R, T, PADDED, ANY, true>(tree, masks, part, account, keep);
            },
        }
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
fn search_avx2<
    H: Tree,
    A: Account,
    R: TriangleRay,
    T,
    const PADDED: bool,
    const ANY: bool,
    const MASKS: bool,
>(
    tree: &H,
    masks: &Masks,
    part: Part<'_, T>,
    account: &A,
    keep: impl FnMut(&T, Hit, A),
) {
    search_part::<H, A, R, T, PADDED, ANY, MASKS, true>(tree, masks, part, account, keep);
}

#[inline(always)]
fn search_part<
    H: Tree,
    A: Account,
    R: TriangleRay,
    T,
    const PADDED: bool,
    const ANY: bool,
    const MASKS: bool,
    const AVX2: bool,
>(
    tree: &H,
    masks: &Masks,
    part: Part<'_, T>,
    account: &A,
    mut keep: impl FnMut(&T, Hit, A),
) {
    let mut stack = H::stack();
    for at in 0..part.len() {
        let (ray, place) = part.get(at);
        let mut query = Query::<A, R, PADDED, ANY, MASKS>::new(ray, account.clone(), masks);
        tree.traverse::<A, R, PADDED, ANY, MASKS, AVX2>(&mut query, &mut stack);
        let (hit, account) = query.result();
        keep(place, hit, account);
    }
}

/// How many rays ahead a ray is asked for that lies elsewhere: one takes about as long as a miss.
const RAYS_AHEAD: usize = 2;

/// Rays that one thread traces one after the other, and the places of their results.
struct Part<'a, T> {
    /// All of a queue where the order is indirect, so are the results.
    rays: &'a [Ray],
    order: Order<&'a [AtomicU32]>,
    results: &'a [T],
}

impl<'a, T> Part<'a, T> {
    #[inline(always)]
    fn len(&self) -> usize {
        match self.order {
            Order::Stored => self.rays.len(),
            Order::Indirect(places) => places.len(),
        }
    }

    /// The ray at a place of the order, and the place of its result. What lies elsewhere is asked for ahead: the
    /// ray, and the result's place before its ray is traced.
    #[inline(always)]
    fn get(&self, at: usize) -> (&'a Ray, &'a T) {
        let place = match self.order {
            Order::Stored => at,
            Order::Indirect(places) => {
                if let Some(ahead) = places.get(at + RAYS_AHEAD) {
                    prefetch(&self.rays[ahead.load(Relaxed) as usize]);
                }
                let place = places[at].load(Relaxed) as usize;
                prefetch(&self.results[place]);
                place
            }
        };
        (&self.rays[place], &self.results[place])
    }
}

/// Calls `trace` for each part of a queue, on all threads.
fn for_each_part<T: Sync>(
    rays: &[Ray],
    order: Order<&[AtomicU32]>,
    results: &[T],
    trace: impl Fn(Part<'_, T>) + Sync,
) {
    assert_eq!(rays.len(), results.len(), "one result per ray");
    match order {
        Order::Stored => {
            let parts = rays.par_chunks(CHUNK).zip(results.par_chunks(CHUNK)).with_max_len(1);
            parts.for_each(|(rays, results)| trace(Part { rays, order, results }));
        }
        Order::Indirect(permutation) => permutation
            .par_chunks(CHUNK)
            .with_max_len(1)
            .for_each(|places| trace(Part { rays, order: Order::Indirect(places), results })),
    }
}
