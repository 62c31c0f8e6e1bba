//! Eight rays that start and go close to each other, side by side through the wide hierarchy: the boxes of a node
//! are tested once for all of them.
//!
//! What a ray computes of a box grows or falls with its origin and with the reciprocals of its direction, rounding
//! included. So a node's boxes are tested by bounds on those, which let through whatever one of the rays enters;
//! a leaf's box is tested by each ray for itself. Nothing is left out that a ray may hit, and a shadow ray
//! comes to what it may hit in the order in which it would come there by itself: nearest hits, and what blocks a shadow
//! ray, are the same bit for bit.
//!
//! A bundle that must visit too much for what its rays find together is given up, and its rays are traced one by one.

use formats::intersect::{Shear, reciprocal};
use formats::ray::{Hit, Ray};
use glam::Vec4;
use scenes::bvh::WideNode;

use super::cpu_group::{BoxLanes, lanes_of};
use super::cpu_part::Part;
use super::cpu_query::{Query, Searcher, Tree, Variant};
#[cfg(target_arch = "x86_64")]
use super::cpu_vector::Avx2;
use super::cpu_vector::{Portable, Vector};
use super::cpu_wide::{Node, Stack, Waiting, WideTree};
use super::mask::Masks;

/// Directions of a bundle differ by less along each axis.
const WIDEST: f32 = 0.15;

/// Boxes that a bundle may enter beforehand, of closest and of shadow rays, and for each ray that enters a leaf: found
/// by measuring. A bundle that is given up has cost so much.
const BOXES: [i32; 2] = [32, 24];
const BOXES_PER_RAY: i32 = 3;

/// The wide hierarchy, walked by bundles.
pub(super) struct Bundles<'a>(pub &'a WideTree);

impl Bundles<'_> {
    /// Rays of a bundle.
    pub(super) const RAYS: usize = 8;
}

impl Searcher<Shear> for Bundles<'_> {
    /// Ends before the first rays that are no bundle or not worth one.
    #[inline(always)]
    fn search<S: Variant<Ray = Shear>, T>(
        &self,
        masks: &Masks,
        part: Part<'_, T>,
        account: &S::Account,
        keep: impl FnMut(&T, Hit, S::Account),
    ) -> usize {
        #[cfg(target_arch = "x86_64")]
        if S::AVX2 {
            return search::<Avx2, S, T>(self.0, masks, part, account, keep);
        }
        search::<Portable, S, T>(self.0, masks, part, account, keep)
    }
}

#[inline(always)]
fn search<V: Vector, S: Variant<Ray = Shear>, T>(
    tree: &WideTree,
    masks: &Masks,
    part: Part<'_, T>,
    account: &S::Account,
    mut keep: impl FnMut(&T, Hit, S::Account),
) -> usize {
    let mut stack = WideTree::stack();
    let mut queries: Vec<Query<'_, S>> = Vec::new();
    for first in (0..part.len()).step_by(Bundles::RAYS) {
        let Some(cone) = Cone::around(part, first) else { return first };
        queries.extend(cone.places().map(|at| Query::new(part.get(at).0, account.clone(), masks)));
        let Some(rays) = queries.first_chunk_mut() else { unreachable!("as many as a bundle has") };
        if !Bundle::<V>::new(&cone, rays).walk(tree, rays, &mut stack) {
            return first;
        }
        for (at, query) in cone.places().zip(queries.drain(..)) {
            let (hit, account) = query.result();
            keep(part.place(at), hit, account);
        }
    }
    part.len()
}

/// Bounds on where the rays of a bundle start and go.
struct Cone {
    /// The place of the first one.
    first: usize,
    origin: [[f32; 2]; 3],
    t_min: f32,
    /// Of the reciprocals of their directions, of one sign.
    inverse: [[f32; 2]; 3],
}

impl Cone {
    /// The rays of a part from a place on; `None` if they are no bundle.
    #[inline(always)]
    fn around<T>(part: Part<'_, T>, first: usize) -> Option<Self> {
        if first + Bundles::RAYS > part.len() {
            return None;
        }
        let halves = |at: usize| bytemuck::cast::<Ray, [[f32; 4]; 2]>(*part.ray(at)).map(Vec4::from_array);
        let [mut low, mut high] = [halves(first); 2];
        for at in first + 1..first + Bundles::RAYS {
            let [start, direction] = halves(at);
            low = [low[0].min(start), low[1].min(direction)];
            high = [high[0].max(start), high[1].max(direction)];
        }
        let [[low_origin @ .., t_min], [low @ .., _]] = low.map(|half| half.to_array());
        let [[high_origin @ .., _], [high @ .., _]] = high.map(|half| half.to_array());
        let is_narrow =
            |axis: usize| high[axis] - low[axis] < WIDEST && (low[axis] > 0.0 || high[axis] < 0.0);
        if !(is_narrow(0) && is_narrow(1) && is_narrow(2)) {
            return None;
        }
        let origin = [0, 1, 2].map(|axis| [low_origin[axis], high_origin[axis]]);
        let inverse = [0, 1, 2].map(|axis| [reciprocal(high[axis]), reciprocal(low[axis])]);
        Some(Self { first, origin, t_min, inverse })
    }

