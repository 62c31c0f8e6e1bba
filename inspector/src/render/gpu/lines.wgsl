// Lines as quads of so many pixels, from one point to the other.
struct LinePoint {
    @builtin(position) position: vec4<f32>,
    // That of the first point: each triangle's first corner lies there.
    @location(0) @interpolate(flat, first) colour: vec3<f32>,
}

// Lines that are cut with the surfaces whose edges they are.
struct EdgePoint {
    @builtin(position) position: vec4<f32>,
    @location(0) in_unit_space: vec3<f32>,
}

// Whether a corner of a line lies at its second point.
fn is_at_end(corner: u32) -> bool {
    return (corner & 1u) == 1u;
}

fn corner_of_line(line: TwoPoints, corner: u32) -> vec4<f32> {
    let ends = line_ends(line.first.xyz, line.second.xyz);
    if !ends.is_seen {
        return vec4<f32>(2.0, 2.0, 2.0, 1.0);
    }
    let across = vec2<f32>(-ends.along.y, ends.along.x);
    let here = select(ends.from_clip, ends.to_clip, is_at_end(corner));
    let side = select(-1.0, 1.0, (corner & 2u) == 2u);
    let out = select(-1.0, 1.0, is_at_end(corner));
    let offset = layer.width * (side * across + out * ends.along) / layer.viewport;
    return vec4<f32>(here.xy + offset * here.w, here.zw);
}

@vertex
fn line_vertex(@builtin(vertex_index) vertex: u32) -> LinePoint {
    let line = two_points(vertex / QUAD);
    return LinePoint(corner_of_line(line, corner_of_quad(vertex)), colour_of(line.first.w));
}

// Nothing is discarded, so that depth is tested before colours are found.
@fragment
fn line_fragment(point: LinePoint) -> @location(0) vec4<f32> {
    return shown(point.colour, layer.opacity);
}

@vertex
fn edge_vertex(@builtin(vertex_index) vertex: u32) -> EdgePoint {
    let line = two_points(vertex / QUAD);
    let corner = corner_of_quad(vertex);
    let in_unit_space = select(line.first.xyz, line.second.xyz, is_at_end(corner));
    return EdgePoint(corner_of_line(line, corner), in_unit_space);
}

@fragment
fn edge_fragment(point: EdgePoint) -> @location(0) vec4<f32> {
    if is_cut_away(point.in_unit_space) {
        discard;
    }
    return shown(layer.plain.rgb, layer.opacity);
}
