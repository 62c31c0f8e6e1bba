//! The scene's surfaces, in as much detail as pixels can show.
//!
//! Corners in the same cell of a grid are drawn in the middle of it (vertex clustering, Rossignac and Borrel
//! 1993), and triangles that have less than three corners left are not drawn. A cell is no larger than half a
//! pixel, so a corner moves by no more than a quarter of one along each axis. The cells of a grid are halved by
//! the next finer one: what one grid leaves out is left out by all coarser ones, so the triangles of a part are
//! sorted by that once, and of each part the beginning is drawn for any camera.

use std::ops::Range;

use formats::unit_space::UnitSpace;
use glam::{Vec3, Vec4};
use rayon::prelude::*;

use super::camera::Camera;

/// Grids: 0 is none, and number `grid` has cells of `2^(grid - FINEST_BITS)` unit lengths.
const GRIDS: usize = 16;
/// Of the cells of a unit length in the finest grid.
pub(super) const FINEST_BITS: i32 = 16;

/// Largest side of a cell, pixels.
const CELL: f32 = 0.5;

/// Triangles of a part: consecutive ones, which mostly are neighbours.
const TRIANGLES_PER_PART: usize = 4096;
/// Parts at most, each of which may be drawn by itself.
const PARTS: usize = 1024;

/// Triangles with three corners each, in parts.
#[derive(Clone, Debug, PartialEq)]
pub struct Surfaces {
    /// Corners, unit space.
    pub positions: Vec<[f32; 3]>,
    /// Colour of each, sRGB: the mean of its triangles'. Alpha is 0 where they have none.
    pub colours: Vec<[u8; 4]>,
    /// Three corners each; in each part, those first that more grids leave.
    pub triangles: Vec<[u32; 3]>,
    parts: Vec<Part>,
}

/// Consecutive triangles.
#[derive(Clone, Debug, PartialEq)]
struct Part {
    /// The box around them.
    low: Vec3,
    high: Vec3,
    first: u32,
    /// How many of them each grid leaves.
    left: [u32; GRIDS],
}

impl Surfaces {
    /// Of a scene in world space, with the colour of each triangle or of none. Triangles that name a corner that
    /// does not exist are left out.
    pub fn new(
        unit: &UnitSpace,
        positions: &[[f32; 3]],
        triangles: &[[u32; 3]],
        colours: &[[u8; 3]],
    ) -> Self {
        let (colours, (positions, triangles, parts)) = rayon::join(
            || of_corners(positions.len(), triangles, colours),
            || in_parts(unit, positions, triangles),
        );
        Self { positions, colours, triangles, parts }
    }

    /// What is drawn for a camera and a picture of so many pixels: triangles, and the grid that their corners
    /// are moved to.
    pub fn in_sight(
        &self,
        camera: &Camera,
        [width, height]: [u32; 2],
    ) -> impl Iterator<Item = (Range<u32>, u32)> {
        let aspect = width as f32 / height as f32;
        let clip_from_unit = camera.clip_from_unit(aspect);
        let (top, corner) = {
            let top = (0.5 * camera.yfov_radians).tan();
            (top, top * aspect.hypot(1.0))
        };
        // Of a pixel at depth 1; smaller by as much as things are drawn larger in the corners of the picture.
        let side = 2.0 * top / height as f32 / corner.hypot(1.0);
        self.parts.iter().filter_map(move |part| {
            let corners = part.corners().map(|corner| clip_from_unit * corner.extend(1.0));
            let beyond: [fn(&Vec4) -> bool; 5] =
                [|c| c.x > c.w, |c| c.x < -c.w, |c| c.y > c.w, |c| c.y < -c.w, |c| c.w < 0.0];
            if beyond.iter().any(|is_beyond| corners.iter().all(is_beyond)) {
                return None;
            }
            let nearest = corners.iter().map(|corner| corner.w).fold(f32::INFINITY, f32::min);
            let grid = grid_of(CELL * nearest * side);
            Some((part.first..part.first + part.left[grid], grid as u32))
        })
    }
}

/// Corners in unit space, and the triangles that have three, in parts.
fn in_parts(
    unit: &UnitSpace,
    positions: &[[f32; 3]],
    triangles: &[[u32; 3]],
) -> (Vec<[f32; 3]>, Vec<[u32; 3]>, Vec<Part>) {
    let exists = |triangle: &&[u32; 3]| triangle.iter().all(|&at| (at as usize) < positions.len());
    let mut triangles: Vec<[u32; 3]> = triangles.iter().filter(exists).copied().collect();
    let positions: Vec<[f32; 3]> = positions.iter().map(|&position| unit.point(position)).collect();
    let of_part = TRIANGLES_PER_PART.max(triangles.len().div_ceil(PARTS));
    let parts = triangles.par_chunks_mut(of_part).enumerate();
    let parts = parts.map(|(at, triangles)| Part::sort(&positions, triangles, at * of_part)).collect();
    (positions, triangles, parts)
}

