//! The vertices of what is drawn, unit space. They are uploaded once, and drawn until they change.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use bytemuck::{Pod, Zeroable};
use formats::metrics::capsule::{Capsule, Point};
use formats::ray::Kind;

use super::surfaces::Surfaces;
use crate::model::Order;
use crate::model::path::PathRay;

/// A point with the number that it is coloured by; 16 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Vertex {
    /// Unit space.
    pub position: [f32; 3],
    /// NaN where it is not known.
    pub value: f32,
}

/// A capsule with the number that it is coloured by; 48 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct CapsuleInstance {
    /// Centre and radius of the sphere around the origins.
    pub origins: [f32; 4],
    /// Centre and radius of the sphere around the ends.
    pub ends: [f32; 4],
    /// NaN where it is not known.
    pub value: f32,
    /// Fills 48 bytes.
    pub padding: [f32; 3],
}

impl CapsuleInstance {
    /// Of a capsule as the analysis computes it.
    pub fn of(capsule: &Capsule, value: f32) -> Self {
        let sphere = |centre: Point, radius: f64| {
            let [x, y, z] = centre.map(|along| along as f32);
            [x, y, z, radius as f32]
        };
        Self {
            origins: sphere(capsule.origin_centre, capsule.origin_radius),
            ends: sphere(capsule.end_centre, capsule.end_radius),
            value,
            padding: [0.0; 3],
        }
    }
}

/// What is drawn.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// Surfaces.
    Mesh(Surfaces),
    /// One line through all points.
    Strip(Vec<Vertex>),
    /// A line between every two points.
    Segments(Vec<[Vertex; 2]>),
    /// Capsules.
    Capsules(Vec<CapsuleInstance>),
    /// Boxes by their lowest corner, which has the value, and their highest.
    Boxes(Vec<[Vertex; 2]>),
}

impl Shape {
    /// The edges of the triangles of surfaces, each once.
    pub fn edges(surfaces: &Surfaces) -> Self {
        let triangles = surfaces.triangles.iter();
        let mut edges: Vec<[u32; 2]> = triangles
            .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
            .map(|[a, b]| [a.min(b), a.max(b)])
            .collect();
        edges.sort_unstable();
        edges.dedup();
        let corner = |at: u32| Vertex { position: surfaces.positions[at as usize], value: 0.0 };
        Self::Segments(edges.into_iter().map(|edge| edge.map(corner)).collect())
    }

    /// Points from one line, mark or box to the next: lines of a strip share theirs.
    pub fn points_each(&self) -> u32 {
        if matches!(self, Self::Strip(_)) { 1 } else { 2 }
    }

    /// How many triangles, lines, boxes or capsules.
    pub fn len(&self) -> usize {
        match self {
            Self::Mesh(surfaces) => surfaces.triangles.len(),
            // A single point is no line.
            Self::Strip(points) => points.len().saturating_sub(1),
            Self::Segments(pairs) | Self::Boxes(pairs) => pairs.len(),
            Self::Capsules(capsules) => capsules.len(),
        }
    }

    /// Whether there is nothing to draw.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// What is drawn where a ray ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// A disc: a closest ray found a surface.
    Hit = 0,
    /// A ring: a closest ray found nothing, or a shadow ray its light.
    Miss = 1,
    /// A cross: a shadow ray found an occluder.
    Occluded = 2,
}

impl Mark {
    /// Of a ray of a kind.
    pub fn of(kind: Kind, is_at_surface: bool) -> Self {
        match (is_at_surface, kind) {
            (false, _) => Self::Miss,
            (true, Kind::Closest) => Self::Hit,
            (true, Kind::Shadow) => Self::Occluded,
        }
    }
}

/// A shape with a number of its own, by which the GPU knows whether it has it already.
#[derive(Clone, Debug)]
pub struct Geometry {
    id: u64,
    shape: Arc<Shape>,
}

impl PartialEq for Geometry {
    fn eq(&self, other: &Self) -> bool {
        self.id == other.id
    }
}

impl From<Shape> for Geometry {
    fn from(shape: Shape) -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        Self { id: NEXT.fetch_add(1, Ordering::Relaxed), shape: Arc::new(shape) }
    }
}

