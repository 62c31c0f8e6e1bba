//! Trace on threads: the same arithmetic as the WGSL kernels, with AVX2 for the box tests where
//! the processor has it.

use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use formats::ray::{Hit, Kind, Ray, Work};
use rayon::prelude::*;
use scenes::Scene;
use scenes::bvh::Bvh;
use scenes::features::Features;

use super::cpu_bvh2::BinaryTree;
use super::cpu_cwbvh::WideTree;
use super::cpu_query::{Account, Query, Trail};
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
    tree: Tree,
    triangles: Vec<LeafTriangle>,
    masks: Masks,
    instructions: Instructions,
    precision: Precision,
}

#[derive(Clone, Debug)]
enum Tree {
    Binary(BinaryTree),
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
        let triangles = bvh.order().par_iter().map(leaf).collect();
        let tree = match bvh {
            Bvh::Bvh2 { nodes, .. } => Tree::Binary(BinaryTree::new(nodes)),
            Bvh::Cwbvh { nodes, .. } => Tree::Wide(WideTree::new(nodes)),
        };
        let instructions = Instructions::best();
        Self { tree, triangles, masks, instructions, precision: Precision::default() }
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
                for_each_ray(rays, order, hits, |ray, hit| store(hit, self.nearest(ray)));
            }
            Hits::Shadow(distances) => for_each_ray(rays, order, distances, |ray, distance| {
                distance.store(self.search::<Shear, true, true>(ray).t.to_bits(), Relaxed);
            }),
        }
    }

    /// What tracing each ray takes.
    pub fn work(&self, rays: &[Ray], kind: Kind) -> Vec<Work> {
        let work = |ray: &Ray| match kind {
            Kind::Closest => self.search_with_account::<Work, Shear, true, false>(ray, Work::default()).1,
            Kind::Shadow => self.search_with_account::<Work, Shear, true, true>(ray, Work::default()).1,
        };
        rays.par_iter().with_min_len(CHUNK).map(work).collect()
    }

    /// What tracing a ray reads, step by step.
    pub fn trail(&self, ray: &Ray, kind: Kind) -> Trail {
        let node_bytes = match &self.tree {
            Tree::Binary(_) => BinaryTree::NODE_BYTES,
            Tree::Wide(_) => WideTree::NODE_BYTES,
        };
        let trail = Trail::new(node_bytes);
        match kind {
            Kind::Closest => self.search_with_account::<Trail, Shear, true, false>(ray, trail).1,
            Kind::Shadow => self.search_with_account::<Trail, Shear, true, true>(ray, trail).1,
        }
    }

    fn nearest(&self, ray: &Ray) -> Hit {
        let Precision { triangles, boxes } = self.precision;
        match (triangles, boxes) {
            (TriangleTest::Watertight, BoxTest::Padded) => self.search::<Shear, true, false>(ray),
            (TriangleTest::Watertight, BoxTest::Plain) => self.search::<Shear, false, false>(ray),
            (TriangleTest::MoellerTrumbore, BoxTest::Padded) => self.search::<PlainRay, true, false>(ray),
            (TriangleTest::MoellerTrumbore, BoxTest::Plain) => self.search::<PlainRay, false, false>(ray),
        }
    }

    fn search<R: TriangleRay, const PADDED: bool, const ANY: bool>(&self, ray: &Ray) -> Hit {
        self.search_with_account::<(), R, PADDED, ANY>(ray, ()).0
    }

    fn search_with_account<A: Account, R: TriangleRay, const PADDED: bool, const ANY: bool>(
        &self,
        ray: &Ray,
        account: A,
    ) -> (Hit, A) {
        if self.masks.is_empty() {
            self.search_with::<A, R, PADDED, ANY, false>(ray, account)
        } else {
            self.search_with::<A, R, PADDED, ANY, true>(ray, account)
        }
    }

    fn search_with<A: Account, R: TriangleRay, const PADDED: bool, const ANY: bool, const MASKS: bool>(
        &self,
        ray: &Ray,
        account: A,
    ) -> (Hit, A) {
        match self.instructions {
            Instructions::Portable => {
                let mut query =
                    Query::<A, R, PADDED, ANY, MASKS>::new(ray, account, &self.triangles, &self.masks);
                match &self.tree {
                    Tree::Binary(tree) => {
                        tree.traverse::<super::cpu_bvh2::Portable, A, R, PADDED, ANY, MASKS>(&mut query)
                    }
                    Tree::Wide(tree) => {
                        tree.traverse::<super::cpu_cwbvh::Portable, A, R, PADDED, ANY, MASKS>(&mut query)
                    }
                }
                query.result()
            }
            #[cfg(target_arch = "x86_64")]
            // SAFETY: this variant is made where the processor has these instructions.
            Instructions::Avx2 => unsafe { search_avx2::<A, R, PADDED, ANY, MASKS>(self, ray, account) },
        }
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
fn search_avx2<A: Account, R: TriangleRay, const PADDED: bool, const ANY: bool, const MASKS: bool>(
    tracer: &CpuTracer,
    ray: &Ray,
    account: A,
) -> (Hit, A) {
    let mut query = Query::<A, R, PADDED, ANY, MASKS>::new(ray, account, &tracer.triangles, &tracer.masks);
    match &tracer.tree {
        Tree::Binary(tree) => tree.traverse::<super::cpu_bvh2::Avx2, A, R, PADDED, ANY, MASKS>(&mut query),
        Tree::Wide(tree) => tree.traverse::<super::cpu_cwbvh::Avx2, A, R, PADDED, ANY, MASKS>(&mut query),
    }
    query.result()
}

/// How many rays ahead a ray is asked for that lies elsewhere: one takes about as long as a miss.
const RAYS_AHEAD: usize = 2;

/// Calls `trace` for each ray of an order with the place of its result. What lies elsewhere is asked for ahead:
/// the ray, and the result's place before its ray is traced.
fn for_each_ray<T: Sync>(
    rays: &[Ray],
    order: Order<&[AtomicU32]>,
    results: &[T],
    trace: impl Fn(&Ray, &T) + Sync,
) {
    assert_eq!(rays.len(), results.len(), "one result per ray");
    match order {
        Order::Stored => {
            let chunks = rays.par_chunks(CHUNK).zip(results.par_chunks(CHUNK)).with_max_len(1);
            chunks.for_each(|(rays, results)| {
                rays.iter().zip(results).for_each(|(ray, result)| trace(ray, result));
            });
        }
        Order::Indirect(permutation) => permutation.par_chunks(CHUNK).with_max_len(1).for_each(|places| {
            for (at, place) in places.iter().enumerate() {
                if let Some(ahead) = places.get(at + RAYS_AHEAD) {
                    prefetch(&rays[ahead.load(Relaxed) as usize]);
                }
                let place = place.load(Relaxed) as usize;
                prefetch(&results[place]);
                trace(&rays[place], &results[place]);
            }
        }),
    }
}
