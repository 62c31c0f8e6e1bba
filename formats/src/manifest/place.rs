//! Where each array of a dump lies, and what it may look like there.
//!
//! These are the only paths that a reader ever opens, so no manifest can lead it elsewhere.

use std::fmt;

use bincode::{Decode, Encode};
use serde::Serialize;

use crate::key::method::is_method_name;
use crate::npy::Dtype;
use crate::ray::Kind;

/// A queue: the live rays of one pass, bounce and kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Encode, Decode, Serialize)]
pub struct QueueId {
    /// Pass, from 0.
    pub pass: u32,
    /// Bounce, from 0.
    pub bounce: u32,
    /// Kind of its rays.
    pub kind: Kind,
}

impl fmt::Display for QueueId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "pass-{:03}/bounce-{:02}/{}", self.pass, self.bounce, self.kind)
    }
}

/// The place of an array; shown as its path from the dump's folder, with `/` on every system.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Place {
    /// `scene/….npy`
    Scene(SceneArray),
    /// `image.npy`: f4 (H, W, 3), linear RGB.
    Image,
    /// `pass-PPP/bounce-BB/KIND/….npy`
    Queue(QueueId, QueueArray),
    /// `pass-PPP/bounce-BB/KIND/METHOD/….npy`
    Method(QueueId, String, MethodArray),
}

/// The arrays of the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum SceneArray {
    /// Vertices in world space, f4 (N, 3).
    Positions,
    /// Vertex indices, u4 (M, 3).
    Triangles,
    /// Material of each triangle, u4 (M,).
    Materials,
    /// Colour of each triangle as one recognises it, sRGB, u1 (M, 3).
    Colours,
    /// Texture coordinates of each vertex, f4 (N, 2); only with an alpha mask.
    Uvs,
    /// [`MaterialMask`](crate::npy::MaterialMask) of each material; only with an alpha mask.
    Masks,
    /// Lowest and highest corner of each child of each node of the hierarchy, f4 (N, 8, 6).
    NodeBoxes,
    /// What each child is, u4 (N, 8).
    NodeChildren,
    /// Triangle in each leaf slot, u4 (M,).
    LeafTriangles,
    /// An alpha texture, u1 (H, W).
    Mask(u32),
}

/// The arrays of a queue, in canonical order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum QueueArray {
    /// [`Ray`](crate::ray::Ray)s.
    Rays,
    /// Path index of each ray, u4, ascending: the pixel, row by row from the top.
    PathIds,
    /// [`Hit`](crate::ray::Hit)s of closest rays.
    Hits,
    /// Distance of each shadow ray to the occluder that was found, f4; `+inf` if the light is seen.
    Distances,
    /// Index of each shadow ray's light, u4.
    Lights,
    /// [`Work`](crate::ray::Work) of the trace kernel.
    Work,
    /// What the path of each closest ray carries as the ray leaves: linear RGB, f4 (N, 3).
    Throughput,
    /// Touched cells of the length table of this kind, as the methods of this queue read it.
    Lengths,
    /// The same after this queue's lengths were added: the last state, with the last queue of its kind.
    FinalLengths,
}

/// The arrays of a method.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum MethodArray {
    /// Key of each ray in canonical order, u4 up to 32 bits, else u8.
    Keys,
    /// Canonical index of the ray at each place of the sorted order, u4.
    Permutation,
}

impl QueueArray {
    /// Every array of a queue.
    pub const ALL: [Self; 9] = [
        Self::Rays,
        Self::PathIds,
        Self::Hits,
        Self::Distances,
        Self::Lights,
        Self::Work,
        Self::Throughput,
        Self::Lengths,
        Self::FinalLengths,
    ];

    /// What rays of this kind found.
    pub fn results(kind: Kind) -> Self {
        match kind {
            Kind::Closest => Self::Hits,
            Kind::Shadow => Self::Distances,
        }
    }

    /// File name without its extension.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rays => "rays",
            Self::PathIds => "path_ids",
            Self::Hits => "hits",
            Self::Distances => "distances",
            Self::Lights => "lights",
            Self::Work => "work",
            Self::Throughput => "throughput",
            Self::Lengths => "lengths",
            Self::FinalLengths => "final-lengths",
        }
    }

    /// Whether it has one element per ray of the queue.
    pub fn is_per_ray(self) -> bool {
        !matches!(self, Self::Lengths | Self::FinalLengths)
    }

    /// Whether queues of this kind have it.
    pub fn applies_to(self, kind: Kind) -> bool {
        match self {
            Self::Hits | Self::Throughput => kind == Kind::Closest,
            Self::Distances | Self::Lights => kind == Kind::Shadow,
            _ => true,
        }
    }

    fn dtypes(self) -> &'static [Dtype] {
        match self {
            Self::Rays => &[Dtype::Ray],
            Self::PathIds | Self::Lights => &[Dtype::U4],
            Self::Hits => &[Dtype::Hit],
            Self::Distances | Self::Throughput => &[Dtype::F4],
            Self::Work => &[Dtype::Work],
            Self::Lengths | Self::FinalLengths => &[Dtype::Cell],
        }
    }
}