    fn places(&self) -> impl Iterator<Item = usize> + use<> {
        self.first..self.first + Bundles::RAYS
    }
}

/// What boxes are tested with.
struct Bundle<V> {
    /// Bounds on where the rays start, that for near planes first.
    origin: [[V; 2]; 3],
    t_min: V,
    /// Bounds on reciprocals, as they are for near planes and padded for far ones.
    inverse: [[V; 2]; 3],
    padded: [[V; 2]; 3],
    /// Which planes are the near ones: 0 the low ones, 1 the high ones.
    sides: [usize; 3],
    /// Each ray by itself.
    lanes: BoxLanes<V>,
    padding: f32,
}

impl<V: Vector> Bundle<V> {
    #[inline(always)]
    fn new<S: Variant>(cone: &Cone, rays: &[Query<'_, S>; Bundles::RAYS]) -> Self {
        let padding = rays[0].padding();
        let sides = cone.inverse.map(|[low, _]| usize::from(low < 0.0));
        Self {
            origin: [0, 1, 2].map(|axis| {
                let [low, high] = cone.origin[axis].map(V::splat);
                if sides[axis] == 0 { [high, low] } else { [low, high] }
            }),
            t_min: V::splat(cone.t_min + 0.0),
            inverse: cone.inverse.map(|[low, high]| [V::splat(low), V::splat(high)]),
            padded: cone.inverse.map(|[low, high]| [V::splat(low * padding), V::splat(high * padding)]),
            sides,
            lanes: BoxLanes::new(rays),
            padding,
        }
    }

    /// Where the first ray can enter each child's box, and bit `slot` set if one can before `limit`.
    #[inline(always)]
    fn test(&self, node: &Node, limit: f32) -> ([f32; 8], u32) {
        let (mut near, mut far) = (self.t_min, V::splat(limit));
        for axis in 0..3 {
            let side = self.sides[axis] & 1;
            let [for_near, for_far] = self.origin[axis];
            let nearer = V::load(&node.planes[axis][side]).sub(for_near);
            let farther = V::load(&node.planes[axis][1 - side]).sub(for_far);
            let ([low, high], [padded_low, padded_high]) = (self.inverse[axis], self.padded[axis]);
            // A zero keeps the sign that `t_min` has.
            near = nearer.mul(low).min(nearer.mul(high)).max(near);
            far = farther.mul(padded_low).max(farther.mul(padded_high)).min(far);
        }
        (near.store(), near.le(far))
    }

    /// Finds what all rays ask for; false if that is not worth it, and then what they have found is of no use.
    #[inline(always)]
    fn walk<S: Variant>(
        &self,
        tree: &WideTree,
        rays: &mut [Query<'_, S>; Bundles::RAYS],
        stack: &mut Stack,
    ) -> bool {
        let mut waiting = Waiting::new(stack);
        let mut limits = [0.0; Bundles::RAYS];
        for (limit, ray) in limits.iter_mut().zip(&*rays) {
            *limit = ray.limit();
        }
        let (mut line, mut limit, mut boxes) = (0, greatest(&limits), BOXES[usize::from(S::ANY)]);
        loop {
            let node = tree.node(line);
            let (near, hits) = self.test(node, limit);
            boxes -= hits.count_ones() as i32;
            if boxes < 0 {
                return false;
            }
            // Children are named by where they lie, since a leaf's box is asked for again.
            let place = |slot: usize| line << 3 | slot as u32;
            let ask = |slot: usize, _: u32| tree.ask(node.children[slot]);
            let mut next = match hits {
                0 => waiting.pop::<S>(limit),
                _ if S::ANY => Some(waiting.cheapest_of(place, hits, ask)),
                _ => Some(waiting.nearest_of(place, &near, hits, ask)),
            };
            line = loop {
                let Some(place) = next else { return true };
                let (node, slot) = (tree.node(place >> 3), place as usize % 8);
                let child = node.children[slot];
                if let (0, line) = WideNode::leaf(child) {
                    break line;
                }
                let mut planes = [[V::splat(0.0); 2]; 3];
                for (planes, [low, high]) in planes.iter_mut().zip(&node.planes) {
                    *planes = [V::splat(low[slot]), V::splat(high[slot])];
                }
                let (_, enter) = self.lanes.enter(planes, V::load(&limits), self.padding);
                boxes += BOXES_PER_RAY * enter.count_ones() as i32;
                for lane in lanes_of(enter) {
                    let ray = &mut rays[lane % Bundles::RAYS];
                    let is_done = tree.test_leaf(ray, child);
                    limits[lane % Bundles::RAYS] = if is_done { f32::NEG_INFINITY } else { ray.limit() };
                }
                if enter != 0 {
                    limit = greatest(&limits);
                    if S::ANY && limit == f32::NEG_INFINITY {
                        return true;
                    }
                }
                next = waiting.pop::<S>(limit);
            };
        }
    }
}

#[inline(always)]
fn greatest(limits: &[f32; Bundles::RAYS]) -> f32 {
    limits.iter().fold(f32::NEG_INFINITY, |greatest, &limit| if limit > greatest { limit } else { greatest })
}
