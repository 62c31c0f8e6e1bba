// Lines as quads of so many pixels, one per instance, from a to b.
struct LinePoint {
    @builtin(position) position: vec4<f32>,
    @location(0) value: f32,
    @location(1) in_unit_space: vec3<f32>,
}

@vertex
fn line_vertex(@builtin(vertex_index) corner: u32, @location(0) a: vec4<f32>, @location(1) b: vec4<f32>) -> LinePoint {
    let ends = line_ends(a.xyz, b.xyz);
    var point: LinePoint;
    let is_end = (corner & 1u) == 1u;
    point.value = select(a.w, b.w, is_end);
    point.in_unit_space = select(a.xyz, b.xyz, is_end);
    if !ends.is_seen {
        point.position = vec4<f32>(2.0, 2.0, 2.0, 1.0);
        return point;
    }
    let across = vec2<f32>(-ends.along.y, ends.along.x);
    let here = select(ends.from_clip, ends.to_clip, is_end);
    let side = select(-1.0, 1.0, (corner & 2u) == 2u);
    let out = select(-1.0, 1.0, is_end);
    let offset = layer.width * (side * across + out * ends.along) / layer.viewport;
    point.position = vec4<f32>(here.xy + offset * here.w, here.zw);
    return point;
}

@fragment
fn line_fragment(point: LinePoint) -> @location(0) vec4<f32> {
    if dot(layer.cut.xyz, point.in_unit_space) > layer.cut.w {
        discard;
    }
    return shown(colour_of(point.value), layer.opacity);
}