impl MethodArray {
    /// Every array of a method.
    pub const ALL: [Self; 2] = [Self::Keys, Self::Permutation];

    /// File name without its extension.
    pub fn name(self) -> &'static str {
        match self {
            Self::Keys => "keys",
            Self::Permutation => "permutation",
        }
    }
}

impl SceneArray {
    const NAMED: [(Self, &str); 9] = [
        (Self::Positions, "positions"),
        (Self::Triangles, "triangles"),
        (Self::Materials, "materials"),
        (Self::Colours, "colours"),
        (Self::Uvs, "uvs"),
        (Self::Masks, "masks"),
        (Self::NodeBoxes, "node_boxes"),
        (Self::NodeChildren, "node_children"),
        (Self::LeafTriangles, "leaf_triangles"),
    ];

    fn dtypes(self) -> &'static [Dtype] {
        match self {
            Self::Positions | Self::Uvs | Self::NodeBoxes => &[Dtype::F4],
            Self::Triangles | Self::Materials | Self::NodeChildren | Self::LeafTriangles => &[Dtype::U4],
            Self::Masks => &[Dtype::Mask],
            Self::Colours | Self::Mask(_) => &[Dtype::U1],
        }
    }
}

/// A length that is free, or the number of columns that it must be.
type Dimension = Option<u64>;

impl Place {
    /// The word among [`Options::keep`](crate::manifest::Options::keep) with which an array is kept.
    pub fn kept_with(&self) -> &'static str {
        match self {
            Self::Scene(SceneArray::NodeBoxes | SceneArray::NodeChildren | SceneArray::LeafTriangles) => {
                "hierarchy"
            }
            Self::Scene(_) => "scene",
            Self::Image => "image",
            Self::Queue(_, QueueArray::Rays | QueueArray::PathIds | QueueArray::Lights) => "rays",
            Self::Queue(_, QueueArray::Hits | QueueArray::Distances) => "hits",
            Self::Queue(_, QueueArray::Work) => "work",
            Self::Queue(_, QueueArray::Throughput) => "throughput",
            Self::Queue(_, QueueArray::Lengths | QueueArray::FinalLengths) => "lengths",
            Self::Method(_, _, MethodArray::Keys) => "keys",
            Self::Method(_, _, MethodArray::Permutation) => "permutations",
        }
    }

    /// The place that a path names; `None` for every other path, whatever it is.
    pub fn parse(path: &str) -> Option<Self> {
        let parts: Vec<&str> = path.strip_suffix(".npy")?.split('/').collect();
        let place = match *parts.as_slice() {
            ["image"] => Self::Image,
            ["scene", name] => Self::Scene(parse_scene_array(name)?),
            [pass, bounce, kind, name] => {
                let queue = parse_queue(pass, bounce, kind)?;
                let is_meant = |array: &QueueArray| array.name() == name && array.applies_to(queue.kind);
                Self::Queue(queue, QueueArray::ALL.into_iter().find(is_meant)?)
            }
            [pass, bounce, kind, method, name] => {
                let array = MethodArray::ALL.into_iter().find(|array| array.name() == name)?;
                is_method_name(method).then_some(())?;
                Self::Method(parse_queue(pass, bounce, kind)?, method.to_owned(), array)
            }
            _ => return None,
        };
        // Only one spelling of each place, so that no two records can mean one file.
        (place.to_string() == path).then_some(place)
    }

    /// The element types that an array here may have.
    fn dtypes(&self) -> &'static [Dtype] {
        match self {
            Self::Image => &[Dtype::F4],
            Self::Scene(array) => array.dtypes(),
            Self::Queue(_, array) => array.dtypes(),
            Self::Method(_, _, MethodArray::Keys) => &[Dtype::U4, Dtype::U8],
            Self::Method(_, _, MethodArray::Permutation) => &[Dtype::U4],
        }
    }

    /// Whether an array here may have this element type and shape.
    pub fn allows(&self, dtype: Dtype, shape: &[u64]) -> bool {
        let dimensions = self.dimensions();
        self.dtypes().contains(&dtype)
            && shape.len() == dimensions.len()
            && dimensions.iter().zip(shape).all(|(fixed, length)| fixed.is_none_or(|fixed| fixed == *length))
    }

    /// What an array here looks like, in words: `<f4 (N, 3)`.
    pub fn expectation(&self) -> String {
        let dtypes: Vec<_> = self.dtypes().iter().map(|dtype| dtype.descr()).collect();
        let lengths = self.dimensions().iter().map(|dimension| match dimension {
            Some(length) => length.to_string(),
            None => "N".to_owned(),
        });
        format!("{} ({})", dtypes.join(" or "), lengths.collect::<Vec<_>>().join(", "))
    }

    /// The queue that it belongs to.
    pub fn queue(&self) -> Option<QueueId> {
        match self {
            Self::Scene(_) | Self::Image => None,
            Self::Queue(queue, _) | Self::Method(queue, ..) => Some(*queue),
        }
    }

    fn dimensions(&self) -> &'static [Dimension] {
        match self {
            Self::Image => &[None, None, Some(3)],
            Self::Scene(SceneArray::Positions | SceneArray::Triangles | SceneArray::Colours)
            | Self::Queue(_, QueueArray::Throughput) => &[None, Some(3)],
            Self::Scene(SceneArray::Uvs) => &[None, Some(2)],
            Self::Scene(SceneArray::NodeBoxes) => &[None, Some(8), Some(6)],
            Self::Scene(SceneArray::NodeChildren) => &[None, Some(8)],
            Self::Scene(SceneArray::Mask(_)) => &[None, None],
            _ => &[None],
        }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Image => f.write_str("image.npy"),
            Self::Scene(SceneArray::Mask(number)) => write!(f, "scene/mask-{number:03}.npy"),
            Self::Scene(array) => {
                let named = SceneArray::NAMED.iter().find(|(named, _)| named == array);
                write!(f, "scene/{}.npy", named.map_or("", |(_, name)| name))
            }
            Self::Queue(queue, array) => write!(f, "{queue}/{}.npy", array.name()),
            Self::Method(queue, method, array) => write!(f, "{queue}/{method}/{}.npy", array.name()),
        }
    }
}

