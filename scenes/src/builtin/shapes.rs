//! The strokes that built-in scenes are drawn with: patches, blocks, lathe work, tubes, sheets.
//!
//! Seen from outside, all triangles run counter-clockwise.

use glam::{DAffine3, DMat3, DVec2, DVec3, Vec3Swizzles, dvec2, dvec3};

use super::mesh::{Canvas, Mesh, Vertex};
use super::numbers::sin_cos;

/// A frame that stands at a point and is turned about the vertical by so many turns.
pub(super) fn place(x: f64, y: f64, z: f64, turns: f64) -> DAffine3 {
    let (sine, cosine) = sin_cos(turns);
    let rotation = DMat3::from_cols(dvec3(cosine, 0.0, -sine), DVec3::Y, dvec3(sine, 0.0, cosine));
    DAffine3::from_mat3_translation(rotation, dvec3(x, y, z))
}

/// A frame at the origin, turned about its own x axis by so many turns (y towards z).
pub(super) fn tilt(turns: f64) -> DAffine3 {
    let (sine, cosine) = sin_cos(turns);
    DAffine3::from_mat3(DMat3::from_cols(DVec3::X, dvec3(0.0, cosine, sine), dvec3(0.0, -sine, cosine)))
}

/// Shrinks or stretches along the axes; all factors > 0.
pub(super) fn stretch(x: f64, y: f64, z: f64) -> DAffine3 {
    DAffine3::from_mat3(DMat3::from_diagonal(dvec3(x, y, z)))
}

/// What carries unit normals through a frame that may stretch.
pub(super) struct NormalTransform(DMat3);

impl NormalTransform {
    pub(super) fn of(frame: &DAffine3) -> Self {
        let m = frame.matrix3;
        Self(DMat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis)))
    }

    /// The unit normal in world space; zero stays zero.
    pub(super) fn apply(&self, normal: DVec3) -> DVec3 {
        (self.0 * normal).normalize_or_zero()
    }
}

/// Whether a sheet's vertices get normals.
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
fn net_count(columns: u32, rows: u32, poles: [bool; 2]) -> u64 {
    let columns = u64::from(columns);
    2 * columns * u64::from(rows) - columns * (u64::from(poles[0]) + u64::from(poles[1]))
}

impl Net {
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

    fn write(&self, mesh: &mut Mesh, material: u32) {
        let first = mesh.positions.len() as u32;
        for vertex in &self.vertices {
            mesh.vertex(*vertex);
        }
        for corners in self.triangles() {
            mesh.triangle(material, corners.map(|index| first + index));
        }
    }
}

/// A flat or twisted patch between four corners, counter-clockwise, cut into `cells` along the
/// first and the second edge.
pub(super) fn patch(canvas: &mut Canvas, material: u32, corners: [DVec3; 4], cells: [u32; 2]) {
    let [a, b, c, d] = corners;
    sheet(canvas, material, cells, Shading::Flat, |u, v| {
        let near = a + (b - a) * u;
        let far = d + (c - d) * u;
        near + (far - near) * v
    });
}

/// A surface over the unit square, cut into `columns` by `rows` cells. The normal points along
/// `∂point/∂u × ∂point/∂v`.
pub(super) fn sheet(
    canvas: &mut Canvas,
    material: u32,
    cells: [u32; 2],
    shading: Shading,
    point: impl Fn(f64, f64) -> DVec3,
) {
    surface(canvas, material, cells, [false; 2], shading, point);
}

/// A sheet whose edge at v = 0 is a single point: webs of vaults, gores, fans.
pub(super) fn fan(
    canvas: &mut Canvas,
    material: u32,
    cells: [u32; 2],
    shading: Shading,
    point: impl Fn(f64, f64) -> DVec3,
) {
    surface(canvas, material, cells, [true, false], shading, point);
}

fn surface(
    canvas: &mut Canvas,
    material: u32,
    [columns, rows]: [u32; 2],
    poles: [bool; 2],
    shading: Shading,
    point: impl Fn(f64, f64) -> DVec3,
) {
    canvas.draw(net_count(columns, rows, poles), |mesh| {
        let mut vertices = Vec::with_capacity(((columns + 1) * (rows + 1)) as usize);
        for row in 0..=rows {
            let v = f64::from(row) / f64::from(rows);
            for column in 0..=columns {
                let u = f64::from(column) / f64::from(columns);
                let uv = dvec2(u, 1.0 - v);
                vertices.push(Vertex { position: point(u, v), normal: DVec3::ZERO, uv });
            }
        }
        let mut net = Net { columns, rows, poles, vertices };
        if shading == Shading::Smooth {
            net.smooth();
        }
        net.write(mesh, material);
    });
}

