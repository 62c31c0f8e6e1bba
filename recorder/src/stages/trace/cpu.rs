//! Trace on threads: the same arithmetic as the WGSL kernels, compiled for AVX2 as well,
//! where the processor has it.

use std::sync::atomic::{AtomicU32, AtomicU64, Ordering::Relaxed};

use formats::intersect::Shear;
use formats::metrics::lanes::LaneUse;
use formats::pages::room_on_huge_pages;
use formats::ray::{Hit, Kind, Ray, Work};
use rayon::prelude::*;
use scenes::Scene;
use scenes::bvh::Bvh;
use scenes::features::Features;

use super::cpu_bundle::Bundles;
use super::cpu_bvh2::BinaryTree;
use super::cpu_cwbvh::CompressedTree;
use super::cpu_lanes::LaneTree;
use super::cpu_packet::PacketTree;
use super::cpu_part::{CHUNK, Part, for_each_part, part_of};
use super::cpu_query::{Account, Compiled, Searcher, Steps, Trail, Tree, Variant};
use super::cpu_wide::WideTree;
use super::hits::{Hits, store};
use super::mask::Masks;
use super::moeller_trumbore::PlainRay;
use super::triangle::{LeafTriangle, TriangleRay};
use super::{BoxTest, Order, Precision, TraceKernel, TriangleTest};

// What a search is compiled for, by name: boxes that are padded or not, what it asks for, scenes with masks or
// without, instructions.
const PADDED: bool = true;
const PLAIN: bool = false;
const ANY_HIT: bool = true;
const NEAREST: bool = false;
const MASKED: bool = true;
const UNMASKED: bool = false;
#[cfg(target_arch = "x86_64")]
const AVX2: bool = true;
const PORTABLE: bool = false;

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
    Lanes(LaneTree),
    Packet(PacketTree),
}

