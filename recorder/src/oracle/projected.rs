//! A triangle as a line sees it, and how far single precision may be off there.

use super::line::{Line, cross, dot, minus};

/// How far a ray may be off, in parts of the largest coordinate of a triangle's corners as seen from the
/// ray's origin: 16 roundings of f32. Moving and shearing a corner takes up to 6 in x and in y, 11 where a
/// device divides to 2.5 ulp.
pub const REACH: f64 = 1.0 / (1 << 20) as f64;

/// How far an f32's distance to a triangle may be off, in units of the direction's length.
pub(super) fn tolerance(line: &Line, corners: &[[f32; 3]; 3]) -> f64 {
    let projected = Projected::new(line, corners);
    let reach = projected.reach();
    let height = projected.height();
    let uncertain = if height <= reach {
        projected.edges().iter().map(|(_, edge)| dot(*edge, *edge).sqrt()).fold(0.0, f64::max)
    } else {
        (3.0 * reach / height).min(1.0) * projected.depth()
    };
    (reach + uncertain) / line.speed()
}

/// A triangle as a line sees it that comes from the origin along z.
pub(super) struct Projected {
    /// x, y, z.
    corners: [[f64; 3]; 3],
    /// Largest coordinate of a corner as seen from the line's origin, along the axes of the world.
    size: f64,
}

impl Projected {
    pub(super) fn new(line: &Line, corners: &[[f32; 3]; 3]) -> Self {
        let [along, across, up] = axes(line);
        let from_origin = corners.map(|corner| minus(corner.map(f64::from), line.origin));
        let size = from_origin.iter().flatten().fold(0.0f64, |most, x| most.max(x.abs()));
        Self { corners: from_origin.map(|v| [dot(v, across), dot(v, up), dot(v, along)]), size }
    }

    pub(super) fn reach(&self) -> f64 {
        self.size * REACH
    }

    /// Extent along the line.
    fn depth(&self) -> f64 {
        let depths = self.corners.map(|corner| corner[2]);
        depths.into_iter().fold(f64::NEG_INFINITY, f64::max)
            - depths.into_iter().fold(f64::INFINITY, f64::min)
    }

    /// Edges: start and vector.
    fn edges(&self) -> [([f64; 3], [f64; 3]); 3] {
        [0, 1, 2].map(|first| {
            let (p, q) = (self.corners[first], self.corners[(first + 1) % 3]);
            (p, minus(q, p))
        })
    }

    /// Smallest height in the plane across the line, 0 for a triangle seen from its edge.
    pub(super) fn height(&self) -> f64 {
        let edges = self.edges();
        let longest = edges.iter().map(|(_, edge)| length(*edge)).fold(0.0, f64::max);
        let area = twice_area(edges[0].1, edges[1].1).abs();
        if longest > 0.0 { area / longest } else { 0.0 }
    }

    /// The nearest of its points in the plane across the line; 0, 0 if it holds that.
    pub(super) fn nearest(&self) -> [f64; 2] {
        let sides = self.edges().map(|([x, y, _], edge)| twice_area(edge, [-x, -y, 0.0]));
        let is_inside = sides.iter().all(|side| *side > 0.0) || sides.iter().all(|side| *side < 0.0);
        if is_inside {
            return [0.0; 2];
        }
        let [x, y, _] = self.nearest_on_edges();
        [x, y]
    }

    /// The nearest point of its edges in the plane across the line, with its depth.
    pub(super) fn nearest_on_edges(&self) -> [f64; 3] {
        let on_edge = self.edges().map(|([x, y, z], [dx, dy, dz])| {
            let squared = dx * dx + dy * dy;
            let place = if squared > 0.0 { (-(x * dx + y * dy) / squared).clamp(0.0, 1.0) } else { 0.0 };
            [x + place * dx, y + place * dy, z + place * dz]
        });
        on_edge.into_iter().fold([f64::INFINITY; 3], |a, b| if length(b) < length(a) { b } else { a })
    }

    /// A point inside, by an eighth of the reach at most from the nearest one.
    pub(super) fn just_inside(&self, reach: f64) -> [f64; 2] {
        let [x, y] = self.nearest();
        let centre = [0, 1].map(|axis| self.corners.iter().map(|corner| corner[axis]).sum::<f64>() / 3.0);
        let inward = [centre[0] - x, centre[1] - y];
        let share = (reach / 8.0 / size(inward)).min(0.5);
        [x + share * inward[0], y + share * inward[1]]
    }
}

/// The line's unit direction and two unit vectors across it.
pub(super) fn axes(line: &Line) -> [[f64; 3]; 3] {
    let speed = line.speed();
    let along = line.direction.map(|x| x / speed);
    let size = along.map(f64::abs);
    let smallest = (0..3).min_by(|&a, &b| size[a].total_cmp(&size[b])).unwrap_or(0);
    let mut helper = [0.0; 3];
    helper[smallest] = 1.0;
    let across = cross(along, helper);
    let norm = dot(across, across).sqrt();
    let across = across.map(|x| x / norm);
    [along, across, cross(along, across)]
}

pub(super) fn size([x, y]: [f64; 2]) -> f64 {
    x.hypot(y)
}

/// Across the line.
fn length([x, y, _]: [f64; 3]) -> f64 {
    x.hypot(y)
}

/// Across the line.
fn twice_area(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}
