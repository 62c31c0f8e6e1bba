//! Bounding volume hierarchies over world-space triangles: built by obvhs, boxes made conservative
//! here, checked before anyone traverses them, cached on disk.
//!
//! - [`node`]: the node formats, as they lie in memory, in the cache and on the GPU
//! - [`top_down`]: a first tree, by the surface area heuristic
//! - [`topology`]: which triangles lie below which node (that tree; obvhs: reinsertion, collapsing)
//! - [`boxes`]: exact and padded bounds of triangles
//! - [`binary`], [`compressed`], [`wide`]: from topology to nodes
//! - [`validate`]: what traversal relies on
//! - [`cache`]: hierarchies on disk, by content hash

mod binary;
mod boxes;
mod cache;
mod compressed;
mod node;
#[cfg(test)]
mod tests;
mod top_down;
mod topology;
mod validate;
mod wide;

pub use boxes::{COORDINATE_LIMIT, EXTENT_LIMIT, TRIANGLE_LIMIT};
pub use cache::{Source, default_cache_folder, load_or_build};
pub use node::{Bvh2Node, CwbvhNode, WideNode};
pub use topology::BvhKind;
pub use validate::{Defect, validate};

use crate::Scene;
use crate::memory::{self, Shortage};
use crate::shown::shown;

/// What building takes at its peak for each triangle, bytes, at least: a box and its copy in the unit cube
/// (24 + 32), two nodes (96), two lists of indices (8), half a node that is being parted (60).
pub const HIERARCHY_BYTES_PER_TRIANGLE: u64 = 220;

/// What a triangle takes at least, bytes: three indices, a material, and its share of the hierarchy.
pub(crate) const BYTES_PER_TRIANGLE: u64 = 16 + HIERARCHY_BYTES_PER_TRIANGLE;

/// Entries that the stack of a [`Bvh2Node`] traversal needs: the number of levels below the root
/// never exceeds it, and each level leaves at most one entry.
pub const BVH2_STACK: usize = 64;

/// Entries that the stack of a [`CwbvhNode`] traversal needs; see [`BVH2_STACK`].
pub const CWBVH_STACK: usize = 32;

/// Most levels of [`WideNode`]s below the root.
pub const WIDE_LEVELS: usize = 32;

/// Most triangles in a leaf below a [`WideNode`].
pub const WIDE_LEAF: u32 = 8;

/// A hierarchy that is ready to be traversed.
///
/// `order[i]` is the scene triangle in leaf slot `i`; every triangle of the scene has exactly one
/// slot. What else holds is listed at [`validate`].
#[derive(Clone, Debug, PartialEq)]
pub enum Bvh {
    /// Two children per node.
    Bvh2 {
        /// The root is node 0; node 1 is unused, so that every pair of children lies in one
        /// 64-byte line. A tree that is one leaf has one node.
        nodes: Vec<Bvh2Node>,
        /// Scene triangle per leaf slot.
        order: Vec<u32>,
    },
    /// Up to eight children per node, with quantised boxes.
    Cwbvh {
        /// The root is node 0.
        nodes: Vec<CwbvhNode>,
        /// Scene triangle per leaf slot.
        order: Vec<u32>,
    },
    /// Up to eight children per node, with boxes in f32.
    Wide {
        /// The root is node 0.
        nodes: Vec<WideNode>,
        /// Scene triangle per leaf slot.
        order: Vec<u32>,
    },
}

impl Bvh {
    /// Which of the formats it is.
    pub fn kind(&self) -> BvhKind {
        match self {
            Self::Bvh2 { .. } => BvhKind::Bvh2,
            Self::Cwbvh { .. } => BvhKind::Cwbvh,
            Self::Wide { .. } => BvhKind::Wide,
        }
    }

    /// Scene triangle per leaf slot.
    pub fn order(&self) -> &[u32] {
        match self {
            Self::Bvh2 { order, .. } | Self::Cwbvh { order, .. } | Self::Wide { order, .. } => order,
        }
    }

    /// The nodes as bytes, in the layout of [`Bvh2Node`], [`CwbvhNode`] or [`WideNode`].
    pub fn node_bytes(&self) -> &[u8] {
        match self {
            Self::Bvh2 { nodes, .. } => bytemuck::cast_slice(nodes),
            Self::Cwbvh { nodes, .. } => bytemuck::cast_slice(nodes),
            Self::Wide { nodes, .. } => bytemuck::cast_slice(nodes),
        }
    }
}

/// Why a scene has no hierarchy.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "each message says what it and its fields mean")]
pub enum BvhError {
    #[error("the scene \"{}\" has no triangles; a hierarchy needs at least one", shown(scene))]
    NoTriangles { scene: String },
    /// Leaf slots are numbered with 28 bits.
    #[error(
        "the scene \"{}\" has {found} triangles, a hierarchy can hold at most {TRIANGLE_LIMIT}; simplify the scene",
        shown(scene)
    )]
    TooManyTriangles { scene: String, found: usize },
    #[error(
        "there is no room to build a hierarchy of the {triangles} triangles of \"{}\"; simplify the scene",
        shown(scene)
    )]
    Memory { scene: String, triangles: usize, source: Shortage },
    /// The box tests would overflow; NaN and infinities end up here too. The first such triangle.
    #[error(
        "triangle {triangle} has the coordinate {value}, expected a number of at most {COORDINATE_LIMIT:e} either way; scale the scene down"
    )]
    Coordinate { triangle: usize, value: f32 },
    /// The builder made something that cannot be traversed safely: a bug, reported rather than traced.
    #[error(
        "the {kind} built for the scene \"{}\" is unusable: {defect}; please report this scene",
        shown(scene)
    )]
    Unusable { scene: String, kind: BvhKind, defect: Defect },
}

/// Builds a hierarchy on the current rayon pool. The result depends on the scene and the kind
/// alone, not on the number of threads.
///
/// # Errors
/// [`BvhError`]: no triangles, too many of them for the format or the memory, coordinates out of range.
pub fn build(scene: &Scene, kind: BvhKind) -> Result<Bvh, BvhError> {
    let triangles = scene.triangles.len();
    memory::check(triangles as u64 * HIERARCHY_BYTES_PER_TRIANGLE, memory::free())
        .map_err(|source| BvhError::Memory { scene: scene.name.clone(), triangles, source })?;
    let boxes = boxes::padded(scene)?;
    let topology = topology::find(&boxes, kind);
    let bvh = match kind {
        BvhKind::Bvh2 => binary::flatten(&topology, &boxes),
        BvhKind::Cwbvh => compressed::flatten(topology, &boxes),
        BvhKind::Wide => wide::flatten(&topology, &boxes),
    };
    match validate(&bvh, scene) {
        Ok(()) => Ok(bvh),
        Err(defect) => Err(BvhError::Unusable { scene: scene.name.clone(), kind, defect }),
    }
}