impl Geometry {
    /// Its number.
    pub fn id(&self) -> u64 {
        self.id
    }

    /// Its vertices.
    pub fn shape(&self) -> &Shape {
        &self.shape
    }
}

/// Which end of a ray.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RayEnd {
    /// Where it starts.
    #[default]
    Origin,
    /// Where it was found to end.
    Termination,
}

fn vertex(point: Point, value: f32) -> Vertex {
    Vertex { position: point.map(|along| along as f32), value }
}

/// The curve of an order: a vertex for each shown place with its value, in order.
pub fn curve(order: &Order, places: impl Iterator<Item = (usize, f32)>, end: RayEnd) -> Shape {
    let of = |(place, value): (usize, f32)| {
        let segment = order.queue.segment(order.places.ray(place));
        let point = match end {
            RayEnd::Origin => segment.origin,
            RayEnd::Termination => segment.end,
        };
        vertex(point, value)
    };
    Shape::Strip(places.map(of).collect())
}

/// Jumps of an order: a line from the origin at each of these places to that at the next one.
///
/// # Panics
/// If the last place of the order is one of them.
pub fn jumps(order: &Order, places: impl Iterator<Item = (usize, f32)>) -> Shape {
    let of = |(place, value): (usize, f32)| {
        [place, place + 1].map(|place| vertex(order.queue.segment(order.places.ray(place)).origin, value))
    };
    Shape::Segments(places.map(of).collect())
}

/// The axes of capsules: a line from the centre of the origins to that of the ends.
pub fn axes(capsules: &[CapsuleInstance]) -> Shape {
    let end = |[x, y, z, _]: [f32; 4], value| Vertex { position: [x, y, z], value };
    let axis =
        |capsule: &CapsuleInstance| [end(capsule.origins, capsule.value), end(capsule.ends, capsule.value)];
    Shape::Segments(capsules.iter().map(axis).collect())
}

/// The rays of an order: a line for each shown place with its value, from origin to end.
pub fn rays(order: &Order, places: impl Iterator<Item = (usize, f32)>) -> Shape {
    let of = |(place, value): (usize, f32)| {
        let segment = order.queue.segment(order.places.ray(place));
        [vertex(segment.origin, value), vertex(segment.end, value)]
    };
    Shape::Segments(places.map(of).collect())
}

/// Where shown rays end: the first point has the value of the place, the second the [`Mark`].
pub fn ends(order: &Order, places: impl Iterator<Item = (usize, f32)>) -> Shape {
    let of = |(place, value): (usize, f32)| {
        let ray = order.places.ray(place);
        let end = order.queue.segment(ray).end;
        [
            vertex(end, value),
            vertex(end, Mark::of(order.queue.id.kind, order.queue.is_at_surface(ray)) as u8 as f32),
        ]
    };
    Shape::Segments(places.map(of).collect())
}

/// A path's rays of one kind, each by its bounce: a line from origin to end, then the end as [`ends`] has it.
pub fn path(path: &[PathRay], kind: Kind) -> [Shape; 2] {
    let of_kind = || path.iter().filter(move |ray| ray.queue.kind == kind);
    let line =
        |ray: &PathRay| [ray.segment.origin, ray.segment.end].map(|end| vertex(end, ray.queue.bounce as f32));
    let mark = |ray: &PathRay| {
        let mark = Mark::of(kind, ray.is_at_surface) as u8 as f32;
        [ray.queue.bounce as f32, mark].map(|value| vertex(ray.segment.end, value))
    };
    [of_kind().map(line).collect(), of_kind().map(mark).collect()].map(Shape::Segments)
}

/// The lowest and the highest corner of a box, unit space.
pub type Corners = ([f32; 3], [f32; 3]);

/// Boxes with their values.
pub fn boxes(found: impl Iterator<Item = (Corners, f32)>) -> Shape {
    let corner = |position, value| Vertex { position, value };
    Shape::Boxes(found.map(|((low, high), value)| [corner(low, value), corner(high, value)]).collect())
}

