//! The strokes that built-in scenes are drawn with: patches, blocks, lathe work, tubes, sheets.
//!
//! Each is drawn in a frame, in metres. Seen from outside, all triangles run counter-clockwise.

use glam::{DAffine3, DMat3, DVec2, DVec3, dvec2, dvec3};

use super::canvas::{Canvas, Vertex};
use super::numbers::sin_cos;
use crate::Scene;

/// The space that a stroke is drawn in, as the way from there to world space.
pub(super) type Frame = DAffine3;

/// A frame that stands at a point and is turned about the vertical by so many turns.
pub(super) fn place(x: f64, y: f64, z: f64, turns: f64) -> Frame {
    let (sine, cosine) = sin_cos(turns);
    let rotation = DMat3::from_cols(dvec3(cosine, 0.0, -sine), DVec3::Y, dvec3(sine, 0.0, cosine));
    Frame::from_mat3_translation(rotation, dvec3(x, y, z))
}

/// A frame at the origin, turned about its own x axis by so many turns (y towards z).
pub(super) fn tilt(turns: f64) -> Frame {
    let (sine, cosine) = sin_cos(turns);
    Frame::from_mat3(DMat3::from_cols(DVec3::X, dvec3(0.0, cosine, sine), dvec3(0.0, -sine, cosine)))
}

/// A frame at the origin that shrinks or stretches along the axes; all factors > 0.
pub(super) fn stretch(x: f64, y: f64, z: f64) -> Frame {
    Frame::from_mat3(DMat3::from_diagonal(dvec3(x, y, z)))
}

/// So many steps along the curve `point` over [0, 1].
pub(super) fn path(steps: u32, point: impl Fn(f64) -> DVec3) -> Vec<DVec3> {
    (0..=steps).map(|step| point(f64::from(step) / f64::from(steps))).collect()
}

/// Whether the vertices of a surface get normals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shading {
    /// No normals: the facets show.
    Flat,
    /// Normals averaged over the neighbouring facets.
    Smooth,
}

/// A rectangular net of vertices, `columns + 1` by `rows + 1`, row by row.
struct Net {
    columns: u32,
    rows: u32,
    /// Whether all vertices of the first and of the last row are one point.
    poles: [bool; 2],
    vertices: Vec<Vertex>,
}

/// How many triangles a net has: two a cell, one a cell next to a pole.
fn net_count([columns, rows]: [u32; 2], poles: [bool; 2]) -> u64 {
    let columns = u64::from(columns);
    2 * columns * u64::from(rows) - columns * (u64::from(poles[0]) + u64::from(poles[1]))
}

impl Net {
    fn new([columns, rows]: [u32; 2], poles: [bool; 2], vertex: impl Fn(u32, u32) -> Vertex) -> Self {
        let places = (0..=rows).flat_map(|row| (0..=columns).map(move |column| (column, row)));
        let vertices = places.map(|(column, row)| vertex(column, row)).collect();
        Self { columns, rows, poles, vertices }
    }

    /// The triangles, as places in `vertices`.
    fn triangles(&self) -> impl Iterator<Item = [u32; 3]> {
        let stride = self.columns + 1;
        (0..self.rows).flat_map(move |row| {
            let first = row == 0 && self.poles[0];
            let last = row + 1 == self.rows && self.poles[1];
            (0..self.columns).flat_map(move |column| {
                let a = row * stride + column;
                let (b, c, d) = (a + 1, a + 1 + stride, a + stride);
                let lower = (!first).then_some([a, b, c]);
                let upper = (!last).then_some([a, c, d]);
                lower.into_iter().chain(upper)
            })
        })
    }

