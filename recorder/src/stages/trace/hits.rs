//! What tracing a queue on threads found: results that many threads write in any order, each to its own place.

use std::ops::Range;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering::Relaxed};

use formats::pages::make_room;
use formats::ray::{Hit, Kind, Ray};
use formats::unit_space::UnitSpace;

/// Results of rays, each at its ray's place.
#[derive(Debug)]
pub enum Hits {
    /// The nearest hits of closest rays, two halves each.
    Closest(Vec<[AtomicU64; 2]>),
    /// The bits of the distances at which shadow rays are blocked, `+inf` where they are not.
    Shadow(Vec<AtomicU32>),
}

impl Default for Hits {
    fn default() -> Self {
        Self::Closest(Vec::new())
    }
}

impl Hits {
    /// `count` results of unknown value.
    pub fn new(kind: Kind, count: usize) -> Self {
        let mut hits = match kind {
            Kind::Closest => Self::Closest(Vec::new()),
            Kind::Shadow => Self::Shadow(Vec::new()),
        };
        hits.make_room(kind, count);
        hits
    }

    /// Makes and touches room for so many results of any value.
    pub fn make_room(&mut self, kind: Kind, count: usize) {
        match (&mut *self, kind) {
            (Self::Closest(places), Kind::Closest) => make_room(places, count),
            (Self::Shadow(places), Kind::Shadow) => make_room(places, count),
            _ => *self = Self::new(kind, count),
        }
    }

    /// Results as [`Hits::bytes`] gives them.
    pub fn from_bytes(kind: Kind, bytes: &[u8]) -> Self {
        match kind {
            Kind::Closest => {
                let halves = bytemuck::pod_collect_to_vec::<u8, [u64; 2]>(bytes);
                Self::Closest(halves.into_iter().map(|halves| halves.map(AtomicU64::new)).collect())
            }
            Kind::Shadow => {
                let words = bytemuck::pod_collect_to_vec::<u8, u32>(bytes);
                Self::Shadow(words.into_iter().map(AtomicU32::new).collect())
            }
        }
    }

    /// The kind of the rays.
    pub fn kind(&self) -> Kind {
        match self {
            Self::Closest(_) => Kind::Closest,
            Self::Shadow(_) => Kind::Shadow,
        }
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        match self {
            Self::Closest(places) => places.len(),
            Self::Shadow(places) => places.len(),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The hit of a closest ray.
    ///
    /// # Panics
    /// If these are the results of shadow rays.
    #[inline]
    pub fn hit(&self, index: usize) -> Hit {
        match self {
            Self::Closest(places) => load(&places[index]),
            Self::Shadow(_) => panic!("shadow rays have no hits"),
        }
    }

    /// The distance along a ray to what it hit, world units; `+inf` if that is nothing.
    #[inline]
    pub fn distance(&self, index: usize) -> f32 {
        match self {
            Self::Closest(places) => load(&places[index]).t,
            Self::Shadow(places) => f32::from_bits(places[index].load(Relaxed)),
        }
    }

    /// The traced length of a ray, unit lengths (docs/keys.md).
    #[inline]
    pub fn length(&self, unit: &UnitSpace, ray: &Ray, index: usize) -> f32 {
        match self {
            Self::Closest(places) => unit.closest_length(ray, &load(&places[index])),
            Self::Shadow(_) => unit.shadow_length(ray, self.distance(index)),
        }
    }

    /// The bytes of some results as a recording holds them: [`Hit`] each, or f32 distances.
    ///
    /// # Panics
    /// If there are not so many.
    pub fn bytes(&self, range: Range<usize>) -> Vec<u8> {
        match self {
            Self::Closest(places) => {
                places[range].iter().flat_map(|place| bytemuck::cast::<Hit, [u8; 16]>(load(place))).collect()
            }
            Self::Shadow(places) => {
                places[range].iter().flat_map(|place| place.load(Relaxed).to_ne_bytes()).collect()
            }
        }
    }
}

/// Stores a hit; every place is written by one thread alone.
#[inline]
pub(super) fn store(place: &[AtomicU64; 2], hit: Hit) {
    let halves: [u64; 2] = bytemuck::cast(hit);
    place[0].store(halves[0], Relaxed);
    place[1].store(halves[1], Relaxed);
}

#[inline]
fn load(place: &[AtomicU64; 2]) -> Hit {
    bytemuck::cast([place[0].load(Relaxed), place[1].load(Relaxed)])
}
