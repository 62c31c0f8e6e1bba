//! Triangle lists: spikes, slivers, degenerate and overlapping triangles.

use scenes::Scene;
pub(crate) use tests::shapes::{Triangle, cube, cut_box, globe, placed, sphere};

use crate::numbers::Numbers;

/// Where single precision has only sixty-fourths left.
pub(crate) const FAR_AWAY: [f32; 3] = [148_376.0, 1234.0, -223_423.0];

/// A scene of triangles, every corner a vertex of its own.
pub(crate) fn scene_of(name: &str, triangles: &[Triangle]) -> Scene {
    let indices = (0..triangles.len() as u32).map(|index| [3 * index, 3 * index + 1, 3 * index + 2]);
    Scene::of_geometry(name.into(), triangles.as_flattened().to_vec(), indices.collect())
}

/// A closed surface whose corners lie at 1 and at 4 in turn: needles around a ball.
pub(crate) fn spiky_sphere(rings: u32, segments: u32) -> Vec<Triangle> {
    globe(rings, segments, |ring, segment| if (ring + segment).is_multiple_of(2) { 4.0 } else { 1.0 })
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
