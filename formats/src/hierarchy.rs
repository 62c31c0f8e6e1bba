//! The scene's hierarchy as the kernel `wide` has it, and the way of a ray through it, node by node as that
//! kernel goes.

use std::cmp::Reverse;

use rayon::prelude::*;

use crate::holes::Holes;
use crate::intersect::{Intersection, PADDING, Shear, farthest, reciprocal};
use crate::manifest::{Place, SceneArray};
use crate::ray::{Hit, Kind, Ray, Work};
use crate::reader::{Dump, Loaded, ReadError};

/// Children of a node.
pub const CHILDREN: usize = 8;

/// Bits of a child that hold a node's index or a leaf's first slot; those above hold the number of a leaf's
/// triangles, 0 for a node.
const FIRST_BITS: u32 = 28;

/// Triangles of a leaf that are tested together.
const BLOCK: usize = 4;

/// Why a recording has no hierarchy.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "each message says what it and its fields mean")]
pub enum HierarchyError {
    #[error(transparent)]
    Read(#[from] ReadError),
    #[error(
        "{boxes} boxes, {nodes} nodes and {slots} leaf slots are no hierarchy of {triangles} triangles: expected \
         {CHILDREN} boxes for each node, and a slot for each triangle"
    )]
    Lengths { boxes: usize, nodes: usize, slots: usize, triangles: usize },
    #[error(
        "child {slot} of node {node} is {child:#010x}: expected a node behind this one that is nobody else's child, or \
         triangles that exist"
    )]
    Child { node: usize, slot: usize, child: u32 },
    #[error("a leaf or a triangle leads to a triangle or a vertex that does not exist")]
    Index,
}

/// The boxes of a scene, with its triangles.
#[derive(Debug)]
pub struct Hierarchy {
    /// Lowest and highest corner of each child of each node.
    boxes: Loaded<[f32; 6]>,
    /// Of each node.
    children: Loaded<[u32; CHILDREN]>,
    /// Triangle in each leaf slot.
    slots: Loaded<u32>,
    positions: Loaded<[f32; 3]>,
    triangles: Loaded<[u32; 3]>,
    holes: Option<Holes>,
}

/// A box that a ray entered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Visit {
    /// The child that it is: [`CHILDREN`] × its parent's index + its place there; `None` for the root.
    pub place: Option<usize>,
    /// How far below the root, which has 0.
    pub level: u32,
    /// Index of the node whose children were tested; `None` for a leaf.
    pub node: Option<usize>,
    /// Triangles of the leaf that were tested; 0 for a node.
    pub triangles: u32,
}

/// The way of a ray through a hierarchy.
#[derive(Clone, Debug, PartialEq)]
pub struct Traversal {
    /// What it entered, in order.
    pub visits: Vec<Visit>,
    /// What it met.
    pub hit: Hit,
}

impl Traversal {
    /// What is counted of it.
    pub fn work(&self) -> Work {
        let nodes = self.visits.iter().filter(|visit| visit.node.is_some()).count() as u32;
        Work { nodes, triangles: self.visits.iter().map(|visit| visit.triangles).sum() }
    }
}

/// A child that a ray may enter.
struct Waiting {
    near: f32,
    child: u32,
    place: Option<usize>,
    level: u32,
}

impl Waiting {
    /// What is visited first has least: the nearest; of equally near ones nodes, then leaves of fewer blocks.
    fn rank(&self) -> (u32, usize, usize) {
        let (count, first) = leaf(self.child);
        (self.near.to_bits(), count.div_ceil(BLOCK), first)
    }
}

/// Number of triangles of a child, 0 for a node, and its first leaf slot or its index.
fn leaf(child: u32) -> (usize, usize) {
    ((child >> FIRST_BITS) as usize, (child & ((1 << FIRST_BITS) - 1)) as usize)
}

