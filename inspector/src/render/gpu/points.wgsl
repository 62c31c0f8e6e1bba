// The points of lines, marks and boxes, read by number: a draw is one run of vertices, and not an instance for
// each line, which software and hardware are slow at.
@group(1) @binding(0) var<storage, read> points: array<vec4<f32>>;

struct TwoPoints {
    first: vec4<f32>,
    second: vec4<f32>,
}

// The two points of a line, a mark or a box.
fn two_points(number: u32) -> TwoPoints {
    let at = number * layer.points_each;
    return TwoPoints(points[at], points[at + 1u]);
}

// Vertices of a quad of two triangles, and the corner of each: 0, 1, 2 and 2, 1, 3.
const QUAD: u32 = 6u;

fn corner_of_quad(vertex: u32) -> u32 {
    return (0xda4u >> (2u * (vertex % QUAD))) & 3u;
}