fn parse_scene_array(name: &str) -> Option<SceneArray> {
    if let Some(number) = name.strip_prefix("mask-") {
        return number.parse().ok().map(SceneArray::Mask);
    }
    SceneArray::NAMED.iter().find(|(_, known)| *known == name).map(|(array, _)| *array)
}

fn parse_queue(pass: &str, bounce: &str, kind: &str) -> Option<QueueId> {
    Some(QueueId {
        pass: pass.strip_prefix("pass-")?.parse().ok()?,
        bounce: bounce.strip_prefix("bounce-")?.parse().ok()?,
        kind: Kind::ALL.into_iter().find(|known| known.name() == kind)?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_place_comes_back_from_its_path() {
        let queue = QueueId { pass: 3, bounce: 2, kind: Kind::Closest };
        let shadow = QueueId { kind: Kind::Shadow, pass: 1234, bounce: 100 };
        let mut places =
            vec![Place::Image, Place::Scene(SceneArray::Mask(0)), Place::Scene(SceneArray::Mask(1000))];
        places.extend(SceneArray::NAMED.map(|(array, _)| Place::Scene(array)));
        for queue in [queue, shadow] {
            let fitting = QueueArray::ALL.into_iter().filter(|array| array.applies_to(queue.kind));
            places.extend(fitting.map(|array| Place::Queue(queue, array)));
            places.extend(MethodArray::ALL.map(|array| Place::Method(queue, "two-point".into(), array)));
        }
        for place in places {
            assert_eq!(Place::parse(&place.to_string()), Some(place.clone()), "{place}");
        }
        assert_eq!(
            Place::Queue(queue, QueueArray::PathIds).to_string(),
            "pass-003/bounce-02/closest/path_ids.npy"
        );
        assert_eq!(
            Place::Method(queue, "reis".into(), MethodArray::Keys).to_string(),
            "pass-003/bounce-02/closest/reis/keys.npy"
        );
    }

    #[test]
    fn no_other_path_is_a_place() {
        for path in [
            "",
            "/etc/passwd",
            "../x.npy",
            "scene/../image.npy",
            "/image.npy",
            "./image.npy",
            "image.npy/",
            "image.npy\0",
            "IMAGE.npy",
            "scene/mask-0.npy",
            "scene/mask-+01.npy",
            "scene\\positions.npy",
            "pass-3/bounce-02/closest/rays.npy",
            "pass-0003/bounce-02/closest/rays.npy",
            "pass-003/bounce-02/shadow/hits.npy",
            "pass-003/bounce-02/closest/lights.npy",
            "pass-003/bounce-02/closest/../keys.npy",
            "pass-003/bounce-02/closest//keys.npy",
            "pass-003/bounce-02/closest/Aux/keys.npy",
            "pass-003/bounce-02/closest/a/b/keys.npy",
            "pass-99999999999/bounce-02/closest/rays.npy",
        ] {
            assert_eq!(Place::parse(path), None, "{path:?}");
        }
    }

    #[test]
    fn shapes_and_types_are_held() {
        let positions = Place::Scene(SceneArray::Positions);
        assert!(positions.allows(Dtype::F4, &[0, 3]) && positions.allows(Dtype::F4, &[9, 3]));
        for (dtype, shape) in
            [(Dtype::U4, &[9, 3][..]), (Dtype::F4, &[9, 4]), (Dtype::F4, &[27]), (Dtype::F4, &[])]
        {
            assert!(!positions.allows(dtype, shape), "{dtype} {shape:?}");
        }
        assert_eq!(positions.expectation(), "<f4 (N, 3)");
        let queue = QueueId { pass: 0, bounce: 0, kind: Kind::Closest };
        let keys = Place::Method(queue, "reis".into(), MethodArray::Keys);
        assert!(
            keys.allows(Dtype::U4, &[5]) && keys.allows(Dtype::U8, &[5]) && !keys.allows(Dtype::F4, &[5])
        );
    }
}