/// Which instructions a search is compiled for; the results are the same.
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
        let leaves = || {
            let mut leaves = room_on_huge_pages(bvh.order().len());
            bvh.order().par_iter().map(leaf).collect_into_vec(&mut leaves);
            leaves
        };
        let tree = match bvh {
            Bvh::Bvh2 { nodes, .. } => AnyTree::Binary(BinaryTree::new(nodes, leaves())),
            Bvh::Cwbvh { nodes, .. } => AnyTree::Compressed(CompressedTree::new(nodes, leaves())),
            Bvh::Wide { nodes, order } => {
                AnyTree::Wide(WideTree::new(nodes, |slot| leaf(&order[slot as usize])))
            }
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

    /// The same, with rays traced together where the kernel, which walks the same hierarchy, does so.
    #[must_use]
    pub fn with_kernel(self, kernel: TraceKernel) -> Self {
        let tree = match (self.tree, kernel) {
            (AnyTree::Binary(tree), TraceKernel::Lanes) => AnyTree::Lanes(LaneTree(tree)),
            (AnyTree::Binary(tree), TraceKernel::Packet) => AnyTree::Packet(PacketTree(tree)),
            (tree, _) => tree,
        };
        Self { tree, ..self }
    }

    /// The same tracer without special instructions: results are the same.
    #[cfg(test)]
    pub(super) fn portable(mut self) -> Self {
        self.instructions = Instructions::Portable;
        self
    }

    /// How many of the first rays the kernel `wide` traces together.
    #[cfg(test)]
    pub(super) fn traced_together(&self, rays: &[Ray], kind: Kind) -> usize {
        let AnyTree::Wide(tree) = &self.tree else { return 0 };
        let (places, bundles) = (vec![(); rays.len()], Bundles(tree));
        let (part, keep) = (Part::new(rays, &places), |_: &(), _, ()| ());
        match kind {
            Kind::Closest => self.search_in::<_, (), Shear, (), PADDED, NEAREST>(&bundles, part, &(), keep),
            Kind::Shadow => self.search_in::<_, (), Shear, (), PADDED, ANY_HIT>(&bundles, part, &(), keep),
        }
    }

    /// Traces rays of the kind that the results are of, the nearest hit of each or any.
    ///
    /// # Panics
    /// If there are not as many results or places as rays.
    pub fn trace(&self, rays: &[Ray], order: Order<&[AtomicU32]>, hits: &Hits) {
        let chunk = match self.tree {
            // As lane use is counted by.
            AnyTree::Lanes(_) | AnyTree::Packet(_) => CHUNK,
            AnyTree::Binary(_) | AnyTree::Compressed(_) | AnyTree::Wide(_) => part_of(rays.len()),
        };
        match hits {
            Hits::Closest(hits) => {
                let keep = |place: &[AtomicU64; 2], hit, ()| store(place, hit);
                for_each_part(rays, order, hits, chunk, |part| self.nearest(part, keep));
            }
            Hits::Shadow(distances) => {
                let keep = |place: &AtomicU32, hit: Hit, ()| place.store(hit.t.to_bits(), Relaxed);
                for_each_part(rays, order, distances, chunk, |part| {
                    self.search::<_, _, PADDED, ANY_HIT>(part, &(), keep)
                });
            }
        }
    }

    /// What tracing each ray takes.
    pub fn work(&self, rays: &[Ray], kind: Kind) -> Vec<Work> {
        // A packet's ray is counted by itself.
        let together = if matches!(self.tree, AnyTree::Packet(_)) { 1 } else { CHUNK };
        rays.par_chunks(together).flat_map_iter(|rays| self.accounts(rays, kind, &Work::default())).collect()
    }

    /// How many lanes work of those that a kernel keeps busy with these rays, as they lie: in each step those whose
    /// rays take part in it. `None` for kernels that trace rays one by one.
    pub fn lane_use(&self, rays: &[Ray], kind: Kind) -> Option<LaneUse> {
        let width = match self.tree {
            AnyTree::Lanes(_) => LaneTree::WIDTH,
            AnyTree::Packet(_) => PacketTree::WIDTH,
            AnyTree::Binary(_) | AnyTree::Compressed(_) | AnyTree::Wide(_) => return None,
        };
        let of_chunk = |rays: &[Ray]| {
            let steps = self.accounts(rays, kind, &Steps::default()).into_iter();
            let add = |all: LaneUse, steps: Steps| LaneUse {
                work: all.work + steps.own,
                capacity: all.capacity + width as u64 * steps.together,
                ..all
            };
            steps.fold(LaneUse::new(width), add)
        };
        let add = |mut all: LaneUse, part: LaneUse| {
            all.merge(&part);
            all
        };
        Some(rays.par_chunks(CHUNK).map(of_chunk).reduce(|| LaneUse::new(width), add))
    }

    /// What tracing a ray reads, step by step.
    pub fn trail(&self, ray: &Ray, kind: Kind) -> Trail {
        let trail = Trail::new(match &self.tree {
            AnyTree::Binary(_) | AnyTree::Lanes(_) | AnyTree::Packet(_) => BinaryTree::BYTES,
            AnyTree::Compressed(_) => CompressedTree::BYTES,
            AnyTree::Wide(_) => WideTree::BYTES,
        });
        self.accounts(std::slice::from_ref(ray), kind, &trail).pop().unwrap_or(trail)
    }

    /// What is kept of each ray's way beside its hit.
    fn accounts<A: Account>(&self, rays: &[Ray], kind: Kind, account: &A) -> Vec<A> {
        let mut accounts = Vec::with_capacity(rays.len());
        let places = vec![(); rays.len()];
        let part = Part::new(rays, &places);
        let keep = |(): &(), _, account| accounts.push(account);
        match kind {
            Kind::Closest => self.search::<_, _, PADDED, NEAREST>(part, account, keep),
            Kind::Shadow => self.search::<_, _, PADDED, ANY_HIT>(part, account, keep),
        }
        accounts
    }

    fn nearest<T>(&self, part: Part<'_, T>, keep: impl FnMut(&T, Hit, ())) {
        let Precision { triangles, boxes } = self.precision;
        match (triangles, boxes) {
            (TriangleTest::Watertight, BoxTest::Padded) => {
                self.search::<_, _, PADDED, NEAREST>(part, &(), keep)
            }
            (TriangleTest::Watertight, BoxTest::Plain) => {
                self.search::<_, _, PLAIN, NEAREST>(part, &(), keep)
            }
            (TriangleTest::MoellerTrumbore, BoxTest::Padded) => {
                self.search_one_by_one::<_, PlainRay, _, PADDED, NEAREST>(part, &(), keep);
            }
            (TriangleTest::MoellerTrumbore, BoxTest::Plain) => {
                self.search_one_by_one::<_, PlainRay, _, PLAIN, NEAREST>(part, &(), keep);
            }
        }
    }

    /// Traces some rays with the watertight test, the only one with which rays are traced together; `keep` takes
    /// the place of a ray's result, its hit and its account.
    fn search<A: Account, T, const IS_PADDED: bool, const IS_ANY: bool>(
        &self,
        part: Part<'_, T>,
        account: &A,
        keep: impl FnMut(&T, Hit, A),
    ) {
        match &self.tree {
            AnyTree::Lanes(tree) => {
                self.search_in::<_, A, Shear, T, IS_PADDED, IS_ANY>(tree, part, account, keep);
            }
            AnyTree::Packet(tree) => {
                self.search_in::<_, A, Shear, T, IS_PADDED, IS_ANY>(tree, part, account, keep);
            }
            // What is kept of a ray's way is that of the ray by itself.
            AnyTree::Wide(tree) if IS_PADDED && !A::IS_KEPT => {
                self.search_wide::<A, T, IS_PADDED, IS_ANY>(tree, part, account, keep);
            }
            AnyTree::Binary(_) | AnyTree::Compressed(_) | AnyTree::Wide(_) => {
                self.search_one_by_one::<A, Shear, T, IS_PADDED, IS_ANY>(part, account, keep)
            }
        }
    }

    /// The same by bundles as long as those are worth it. Where one is not, its eight rays are traced one by one; where
    /// the next one, or the first, is not either, so are all that are left.
    fn search_wide<A: Account, T, const IS_PADDED: bool, const IS_ANY: bool>(
        &self,
        tree: &WideTree,
        part: Part<'_, T>,
        account: &A,
        mut keep: impl FnMut(&T, Hit, A),
    ) {
        let mut rest = part;
        while rest.len() > 0 {
            let bundles = Bundles(tree);
            let bundled =
                self.search_in::<_, A, Shear, T, IS_PADDED, IS_ANY>(&bundles, rest, account, &mut keep);
            let singles = if bundled > 0 { Bundles::RAYS } else { rest.len() };
            let (some, others) = rest.split_at(bundled).1.split_at(singles);
            self.search_in::<_, A, Shear, T, IS_PADDED, IS_ANY>(tree, some, account, &mut keep);
            rest = others;
        }
    }

    /// The same with any triangle test, each ray by itself.
    fn search_one_by_one<A: Account, R: TriangleRay, T, const IS_PADDED: bool, const IS_ANY: bool>(
        &self,
        part: Part<'_, T>,
        account: &A,
        keep: impl FnMut(&T, Hit, A),
    ) {
        match &self.tree {
            AnyTree::Binary(tree) | AnyTree::Lanes(LaneTree(tree)) | AnyTree::Packet(PacketTree(tree)) => {
                self.search_in::<_, A, R, T, IS_PADDED, IS_ANY>(tree, part, account, keep);
            }
            AnyTree::Compressed(tree) => {
                self.search_in::<_, A, R, T, IS_PADDED, IS_ANY>(tree, part, account, keep);
            }
            AnyTree::Wide(tree) => {
                self.search_in::<_, A, R, T, IS_PADDED, IS_ANY>(tree, part, account, keep);
            }
        }
    }

    fn search_in<H: Searcher<R>, A: Account, R: TriangleRay, T, const IS_PADDED: bool, const IS_ANY: bool>(
        &self,
        tree: &H,
        part: Part<'_, T>,
        account: &A,
        keep: impl FnMut(&T, Hit, A),
    ) -> usize {
        let masks = &self.masks;
        match (self.instructions, masks.is_empty()) {
            (Instructions::Portable, true) => tree
                .search::<Compiled<A, R, IS_PADDED, IS_ANY, UNMASKED, PORTABLE>, T>(
                    masks, part, account, keep,
                ),
            (Instructions::Portable, false) => tree
                .search::<Compiled<A, R, IS_PADDED, IS_ANY, MASKED, PORTABLE>, T>(masks, part, account, keep),
            #[cfg(target_arch = "x86_64")]
            // SAFETY: `Instructions::Avx2` is chosen only where the processor has these instructions.
            (Instructions::Avx2, true) => unsafe {
                search_avx2::<H, Compiled<A, R, IS_PADDED, IS_ANY, UNMASKED, AVX2>, T>(
                    tree, masks, part, account, keep,
                )
            },
            #[cfg(target_arch = "x86_64")]
            // SAFETY: as above.
            (Instructions::Avx2, false) => unsafe {
                search_avx2::<H, Compiled<A, R, IS_PADDED, IS_ANY, MASKED, AVX2>, T>(
                    tree, masks, part, account, keep,
                )
            },
        }
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
fn search_avx2<H: Searcher<S::Ray>, S: Variant, T>(
    tree: &H,
    masks: &Masks,
    part: Part<'_, T>,
    account: &S::Account,
    keep: impl FnMut(&T, Hit, S::Account),
) -> usize {
    const { assert!(S::AVX2, "else the instructions are not used") };
    tree.search::<S, T>(masks, part, account, keep)
}
