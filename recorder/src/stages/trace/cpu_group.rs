//! Rays that a thread traces together: their queries, and what tests one box or triangle for each of eight.

use formats::ray::Hit;

use super::cpu_part::Part;
use super::cpu_query::{Query, Variant};
use super::cpu_vector::Vector;
use super::mask::Masks;

/// Up to `W` neighbours of an order, and the places of their results. Where there are fewer, the last one stands
/// in for the others, which never work.
pub(super) struct Group<'a, S: Variant, T, const W: usize> {
    pub queries: [Query<'a, S>; W],
    places: [&'a T; W],
    count: usize,
}

impl<'a, S: Variant, T, const W: usize> Group<'a, S, T, W> {
    /// From a place of a part on, which is in it.
    #[inline(always)]
    pub(super) fn new(part: &Part<'a, T>, first: usize, account: &S::Account, masks: &'a Masks) -> Self {
        let count = W.min(part.len() - first);
        let found: [_; W] = std::array::from_fn(|lane| part.get(first + lane.min(count - 1)));
        Self {
            queries: found.map(|(ray, _)| Query::new(ray, account.clone(), masks)),
            places: found.map(|(_, place)| place),
            count,
        }
    }

    /// Bit `lane` set for each ray.
    #[inline(always)]
    pub(super) fn working(&self) -> u32 {
        (1 << self.count) - 1
    }

    /// Hands over what the rays found.
    #[inline(always)]
    pub(super) fn keep(self, mut keep: impl FnMut(&T, Hit, S::Account)) {
        for (query, place) in self.queries.into_iter().zip(self.places).take(self.count) {
            let (hit, account) = query.result();
            keep(place, hit, account);
        }
    }
}

/// What boxes are tested with, of eight rays.
pub(super) struct BoxLanes<V> {
    origin: [V; 3],
    inverse: [V; 3],
    t_min: V,
}

impl<V: Vector> BoxLanes<V> {
    /// Of eight rays.
    #[inline(always)]
    pub(super) fn new<'q, 'm: 'q, S: Variant + 'q>(rays: impl IntoIterator<Item = &'q Query<'m, S>>) -> Self {
        let (mut origin, mut inverse, mut t_min) = ([[0.0; 8]; 3], [[0.0; 8]; 3], [0.0; 8]);
        for (lane, ray) in rays.into_iter().enumerate() {
            for axis in 0..3 {
                origin[axis][lane] = ray.origin[axis];
                inverse[axis][lane] = ray.inverse[axis];
            }
            t_min[lane] = ray.t_min;
        }
        let load = |[x, y, z]: &[[f32; 8]; 3]| [V::load(x), V::load(y), V::load(z)];
        Self { origin: load(&origin), inverse: load(&inverse), t_min: V::load(&t_min) }
    }

    /// Where each ray enters its box, low and high planes by axis, and bit `lane` set if it does before `limit`;
    /// `padding` scales where it leaves.
    #[inline(always)]
    pub(super) fn enter(&self, planes: [[V; 2]; 3], limit: V, padding: f32) -> (V, u32) {
        let (mut near, mut far) = (self.t_min, V::splat(f32::INFINITY));
        for (axis, [low, high]) in planes.into_iter().enumerate() {
            let low = low.sub(self.origin[axis]).mul(self.inverse[axis]);
            let high = high.sub(self.origin[axis]).mul(self.inverse[axis]);
            near = near.max(low.min(high));
            far = far.min(low.max(high));
        }
        (near, near.le(far.mul(V::splat(padding)).min(limit)))
    }
}

/// The lanes whose bits are set.
#[inline(always)]
pub(super) fn lanes_of(mut bits: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        (bits != 0).then(|| {
            let lane = bits.trailing_zeros() as usize;
            bits &= bits - 1;
            lane
        })
    })
}