impl Hierarchy {
    /// That of a recording, if it was kept with the scene.
    ///
    /// # Errors
    /// If it was not, or is none that can be walked.
    pub fn open(dump: &Dump) -> Result<Self, HierarchyError> {
        let place = Place::Scene;
        let hierarchy = Self {
            boxes: dump.array(&place(SceneArray::NodeBoxes))?,
            children: dump.array(&place(SceneArray::NodeChildren))?,
            slots: dump.array(&place(SceneArray::LeafTriangles))?,
            positions: dump.array(&place(SceneArray::Positions))?,
            triangles: dump.array(&place(SceneArray::Triangles))?,
            holes: Holes::open(dump)?,
        };
        hierarchy.check()?;
        Ok(hierarchy)
    }

    fn check(&self) -> Result<(), HierarchyError> {
        let (boxes, nodes, slots) = (self.boxes.len(), self.children.len(), self.slots.len());
        let triangles = self.triangles.len();
        if nodes == 0 || boxes != CHILDREN * nodes || slots != triangles {
            return Err(HierarchyError::Lengths { boxes, nodes, slots, triangles });
        }
        let mut is_child = vec![false; nodes];
        for (node, children) in self.children.iter().enumerate() {
            for (slot, &child) in children.iter().enumerate() {
                let is_right = self.is_empty(CHILDREN * node + slot)
                    || match leaf(child) {
                        (0, index) => {
                            index > node && index < nodes && !std::mem::replace(&mut is_child[index], true)
                        }
                        (count, first) => first + count <= slots,
                    };
                if !is_right {
                    return Err(HierarchyError::Child { node, slot, child });
                }
            }
        }
        let has_corners =
            |triangle: &[u32; 3]| triangle.iter().all(|&vertex| (vertex as usize) < self.positions.len());
        let are_there = self.slots.par_iter().all(|&triangle| (triangle as usize) < triangles)
            && self.triangles.par_iter().all(has_corners);
        if are_there { Ok(()) } else { Err(HierarchyError::Index) }
    }

    /// Whether a node has no child at a place.
    fn is_empty(&self, place: usize) -> bool {
        self.boxes[place][0] == f32::INFINITY
    }

    /// Lowest and highest corner of what was entered, world units.
    ///
    /// # Panics
    /// If there is no such child.
    pub fn bounds(&self, place: Option<usize>) -> [[f32; 3]; 2] {
        let of_root = || (0..CHILDREN).filter(|&place| !self.is_empty(place));
        let boxes: Vec<[f32; 6]> = match place {
            Some(place) => vec![self.boxes[place]],
            None => of_root().map(|place| self.boxes[place]).collect(),
        };
        let axis = |axis: usize| {
            let low = boxes.iter().fold(f32::INFINITY, |low, corners| low.min(corners[axis]));
            let high = boxes.iter().fold(f32::NEG_INFINITY, |high, corners| high.max(corners[axis + 3]));
            (low, high)
        };
        let [x, y, z] = [0, 1, 2].map(axis);
        [[x.0, y.0, z.0], [x.1, y.1, z.1]]
    }

    /// The way of a ray, as the kernel `wide` goes it: the nearest child first, and with shadow rays, which end at
    /// the first hit, the last one.
    pub fn traversal(&self, ray: &Ray, kind: Kind) -> Traversal {
        let mut walk = Walk::new(self, ray, kind);
        let mut waiting = vec![Waiting { near: 0.0, child: 0, place: None, level: 0 }];
        while let Some(next) = waiting.pop() {
            if next.near > walk.limit() {
                continue;
            }
            let (count, first) = leaf(next.child);
            let mut visit = Visit { place: next.place, level: next.level, node: None, triangles: 0 };
            if count == 0 {
                visit.node = Some(first);
                walk.visits.push(visit);
                waiting.extend(walk.entered(first, next.level + 1));
                continue;
            }
            let is_over = walk.test(&self.slots[first..first + count], &mut visit.triangles);
            walk.visits.push(visit);
            if is_over {
                break;
            }
        }
        let hit = if walk.best.is_hit() { walk.best } else { Hit::MISS };
        Traversal { visits: walk.visits, hit }
    }
}

