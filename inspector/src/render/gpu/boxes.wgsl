// Translucent boxes, from their lowest corner to their highest. Edges are less translucent.
struct BoxPoint {
    @builtin(position) position: vec4<f32>,
    @location(0) value: f32,
    // 0 to 1 along each axis of the box.
    @location(1) at: vec3<f32>,
}

@vertex
fn box_vertex(@builtin(vertex_index) vertex: u32) -> BoxPoint {
    let ends = two_points(vertex / 36u);
    let corner = vertex % 36u;
    // Two faces for each axis, two triangles each.
    let axis = corner / 12u;
    let side = f32(corner / 6u % 2u);
    let in_face = corner % 6u;
    let u = f32(in_face == 1u || in_face >= 4u) ;
    let v = f32(in_face == 2u || in_face == 3u || in_face == 5u);
    var at = vec3<f32>(side, u, v);
    if axis == 1u {
        at = vec3<f32>(v, side, u);
    } else if axis == 2u {
        at = vec3<f32>(u, v, side);
    }
    var point: BoxPoint;
    point.position = layer.clip_from_unit * vec4<f32>(mix(ends.first.xyz, ends.second.xyz, at), 1.0);
    point.value = ends.first.w;
    point.at = at;
    return point;
}

@fragment
fn box_fragment(point: BoxPoint) -> @location(0) vec4<f32> {
    let from_edge = min(point.at, 1.0 - point.at) / max(fwidth(point.at), vec3<f32>(1e-6));
    // Of the three distances one is that to the face itself, 0; the second smallest is that to its nearest edge.
    let low = min(from_edge.x, min(from_edge.y, from_edge.z));
    let high = max(from_edge.x, max(from_edge.y, from_edge.z));
    let middle = from_edge.x + from_edge.y + from_edge.z - low - high;
    let edge = 1.0 - smoothstep(0.5, 1.5, middle);
    return shown(colour_of(point.value), clamp(layer.opacity * (1.0 + 3.0 * edge), 0.0, 1.0));
}
