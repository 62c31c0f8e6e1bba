//! Triangle lists: closed surfaces, spikes, slivers, degenerate and overlapping triangles.

use scenes::Scene;

use crate::numbers::Numbers;

/// Three corners.
pub(crate) type Triangle = [[f32; 3]; 3];

/// Where single precision has only sixty-fourths left.
pub(crate) const FAR_AWAY: [f32; 3] = [148_376.0, 1234.0, -223_423.0];

/// A scene of triangles, every corner a vertex of its own.
pub(crate) fn scene_of(name: &str, triangles: &[Triangle]) -> Scene {
    let indices = (0..triangles.len() as u32).map(|index| [3 * index, 3 * index + 1, 3 * index + 2]);
    Scene::of_geometry(name.into(), triangles.as_flattened().to_vec(), indices.collect())
}

/// Moves and scales every corner; corners that were equal stay equal.
pub(crate) fn placed(triangles: &[Triangle], scale: f32, centre: [f32; 3]) -> Vec<Triangle> {
    let place = |corner: [f32; 3]| [0, 1, 2].map(|axis| corner[axis] * scale + centre[axis]);
    triangles.iter().map(|triangle| triangle.map(place)).collect()
}

/// A closed surface around the origin, a grid of longitudes and latitudes. `radius` gives the distance of
/// the corner on a ring and a segment.
fn globe(rings: u32, segments: u32, radius: impl Fn(u32, u32) -> f64) -> Vec<Triangle> {
    let point = |ring: u32, segment: u32| {
        let segment = segment % segments;
        let is_pole = ring == 0 || ring == rings;
        let polar = std::f64::consts::PI * f64::from(ring) / f64::from(rings);
        let azimuth = std::f64::consts::TAU * f64::from(segment) / f64::from(segments);
        let size = radius(ring, if is_pole { 0 } else { segment });
        let sine = if is_pole { 0.0 } else { polar.sin() };
        [sine * azimuth.cos(), polar.cos(), sine * azimuth.sin()].map(|x| (x * size) as f32)
    };
    let mut triangles = Vec::new();
    for ring in 0..rings {
        for segment in 0..segments {
            let [a, b] = [point(ring, segment), point(ring, segment + 1)];
            let [c, d] = [point(ring + 1, segment), point(ring + 1, segment + 1)];
            if ring > 0 {
                triangles.push([a, b, c]);
            }
            if ring + 1 < rings {
                triangles.push([b, d, c]);
            }
        }
    }
    triangles
}

/// A closed sphere of radius 1.
pub(crate) fn sphere(rings: u32) -> Vec<Triangle> {
    globe(rings, 2 * rings, |_, _| 1.0)
}

/// A closed surface whose corners lie at 1 and at 4 in turn: needles around a ball.
pub(crate) fn spiky_sphere(rings: u32, segments: u32) -> Vec<Triangle> {
    globe(rings, segments, |ring, segment| if (ring + segment).is_multiple_of(2) { 4.0 } else { 1.0 })
}

/// A closed box, its faces cut along the given coordinates of each axis, ascending.
pub(crate) fn cut_box(cuts: [&[f32]; 3]) -> Vec<Triangle> {
    let mut triangles = Vec::new();
    for axis in 0..3 {
        let [along, up] = [(axis + 1) % 3, (axis + 2) % 3];
        for side in [cuts[axis][0], cuts[axis][cuts[axis].len() - 1]] {
            let corner = |i: usize, j: usize| {
                let mut corner = [side; 3];
                (corner[along], corner[up]) = (cuts[along][i], cuts[up][j]);
                corner
            };
            for i in 0..cuts[along].len() - 1 {
                for j in 0..cuts[up].len() - 1 {
                    let [a, b] = [corner(i, j), corner(i + 1, j)];
                    let [c, d] = [corner(i, j + 1), corner(i + 1, j + 1)];
                    triangles.extend([[a, b, d], [a, d, c]]);
                }
            }
        }
    }
    triangles
}

/// A closed cube from −1 to 1, each face of 2·n² triangles.
pub(crate) fn cube(n: u32) -> Vec<Triangle> {
    let cuts: Vec<f32> = (0..=n).map(|place| 2.0 * place as f32 / n as f32 - 1.0).collect();
    cut_box([&cuts; 3])
}

/// A closed cube from −1 to 1 whose sides are cut into strips of a 10-millionth of their length.
pub(crate) fn sliver_box() -> Vec<Triangle> {
    let strips = (0..=60u8).map(|strip| 0.25 + f32::from(strip) * 2e-7);
    let cuts: Vec<f32> = [-1.0].into_iter().chain(strips).chain([1.0]).collect();
    cut_box([&[-1.0, 1.0], &cuts, &[-1.0, 1.0]])
}

/// The same, turned, so that no strip lies along an axis.
pub(crate) fn turned_sliver_box() -> Vec<Triangle> {
    let turn = |[x, y, z]: [f32; 3]| {
        let [x, y, z] = [f64::from(x), f64::from(y), f64::from(z)];
        let (a, b) = (0.6 * x - 0.8 * y, 0.8 * x + 0.6 * y);
        [a, (5.0 * b - 12.0 * z) / 13.0, (12.0 * b + 5.0 * z) / 13.0].map(|x| x as f32)
    };
    sliver_box().into_iter().map(|triangle| triangle.map(turn)).collect()
}

/// Triangles about the unit cube, of a size in parts of it.
pub(crate) fn soup(numbers: &mut Numbers, count: usize, size: f32) -> Vec<Triangle> {
    let mut triangle = || {
        let centre = numbers.point();
        [0; 3].map(|_| {
            let offset = numbers.point();
            [0, 1, 2].map(|axis| centre[axis] + size * (offset[axis] - 0.5))
        })
    };
    (0..count).map(|_| triangle()).collect()
}

/// Needles and slivers of aspect 1e7 in all directions.
pub(crate) fn slivers(numbers: &mut Numbers, count: usize) -> Vec<Triangle> {
    let mut triangle = || {
        let (start, along, aside) = (numbers.point(), numbers.direction(), numbers.direction());
        let at =
            |far: f32, off: f32| [0, 1, 2].map(|axis| start[axis] + far * along[axis] + off * aside[axis]);
        let middle = numbers.unit();
        [at(0.0, 0.0), at(1.0, 0.0), at(middle, 1e-7)]
    };
    (0..count).map(|_| triangle()).collect()
}

/// Points, segments, twice and thrice the same triangle, and coplanar ones that overlap.
pub(crate) fn unclean(numbers: &mut Numbers) -> Vec<Triangle> {
    let mut triangles = soup(numbers, 300, 0.3);
    for index in 0..100 {
        let [a, b, _] = triangles[index];
        let middle = [0, 1, 2].map(|axis| 0.5 * (a[axis] + b[axis]));
        triangles.extend([[a, a, a], [a, b, b], [b, a, b], [a, b, middle]]);
        let [a, b, c] = triangles[index];
        triangles.extend([[a, b, c], [c, a, b], [b, a, c]]);
    }
    for _ in 0..300 {
        let z = numbers.below(3) as f32 / 2.0;
        triangles.push([0; 3].map(|_| [numbers.unit(), numbers.unit(), z]));
    }
    triangles
}

/// Triangles with corners on a coarse grid, so that they meet in edges and corners everywhere.
pub(crate) fn on_a_grid(numbers: &mut Numbers, count: usize) -> Vec<Triangle> {
    (0..count).map(|_| [0; 3].map(|_| [0; 3].map(|_: i32| numbers.below(5) as f32 / 4.0))).collect()
}