/// The six sides of a block from `low` to `high`, as (origin, first edge, second edge).
fn sides(low: DVec3, high: DVec3) -> [[DVec3; 3]; 6] {
    let e = high - low;
    let (x, y, z) = (e * DVec3::X, e * DVec3::Y, e * DVec3::Z);
    [[low, y, x], [low + z, x, y], [low, z, y], [low + x, y, z], [low, x, z], [low + y, z, x]]
}

/// A block with sharp edges between two corners in `frame`; 12 triangles.
pub(super) fn block(canvas: &mut Canvas, material: u32, frame: &DAffine3, low: DVec3, high: DVec3) {
    canvas.draw(12, |mesh| {
        for [origin, first, second] in sides(low, high) {
            let corners = [origin, origin + first, origin + first + second, origin + second];
            quad(mesh, material, corners.map(|corner| frame.transform_point3(corner)));
        }
    });
}

/// Several blocks of one material, each from its lowest to its highest corner.
pub(super) fn blocks(canvas: &mut Canvas, material: u32, frame: &DAffine3, corners: &[([f64; 3], [f64; 3])]) {
    for &(low, high) in corners {
        block(canvas, material, frame, low.into(), high.into());
    }
}

/// Two triangles between four corners, counter-clockwise.
fn quad(mesh: &mut Mesh, material: u32, corners: [DVec3; 4]) {
    const UVS: [DVec2; 4] = [dvec2(0.0, 1.0), dvec2(1.0, 1.0), dvec2(1.0, 0.0), dvec2(0.0, 0.0)];
    let [a, b, c, d] = [0, 1, 2, 3].map(|corner| {
        mesh.vertex(Vertex { position: corners[corner], normal: DVec3::ZERO, uv: UVS[corner] })
    });
    mesh.triangle(material, [a, b, c]);
    mesh.triangle(material, [a, c, d]);
}

/// Mouldings around a rectangle from `low` to `high` in the plane y = 0 of `frame`: ledges,
/// cornices, parapets. The profile runs through (distance beyond the rectangle, height) points,
/// upwards along the outside; each of its spans is 8 triangles.
pub(super) fn band(
    canvas: &mut Canvas,
    material: u32,
    frame: &DAffine3,
    [low, high]: [DVec2; 2],
    profile: &[[f64; 2]],
) {
    let loops = profile.iter().map(|&[out, y]| {
        let (low, high) = (low - out, high + out);
        [(low.x, high.y), (high.x, high.y), (high.x, low.y), (low.x, low.y)]
            .map(|(x, z)| frame.transform_point3(dvec3(x, y, z)))
    });
    canvas.draw(8 * (profile.len() as u64 - 1), |mesh| {
        let loops: Vec<[DVec3; 4]> = loops.collect();
        for pair in loops.windows(2) {
            let [below, above] = [pair[0], pair[1]];
            for here in 0..4 {
                let next = (here + 1) % 4;
                quad(mesh, material, [below[here], below[next], above[next], above[here]]);
            }
        }
    });
}

/// A four-sided frame between two corners whose sides are `thickness` thick, open along y.
pub(super) fn ring(
    canvas: &mut Canvas,
    material: u32,
    frame: &DAffine3,
    [low, high]: [DVec3; 2],
    thickness: f64,
) {
    let (foot, top) = (low.y, high.y);
    let profile = [[-thickness, foot], [0.0, foot], [0.0, top], [-thickness, top], [-thickness, foot]];
    band(canvas, material, frame, [low.xz(), high.xz()], &profile);
}

/// A block with edges of this radius, each cut into `2 · steps` facets: cushions, mattresses,
/// appliances. `12 · (2 · steps + 1)²` triangles.
pub(super) fn rounded_block(
    canvas: &mut Canvas,
    material: u32,
    frame: &DAffine3,
    [low, high]: [DVec3; 2],
    radius: f64,
    steps: u32,
) {
    let cells = 2 * steps + 1;
    let half = 0.5 * (high - low);
    // A little of each side stays flat, or its facets would have no area.
    let radius = radius.min(0.95 * half.min_element());
    let centre = low + half;
    let core = half - radius;
    let normals = NormalTransform::of(frame);
    // Index 0 … steps runs over the near edge, steps + 1 … 2·steps + 1 over the far one.
    let along = |index: u32| {
        if index <= steps {
            (-1.0, f64::from(index) / f64::from(steps) - 1.0)
        } else {
            (1.0, f64::from(index - steps - 1) / f64::from(steps))
        }
    };
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    canvas.draw(6 * net_count(cells, cells, [false; 2]), |mesh| {
        for (side, axis) in [0, 1, 2, 0, 1, 2].into_iter().enumerate() {
            let (out, first, second) = if side < 3 {
                (axes[axis], axes[(axis + 1) % 3], axes[(axis + 2) % 3])
            } else {
                (-axes[axis], axes[(axis + 2) % 3], axes[(axis + 1) % 3])
            };
            let mut vertices = Vec::with_capacity(((cells + 1) * (cells + 1)) as usize);
            for row in 0..=cells {
                let (row_side, row_slope) = along(row);
                for column in 0..=cells {
                    let (column_side, column_slope) = along(column);
                    let normal = (out + first * column_slope + second * row_slope).normalize();
                    let corner = core * (out + first * column_side + second * row_side);
                    vertices.push(Vertex {
                        position: frame.transform_point3(centre + corner + normal * radius),
                        normal: normals.apply(normal),
                        uv: dvec2(0.5 + 0.5 * column_slope, 0.5 - 0.5 * row_slope),
                    });
                }
            }
            Net { columns: cells, rows: cells, poles: [false; 2], vertices }.write(mesh, material);
        }
    });
}

