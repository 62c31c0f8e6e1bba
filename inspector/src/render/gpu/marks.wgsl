// Marks of layer.width pixels at points: a disc, a ring or a cross, by the number of the second point.
struct MarkPoint {
    @builtin(position) position: vec4<f32>,
    @location(0) @interpolate(flat) colour: vec3<f32>,
    // -1 to 1 across the mark.
    @location(1) at: vec2<f32>,
    @location(2) @interpolate(flat) mark: u32,
}

@vertex
fn mark_vertex(@builtin(vertex_index) vertex: u32) -> MarkPoint {
    let here = two_points(vertex / QUAD);
    let corner = corner_of_quad(vertex);
    let clip = layer.clip_from_unit * vec4<f32>(mix(here.first.xyz, layer.eye.xyz, 0.003), 1.0);
    var point: MarkPoint;
    point.colour = colour_of(here.first.w);
    point.mark = u32(here.second.w);
    point.at = vec2<f32>(f32(corner & 1u), f32(corner >> 1u)) * 2.0 - 1.0;
    point.position = vec4<f32>(clip.xy + point.at * layer.width / layer.viewport * clip.w, clip.zw);
    return point;
}

@fragment
fn mark_fragment(point: MarkPoint) -> @location(0) vec4<f32> {
    let radius = length(point.at);
    let soft = 2.0 / max(layer.width, 2.0);
    let disc = 1.0 - smoothstep(1.0 - soft, 1.0, radius);
    let ring = disc * smoothstep(0.55 - soft, 0.55, radius);
    let diagonal = min(abs(point.at.x - point.at.y), abs(point.at.x + point.at.y));
    let cross = 1.0 - smoothstep(0.45, 0.45 + soft, diagonal);
    let alpha = select(select(cross, ring, point.mark == 1u), disc, point.mark == 0u);
    if alpha <= 0.0 {
        discard;
    }
    return shown(point.colour, layer.opacity * alpha);
}