/// The twelve edges of a box.
pub fn box_edges((low, high): Corners, value: f32) -> Vec<[Vertex; 2]> {
    let corner = |at: usize| {
        let along = |axis: usize| if at >> axis & 1 == 1 { high[axis] } else { low[axis] };
        Vertex { position: [along(0), along(1), along(2)], value }
    };
    let edge =
        |(at, axis): (usize, usize)| (at >> axis & 1 == 0).then(|| [corner(at), corner(at | 1 << axis)]);
    (0..8).flat_map(|at| (0..3).map(move |axis| (at, axis))).filter_map(edge).collect()
}

/// Corners of a capsule's surface as instances share them: which sphere (0 or 1), how far along its cap
/// (0 to 1, from the far pole of the first sphere to that of the second), cosine and sine around the axis.
pub fn capsule_template() -> (Vec<[f32; 4]>, Vec<u32>) {
    const RINGS: usize = 10;
    const AROUND: usize = 24;
    let ring = |ring: usize| {
        let (sphere, part) = (ring / RINGS, (ring % RINGS) as f32 / (RINGS - 1) as f32);
        (0..AROUND).map(move |at| {
            let (sine, cosine) = (at as f32 / AROUND as f32 * std::f32::consts::TAU).sin_cos();
            [sphere as f32, part, cosine, sine]
        })
    };
    let corner = |ring: usize, at: usize| (ring * AROUND + at % AROUND) as u32;
    let quad = |ring: usize, at: usize| {
        let [a, b] = [corner(ring, at), corner(ring, at + 1)];
        let [c, d] = [corner(ring + 1, at), corner(ring + 1, at + 1)];
        [a, b, c, b, d, c]
    };
    let indices = (0..2 * RINGS - 1).flat_map(|ring| (0..AROUND).flat_map(move |at| quad(ring, at)));
    ((0..2 * RINGS).flat_map(ring).collect(), indices.collect())
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use glam::DVec3;

    use super::*;

    /// The shader's formula in f64: a corner of the template on a capsule that lies along z.
    fn on_surface(capsule: &Capsule, [sphere, part, cosine, sine]: [f32; 4]) -> DVec3 {
        let Capsule { origin_centre, origin_radius, end_centre, end_radius } = *capsule;
        let apart = end_centre[2] - origin_centre[2];
        let tangent = ((origin_radius - end_radius) / apart).clamp(-1.0, 1.0).asin();
        let (centre, radius, low, high) = if sphere == 0.0 {
            (origin_centre, origin_radius, -FRAC_PI_2, tangent)
        } else {
            (end_centre, end_radius, tangent, FRAC_PI_2)
        };
        let (along, around) = (low + (high - low) * f64::from(part)).sin_cos();
        let across = DVec3::new(f64::from(cosine) * around, f64::from(sine) * around, along);
        DVec3::from(centre) + radius * across
    }

    #[test]
    fn the_template_spans_the_area_of_the_analysis() {
        for (origin_radius, end_radius, apart) in [(0.5, 0.5, 1.0), (0.2, 1.0, 2.0), (1.0, 0.0, 3.0)] {
            let capsule = Capsule {
                origin_centre: [0.1, 0.2, 0.3],
                origin_radius,
                end_centre: [0.1, 0.2, 0.3 + apart],
                end_radius,
            };
            let (corners, indices) = capsule_template();
            let points: Vec<DVec3> = corners.iter().map(|&corner| on_surface(&capsule, corner)).collect();
            let triangle = |corners: &[u32]| {
                let [a, b, c] = [0, 1, 2].map(|i| points[corners[i] as usize]);
                0.5 * (b - a).cross(c - a).length()
            };
            let area: f64 = indices.chunks(3).map(triangle).sum();
            assert!((area / capsule.area() - 1.0).abs() < 0.03, "{area} is not {}", capsule.area());
        }
    }

    #[test]
    fn a_box_has_twelve_edges_of_its_sides() {
        let edges = box_edges(([0.0, 0.0, 0.0], [1.0, 2.0, 4.0]), 3.0);
        let length =
            |[a, b]: &[Vertex; 2]| (0..3).map(|i| (b.position[i] - a.position[i]).abs()).sum::<f32>();
        let mut lengths: Vec<f32> = edges.iter().map(length).collect();
        lengths.sort_by(f32::total_cmp);
        assert_eq!(lengths, [1.0, 1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 2.0, 4.0, 4.0, 4.0, 4.0]);
    }
}