/// Lathe work about the y axis of `frame`. Each piece of the profile is a smooth curve through
/// (radius, height) points, with a crease between pieces; it runs upwards along the outside. A
/// radius of 0 closes the end. A piece of two points is straight; longer ones are cut into
/// `rows` per span.
pub(super) fn revolve(
    canvas: &mut Canvas,
    material: u32,
    frame: &DAffine3,
    pieces: &[&[[f64; 2]]],
    [around, rows]: [u32; 2],
) {
    for piece in pieces {
        let spans = piece.len() as u32 - 1;
        let poles = [piece[0][0] == 0.0, piece[piece.len() - 1][0] == 0.0];
        let needed = 1 + u32::from(poles[0] && poles[1]);
        let rows = if spans == 1 { needed } else { (rows * spans).max(needed) };
        canvas.draw(net_count(around, rows, poles), |mesh| {
            let mut vertices = Vec::with_capacity(((around + 1) * (rows + 1)) as usize);
            for row in 0..=rows {
                let v = f64::from(row) / f64::from(rows);
                let [radius, height] = curve(piece, v);
                for column in 0..=around {
                    let u = f64::from(column) / f64::from(around);
                    let (sine, cosine) = sin_cos(u);
                    let point = dvec3(radius * cosine, height, -radius * sine);
                    vertices.push(Vertex {
                        position: frame.transform_point3(point),
                        normal: DVec3::ZERO,
                        uv: dvec2(u, 1.0 - v),
                    });
                }
            }
            let mut net = Net { columns: around, rows, poles, vertices };
            net.smooth();
            net.write(mesh, material);
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

/// A ball of radius 1 in `frame`, `2 · rows` facets around and `rows` from pole to pole.
pub(super) fn ball(canvas: &mut Canvas, material: u32, frame: &DAffine3, rows: u32) {
    lump(canvas, material, frame, rows, |_| 1.0);
}

/// A ball whose surface lies at `reach(outward)` from the origin of `frame`, for every unit vector.
pub(super) fn lump(
    canvas: &mut Canvas,
    material: u32,
    frame: &DAffine3,
    rows: u32,
    reach: impl Fn(DVec3) -> f64,
) {
    let rows = rows.max(2);
    surface(canvas, material, [2 * rows, rows], [true; 2], Shading::Smooth, |u, v| {
        // From the lower pole to the upper one.
        let (height, radius) = sin_cos(0.5 * v - 0.25);
        let (sine, cosine) = sin_cos(u);
        let outward = dvec3(radius * cosine, height, -radius * sine);
        frame.transform_point3(outward * reach(outward))
    });
}

/// A tube along `path` (at least two points, no two neighbours equal), `around` facets around.
/// `radius` is given by the place along the path, 0 to 1; where it is 0 at an end, the tube ends
/// in a point, else it is open.
pub(super) fn tube(
    canvas: &mut Canvas,
    material: u32,
    path: &[DVec3],
    radius: impl Fn(f64) -> f64,
    around: u32,
) {
    let rows = path.len() as u32 - 1;
    let poles = [radius(0.0) == 0.0, radius(1.0) == 0.0];
    canvas.draw(net_count(around, rows, poles), |mesh| {
        let tangent = |row: usize| {
            let (before, after) = (row.saturating_sub(1), (row + 1).min(path.len() - 1));
            (path[after] - path[before]).normalize_or(DVec3::Y)
        };
        let mut side = tangent(0).any_orthonormal_vector();
        let mut vertices = Vec::with_capacity(((around + 1) * (rows + 1)) as usize);
        for (row, &centre) in path.iter().enumerate() {
            let forward = tangent(row);
            // Carried along from ring to ring, so that the tube does not twist.
            side = (side - forward * side.dot(forward)).normalize_or(forward.any_orthonormal_vector());
            let other = forward.cross(side);
            let v = row as f64 / f64::from(rows);
            let reach = radius(v);
            for column in 0..=around {
                let u = f64::from(column) / f64::from(around);
                let (sine, cosine) = sin_cos(u);
                let normal = side * cosine + other * sine;
                let uv = dvec2(u, 1.0 - v);
                vertices.push(Vertex { position: centre + normal * reach, normal, uv });
            }
        }
        Net { columns: around, rows, poles, vertices }.write(mesh, material);
    });
}