/// The mean colour of the triangles at each corner: what a GPU draws without knowing the number of a triangle.
fn of_corners(corners: usize, triangles: &[[u32; 3]], colours: &[[u8; 3]]) -> Vec<[u8; 4]> {
    /// Triangles at a corner that count; their sums fit 16 bits.
    const MOST: u16 = 256;
    let mut sums = vec![[0u16; 4]; corners];
    for (triangle, &[red, green, blue]) in triangles.iter().zip(colours) {
        for &corner in triangle {
            let Some(sum) = sums.get_mut(corner as usize).filter(|sum| sum[3] < MOST) else { continue };
            for (part, of) in sum.iter_mut().zip([red, green, blue, 1]) {
                *part += u16::from(of);
            }
        }
    }
    let mean = |[red, green, blue, count]: [u16; 4]| match count {
        0 => [0; 4],
        count => {
            let [red, green, blue] = [red, green, blue].map(|sum| ((sum + count / 2) / count) as u8);
            [red, green, blue, 255]
        }
    };
    sums.into_iter().map(mean).collect()
}

/// The coarsest grid whose cells are no larger than this; none is needed for less than the finest.
fn grid_of(side: f32) -> usize {
    // Numbers below 0 and NaN become 0.
    ((side.log2() + FINEST_BITS as f32).floor() as usize).min(GRIDS - 1)
}

impl Part {
    /// Sorts the triangles of a part, which start at `first` of all.
    fn sort(positions: &[[f32; 3]], triangles: &mut [[u32; 3]], first: usize) -> Self {
        let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        let mut of_grids = [const { Vec::new() }; GRIDS + 1];
        for &triangle in &*triangles {
            let corners = triangle.map(|at| positions[at as usize]);
            for corner in corners.map(Vec3::from) {
                (low, high) = (low.min(corner), high.max(corner));
            }
            of_grids[grids_with(corners).min(GRIDS)].push(triangle);
        }
        let sorted = of_grids.iter().rev().flatten();
        triangles.iter_mut().zip(sorted).for_each(|(place, &triangle)| *place = triangle);
        let all = triangles.len();
        let left = |grid: usize| match grid {
            0 => all,
            grid => of_grids[grid + 1..].iter().map(Vec::len).sum(),
        };
        Self { low, high, first: first as u32, left: std::array::from_fn(|grid| left(grid) as u32) }
    }

    fn corners(&self) -> [Vec3; 8] {
        let along =
            |at: usize, axis: usize| if at >> axis & 1 == 1 { self.high[axis] } else { self.low[axis] };
        std::array::from_fn(|at| Vec3::new(along(at, 0), along(at, 1), along(at, 2)))
    }
}