    /// Gives every vertex the mean of its facets' normals, across seams and around poles too.
    fn smooth(&mut self) {
        let mut sums = vec![DVec3::ZERO; self.vertices.len()];
        for corners in self.triangles() {
            let [a, b, c] = corners.map(|index| self.vertices[index as usize].position);
            let normal = (b - a).cross(c - a);
            for index in corners {
                sums[index as usize] += normal;
            }
        }
        let (columns, rows) = (self.columns as usize, self.rows as usize);
        let stride = columns + 1;
        for (row, _) in [0, rows].into_iter().zip(self.poles).filter(|(_, is_pole)| *is_pole) {
            let around = row * stride..(row + 1) * stride;
            let sum = sums[around.clone()].iter().sum::<DVec3>();
            sums[around].fill(sum);
        }
        // After the poles: their sums must not count what the ends of a row share twice.
        for row in 0..=rows {
            let ends = [row * stride, row * stride + columns];
            if self.vertices[ends[0]].position == self.vertices[ends[1]].position {
                let sum = sums[ends[0]] + sums[ends[1]];
                sums[ends[0]] = sum;
                sums[ends[1]] = sum;
            }
        }
        for (vertex, sum) in self.vertices.iter_mut().zip(sums) {
            vertex.normal = sum.normalize_or_zero();
        }
    }

    fn write(&self, scene: &mut Scene, material: u32) {
        let first = scene.positions.len() as u32;
        for vertex in &self.vertices {
            scene.push_vertex(*vertex);
        }
        for corners in self.triangles() {
            scene.push_triangle(material, corners.map(|index| first + index));
        }
    }
}

/// Two triangles between four corners in world space, counter-clockwise, with the whole texture.
pub(super) fn quad(scene: &mut Scene, material: u32, corners: [DVec3; 4]) {
    const UVS: [DVec2; 4] = [dvec2(0.0, 1.0), dvec2(1.0, 1.0), dvec2(1.0, 0.0), dvec2(0.0, 0.0)];
    let [a, b, c, d] = [0, 1, 2, 3].map(|corner| {
        scene.push_vertex(Vertex { position: corners[corner], normal: DVec3::ZERO, uv: UVS[corner] })
    });
    scene.push_triangle(material, [a, b, c]);
    scene.push_triangle(material, [a, c, d]);
}

impl Canvas {
    /// A flat or twisted patch between four corners, counter-clockwise, cut into `cells` along the
    /// first and the second edge.
    pub(super) fn patch(&mut self, material: u32, frame: &Frame, corners: [DVec3; 4], cells: [u32; 2]) {
        let [a, b, c, d] = corners.map(|corner| frame.transform_point3(corner));
        // The corners are in world space.
        self.surface(material, &Frame::IDENTITY, cells, [false; 2], Shading::Flat, |u, v| {
            let near = a + (b - a) * u;
            let far = d + (c - d) * u;
            near + (far - near) * v
        });
    }

    /// A horizontal rectangle that faces upwards, given as least x and z, then greatest x and z.
    pub(super) fn flat(&mut self, material: u32, frame: &Frame, sides: [f64; 4], y: f64) {
        let [left, back, right, front] = sides;
        let corners = [(left, front), (right, front), (right, back), (left, back)];
        self.patch(material, frame, corners.map(|(x, z)| dvec3(x, y, z)), [1, 1]);
    }

    /// A surface over the unit square, cut into `columns` by `rows` cells, with vertex normals
    /// along `∂point/∂u × ∂point/∂v`.
    pub(super) fn sheet(
        &mut self,
        material: u32,
        frame: &Frame,
        cells: [u32; 2],
        point: impl Fn(f64, f64) -> DVec3,
    ) {
        self.surface(material, frame, cells, [false; 2], Shading::Smooth, point);
    }

    /// The same, with a say in normals, and with edges at v = 0 and v = 1 that are one point each
    /// where `poles` says so.
    pub(super) fn surface(
        &mut self,
        material: u32,
        frame: &Frame,
        [columns, rows]: [u32; 2],
        poles: [bool; 2],
        shading: Shading,
        point: impl Fn(f64, f64) -> DVec3,
    ) {
        self.draw(net_count([columns, rows], poles), |scene| {
            let mut net = Net::new([columns, rows], poles, |column, row| {
                let (u, v) = (f64::from(column) / f64::from(columns), f64::from(row) / f64::from(rows));
                let position = frame.transform_point3(point(u, v));
                Vertex { position, normal: DVec3::ZERO, uv: dvec2(u, 1.0 - v) }
            });
            if shading == Shading::Smooth {
                net.smooth();
            }
            net.write(scene, material);
        });
    }