/// A ray on its way.
struct Walk<'a> {
    hierarchy: &'a Hierarchy,
    kind: Kind,
    origin: [f32; 3],
    inverse: [f32; 3],
    /// The reciprocals for far planes, padded.
    padded: [f32; 3],
    t_min: f32,
    shear: Shear,
    best: Hit,
    visits: Vec<Visit>,
}

impl<'a> Walk<'a> {
    fn new(hierarchy: &'a Hierarchy, ray: &Ray, kind: Kind) -> Self {
        let inverse = ray.direction.map(reciprocal);
        Self {
            hierarchy,
            kind,
            origin: ray.origin,
            inverse,
            padded: inverse.map(|inverse| inverse * PADDING),
            // No negative zero.
            t_min: ray.t_min + 0.0,
            shear: Shear::new(ray, inverse),
            best: Hit { t: farthest(ray), ..Hit::MISS },
            visits: Vec::new(),
        }
    }

    /// Boxes beyond this distance are not entered.
    fn limit(&self) -> f32 {
        self.best.t * PADDING
    }

    /// The children of a node that the ray enters, those that come first last.
    fn entered(&self, node: usize, level: u32) -> Vec<Waiting> {
        let children = self.hierarchy.children[node].iter().enumerate();
        let mut entered: Vec<Waiting> = children
            .filter_map(|(slot, &child)| {
                let place = CHILDREN * node + slot;
                let near = self.enters(place)?;
                Some(Waiting { near, child, place: Some(place), level })
            })
            .collect();
        match self.kind {
            Kind::Closest => entered.sort_by_key(|waiting| Reverse(waiting.rank())),
            // Whatever the distance.
            Kind::Shadow => entered.iter_mut().for_each(|waiting| waiting.near = 0.0),
        }
        entered
    }

    /// Where the ray enters a child's box, if it does.
    fn enters(&self, place: usize) -> Option<f32> {
        if self.hierarchy.is_empty(place) {
            return None;
        }
        let corners = &self.hierarchy.boxes[place];
        let (mut near, mut far) = (f32::NEG_INFINITY, f32::INFINITY);
        for axis in 0..3 {
            let distance = |plane: f32, inverse: f32| (plane - self.origin[axis]) * inverse;
            let (low, high) = (corners[axis], corners[axis + 3]);
            let (enter, leave) = if self.inverse[axis] < 0.0 { (high, low) } else { (low, high) };
            near = near.max(distance(enter, self.inverse[axis]));
            far = far.min(distance(leave, self.padded[axis]));
        }
        // A plane that the ray starts on may be at minus zero, which would come last.
        let near = if near > self.t_min { near } else { self.t_min };
        (near <= far.min(self.limit())).then_some(near)
    }

    /// Tests the triangles of a leaf, counting them; true if the search is over.
    fn test(&mut self, triangles: &[u32], tested: &mut u32) -> bool {
        for block in triangles.chunks(BLOCK) {
            *tested += block.len() as u32;
            if block.iter().any(|&triangle| self.meets(triangle) && self.kind == Kind::Shadow) {
                return true;
            }
        }
        false
    }

    /// Tests a triangle; true if it is what the ray meets so far.
    fn meets(&mut self, triangle: u32) -> bool {
        let Hierarchy { positions, triangles, holes, .. } = self.hierarchy;
        let corners = triangles[triangle as usize];
        let [a, b, c] = corners.map(|vertex| positions[vertex as usize]);
        let rows = [0, 1, 2].map(|axis| [a[axis], b[axis], c[axis], 0.0]);
        let Some(Intersection { t, u, v }) = self.shear.meet(&rows) else { return false };
        let is_nearer = t < self.best.t || (t == self.best.t && triangle < self.best.triangle);
        if !(t >= self.t_min && is_nearer) {
            return false;
        }
        if holes.as_ref().is_some_and(|holes| holes.is_hole(triangle, corners, [u, v])) {
            return false;
        }
        self.best = Hit { t: t.abs(), triangle, u, v };
        true
    }
}