/// How many grids, from the finest on, leave a triangle three corners.
fn grids_with(corners: [[f32; 3]; 3]) -> usize {
    let cells = (1u32 << FINEST_BITS) as f32;
    let [a, b, c] = corners.map(|corner| corner.map(|along| (along * cells) as u32));
    // Two cells fall together in the first grid that has none of the bits in which they differ.
    let apart = |a: [u32; 3], b: [u32; 3]| {
        let differing = (0..3).fold(0, |bits, axis| bits | a[axis] ^ b[axis]);
        (u32::BITS - differing.leading_zeros()) as usize
    };
    apart(a, b).min(apart(b, c)).min(apart(c, a))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    /// A sphere of radius 0.3 in the middle of unit space, as far from even as a scan is.
    fn ball(around: u32) -> Surfaces {
        let up = around / 2;
        let point = |column: u32, row: u32| {
            let (yaw, pitch) = (
                std::f32::consts::TAU * (column % around) as f32 / around as f32,
                std::f32::consts::PI * (row as f32 / up as f32).powi(2),
            );
            [
                0.5 + 0.3 * pitch.sin() * yaw.cos(),
                0.5 + 0.3 * pitch.cos(),
                0.5 + 0.3 * pitch.sin() * yaw.sin(),
            ]
        };
        let at = |column: u32, row: u32| row * around + column % around;
        let positions: Vec<_> =
            (0..=up).flat_map(|row| (0..around).map(move |column| point(column, row))).collect();
        let cells = (0..up).flat_map(|row| (0..around).map(move |column| (column, row)));
        let triangles: Vec<_> = cells
            .flat_map(|(i, j)| {
                [[at(i, j), at(i + 1, j), at(i, j + 1)], [at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]]
            })
            .collect();
        Surfaces::new(&UnitSpace::from_bounds([0.0; 3], [1.0; 3]), &positions, &triangles, &[])
    }

    fn camera(distance: f32) -> Camera {
        Camera { target: Vec3::splat(0.5), yaw: 0.4, pitch: -0.3, distance, yfov_radians: 0.6 }
    }

    #[test]
    fn what_is_drawn_are_the_triangles_with_three_cells() {
        let ball = ball(300);
        assert!(ball.parts.len() > 10);
        let mut grids = BTreeSet::new();
        for distance in [0.32, 0.6, 2.0, 30.0] {
            let mut drawn = 0;
            for (triangles, grid) in ball.in_sight(&camera(distance), [400, 300]) {
                grids.insert(grid);
                let cell = 2f64.powi(grid as i32 - 16);
                let part = ball.parts.iter().find(|part| part.first == triangles.start).unwrap();
                let end = (triangles.start as usize + TRIANGLES_PER_PART).min(ball.triangles.len());
                for at in triangles.start as usize..end {
                    let corners = ball.triangles[at].map(|at| ball.positions[at as usize]);
                    let cells: BTreeSet<[i64; 3]> = corners
                        .map(|corner| corner.map(|along| (f64::from(along) / cell).floor() as i64))
                        .into();
                    let is_drawn = (at as u32) < triangles.end;
                    assert!(grid == 0 || is_drawn == (cells.len() == 3), "{at} of grid {grid}: {cells:?}");
                    assert!(grid > 0 || is_drawn);
                    // No cell is larger than half a pixel where the triangle is nearest.
                    for corner in corners {
                        let corner = Vec3::from(corner);
                        assert!(corner.cmpge(part.low).all() && corner.cmple(part.high).all());
                        let depth = (corner - camera(distance).eye()).dot(camera(distance).forward());
                        let half_a_pixel = 0.3f32.tan() * depth / 300.0;
                        assert!(grid == 0 || cell as f32 <= half_a_pixel * 1.0001, "{cell} at {depth}");
                    }
                }
                drawn += triangles.len();
            }
            assert!(drawn > 0, "nothing is drawn at distance {distance}");
        }
        assert!(grids.len() > 3 && grids.contains(&0), "{grids:?}");
        let far: usize = ball.in_sight(&camera(30.0), [400, 300]).map(|(found, _)| found.len()).sum();
        assert!(far < ball.triangles.len() / 5, "{far} triangles for some pixels");
    }

    #[test]
    fn what_is_beside_or_behind_is_not_drawn() {
        let ball = ball(60);
        let drawn = |camera: Camera| ball.in_sight(&camera, [100, 100]).count();
        assert!(drawn(camera(3.0)) > 0);
        let mut away = camera(3.0);
        away.look(std::f32::consts::PI, 0.0);
        assert_eq!(drawn(away), 0);
        away.look(1.2, 0.0);
        assert_eq!(drawn(away), 0);
        // From inside, some of it is always seen.
        for step in 0..12 {
            let mut inside = camera(0.01);
            inside.look(step as f32, 0.1);
            assert!(drawn(inside) > 0, "step {step}");
        }
    }

    #[test]
    fn triangles_without_corners_are_left_out() {
        let unit = UnitSpace::from_bounds([0.0; 3], [2.0; 3]);
        let found = Surfaces::new(&unit, &[[0.0; 3], [2.0; 3], [1.0; 3]], &[[0, 1, 2], [0, 1, 3]], &[]);
        assert_eq!((found.positions[1], found.triangles.as_slice()), ([1.0; 3], &[[0, 1, 2]][..]));
        assert!(Surfaces::new(&unit, &[], &[[0, 1, 2]], &[]).parts.is_empty());
    }

    #[test]
    fn a_corner_has_the_mean_of_its_triangles_colours() {
        let triangles = [[0, 1, 2], [1, 2, 3], [2, 3, 9]];
        let found = of_corners(5, &triangles, &[[255, 0, 9], [0, 100, 9], [0, 50, 9]]);
        assert_eq!(found, [[255, 0, 9, 255], [128, 50, 9, 255], [85, 50, 9, 255], [0, 75, 9, 255], [0; 4]]);
        assert_eq!(of_corners(2, &triangles, &[]), [[0; 4]; 2]);
    }

    #[test]
    fn grids_are_counted_from_the_finest() {
        let cell = 2f32.powi(-FINEST_BITS);
        assert_eq!([0.0, 0.5 * cell, f32::NAN, -1.0].map(grid_of), [0; 4]);
        assert_eq!([cell, 1.9 * cell, 2.0 * cell, 1.0].map(grid_of), [0, 0, 1, GRIDS - 1]);
        assert_eq!(grids_with([[0.0; 3], [cell; 3], [2.0 * cell; 3]]), 1);
        assert_eq!(grids_with([[0.0; 3], [0.0; 3], [0.5; 3]]), 0);
    }
}