    /// A block with sharp edges between two corners; 12 triangles.
    pub(super) fn block(&mut self, material: u32, frame: &Frame, low: [f64; 3], high: [f64; 3]) {
        let low = DVec3::from(low);
        let extent = DVec3::from(high) - low;
        let [x, y, z] = DVec3::AXES.map(|axis| extent * axis);
        self.draw(12, |scene| {
            for [origin, first, second] in
                [[low, y, x], [low + z, x, y], [low, z, y], [low + x, y, z], [low, x, z], [low + y, z, x]]
            {
                let corners = [origin, origin + first, origin + first + second, origin + second];
                quad(scene, material, corners.map(|corner| frame.transform_point3(corner)));
            }
        });
    }

    /// Mouldings around a rectangle between two corners (x and z) in the plane y = 0: ledges,
    /// cornices, parapets. The profile runs through (distance beyond the rectangle, height) points,
    /// upwards along the outside; each of its spans is 8 triangles.
    pub(super) fn band(&mut self, material: u32, frame: &Frame, corners: [DVec2; 2], profile: &[[f64; 2]]) {
        let around = |&[out, y]: &[f64; 2]| {
            let (low, high) = (corners[0] - out, corners[1] + out);
            [(low.x, high.y), (high.x, high.y), (high.x, low.y), (low.x, low.y)]
                .map(|(x, z)| frame.transform_point3(dvec3(x, y, z)))
        };
        self.draw(8 * (profile.len() as u64 - 1), |scene| {
            for span in profile.windows(2) {
                let (below, above) = (around(&span[0]), around(&span[1]));
                for here in 0..4 {
                    let next = (here + 1) % 4;
                    quad(scene, material, [below[here], below[next], above[next], above[here]]);
                }
            }
        });
    }

    /// A four-sided frame between two corners whose sides are `thickness` thick, open along y.
    pub(super) fn ring(&mut self, material: u32, frame: &Frame, [low, high]: [[f64; 3]; 2], thickness: f64) {
        let (foot, top) = (low[1], high[1]);
        let profile = [[-thickness, foot], [0.0, foot], [0.0, top], [-thickness, top], [-thickness, foot]];
        self.band(material, frame, [dvec2(low[0], low[2]), dvec2(high[0], high[2])], &profile);
    }

    /// A block with edges of this radius, each cut into `2 · steps` facets, in a frame that does
    /// not stretch: cushions, mattresses, appliances. `12 · (2 · steps + 1)²` triangles.
    pub(super) fn rounded_block(
        &mut self,
        material: u32,
        frame: &Frame,
        [low, high]: [[f64; 3]; 2],
        radius: f64,
        steps: u32,
    ) {
        let cells = [2 * steps + 1; 2];
        let low = DVec3::from(low);
        let half = 0.5 * (DVec3::from(high) - low);
        // A little of each side stays flat, or its facets would have no area.
        let radius = radius.min(0.95 * half.min_element());
        let centre = low + half;
        let core = half - radius;
        // Index 0 … steps runs over the near edge, steps + 1 … 2·steps + 1 over the far one.
        let along = |index: u32| {
            if index <= steps {
                (-1.0, f64::from(index) / f64::from(steps) - 1.0)
            } else {
                (1.0, f64::from(index - steps - 1) / f64::from(steps))
            }
        };
        let axes = DVec3::AXES;
        self.draw(6 * net_count(cells, [false; 2]), |scene| {
            for (side, axis) in [0, 1, 2, 0, 1, 2].into_iter().enumerate() {
                let (next, last) = (axes[(axis + 1) % 3], axes[(axis + 2) % 3]);
                let [out, first, second] =
                    if side < 3 { [axes[axis], next, last] } else { [-axes[axis], last, next] };
                let net = Net::new(cells, [false; 2], |column, row| {
                    let ((row_side, row_slope), (column_side, column_slope)) = (along(row), along(column));
                    let normal = (out + first * column_slope + second * row_slope).normalize();
                    let corner = core * (out + first * column_side + second * row_side);
                    Vertex {
                        position: frame.transform_point3(centre + corner + normal * radius),
                        normal: frame.transform_vector3(normal).normalize(),
                        uv: dvec2(0.5 + 0.5 * column_slope, 0.5 - 0.5 * row_slope),
                    }
                });
                net.write(scene, material);
            }
        });
    }

