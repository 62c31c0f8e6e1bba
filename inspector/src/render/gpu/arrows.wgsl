// Heads of arrows: a triangle at the second point of each line, layer.width pixels long.
struct ArrowPoint {
    @builtin(position) position: vec4<f32>,
    @location(0) @interpolate(flat) colour: vec3<f32>,
}

@vertex
fn arrow_vertex(@builtin(vertex_index) vertex: u32) -> ArrowPoint {
    let line = two_points(vertex / 3u);
    let corner = vertex % 3u;
    let ends = line_ends(line.first.xyz, line.second.xyz);
    var point: ArrowPoint;
    point.colour = colour_of(line.second.w);
    if !ends.is_end_seen {
        point.position = vec4<f32>(2.0, 2.0, 2.0, 1.0);
        return point;
    }
    // The head of a short line is shorter than the line.
    let size = min(layer.width, 0.8 * ends.length_pixels);
    let across = vec2<f32>(-ends.along.y, ends.along.x);
    let side = f32(corner) - 1.0;
    let is_tip = corner == 1u;
    let pixels = select(0.4 * size * side * across - size * ends.along, vec2<f32>(0.0), is_tip);
    let here = ends.to_clip;
    point.position = vec4<f32>(here.xy + 2.0 * pixels / layer.viewport * here.w, here.zw);
    return point;
}

@fragment
fn arrow_fragment(point: ArrowPoint) -> @location(0) vec4<f32> {
    return shown(point.colour, layer.opacity);
}