    /// Lathe work about the y axis. Each piece of the profile is a smooth curve through (radius,
    /// height) points, with a crease between pieces; it runs upwards along the outside. A radius of
    /// 0 closes the end. A piece of two points is straight; longer ones are cut into `rows` per
    /// span.
    pub(super) fn revolve(&mut self, material: u32, frame: &Frame, pieces: &[&[[f64; 2]]], facets: [u32; 2]) {
        let [around, rows] = facets;
        for piece in pieces {
            let spans = piece.len() as u32 - 1;
            let poles = [piece[0][0] == 0.0, piece[piece.len() - 1][0] == 0.0];
            let needed = 1 + u32::from(poles[0] && poles[1]);
            let rows = if spans == 1 { needed } else { (rows * spans).max(needed) };
            self.surface(material, frame, [around, rows], poles, Shading::Smooth, |u, v| {
                let [radius, height] = curve(piece, v);
                let (sine, cosine) = sin_cos(u);
                dvec3(radius * cosine, height, -radius * sine)
            });
        }
    }

    /// A tube along `path` (at least two points, no two neighbours equal), `around` facets around.
    /// `radius` is given by the place along the path, 0 to 1; where it is 0 at an end, the tube ends
    /// in a point, else it is open.
    pub(super) fn tube(
        &mut self,
        material: u32,
        frame: &Frame,
        path: &[DVec3],
        radius: impl Fn(f64) -> f64,
        around: u32,
    ) {
        let rows = path.len() as u32 - 1;
        let poles = [radius(0.0) == 0.0, radius(1.0) == 0.0];
        self.draw(net_count([around, rows], poles), |scene| {
            let path: Vec<DVec3> = path.iter().map(|&point| frame.transform_point3(point)).collect();
            let tangent = |row: usize| {
                let (before, after) = (row.saturating_sub(1), (row + 1).min(path.len() - 1));
                (path[after] - path[before]).normalize_or(DVec3::Y)
            };
            let mut side = tangent(0).any_orthonormal_vector();
            let rings: Vec<[DVec3; 2]> = (0..path.len())
                .map(|row| {
                    let forward = tangent(row);
                    // Carried along from ring to ring, so that the tube does not twist.
                    side =
                        (side - forward * side.dot(forward)).normalize_or(forward.any_orthonormal_vector());
                    [side, forward.cross(side)]
                })
                .collect();
            let net = Net::new([around, rows], poles, |column, row| {
                let (u, v) = (f64::from(column) / f64::from(around), f64::from(row) / f64::from(rows));
                let [side, other] = rings[row as usize];
                let (sine, cosine) = sin_cos(u);
                let normal = side * cosine + other * sine;
                Vertex { position: path[row as usize] + normal * radius(v), normal, uv: dvec2(u, 1.0 - v) }
            });
            net.write(scene, material);
        });
    }
}

/// The point at `t` in [0, 1] on the Catmull-Rom curve through `points` (at least two); with two
/// a straight line. A radius (the first coordinate) never falls below 0.
fn curve(points: &[[f64; 2]], t: f64) -> [f64; 2] {
    let spans = points.len() - 1;
    let scaled = t * spans as f64;
    let span = (scaled as usize).min(spans - 1);
    let local = scaled - span as f64;
    let at = |index: usize| DVec2::from(points[index.min(spans)]);
    let (start, end) = (at(span), at(span + 1));
    if local == 0.0 || local == 1.0 || spans == 1 {
        let point = start + (end - start) * local;
        // Ends are met exactly, so that a pole is a single point.
        return if local == 1.0 { end.to_array() } else { point.to_array() };
    }
    let slope_at_start = if span == 0 { end - start } else { 0.5 * (end - at(span - 1)) };
    let slope_at_end = if span + 1 == spans { end - start } else { 0.5 * (at(span + 2) - start) };
    let (square, cube) = (local * local, local * local * local);
    let point = start * (2.0 * cube - 3.0 * square + 1.0)
        + slope_at_start * (cube - 2.0 * square + local)
        + end * (3.0 * square - 2.0 * cube)
        + slope_at_end * (cube - square);
    [point.x.max(0.0), point.y]
}
