// Surfaces, flat-shaded by the light of a lamp at the eye.
struct MeshPoint {
    @builtin(position) position: vec4<f32>,
    @location(0) in_unit_space: vec3<f32>,
}

@vertex
fn mesh_vertex(@location(0) corner: vec3<f32>, @builtin(instance_index) grid: u32) -> MeshPoint {
    // Cells along a unit length, a power of two; each corner is drawn in the middle of its cell. 0 is no grid.
    let cells = bitcast<f32>((127u + FINEST_BITS - grid) << 23u);
    let drawn = select((floor(corner * cells) + 0.5) / cells, corner, grid == 0u);
    var point: MeshPoint;
    point.position = layer.clip_from_unit * vec4<f32>(drawn, 1.0);
    // Surfaces are shaded as they are, not as they are drawn.
    point.in_unit_space = corner;
    return point;
}

@fragment
fn mesh_fragment(point: MeshPoint) -> @location(0) vec4<f32> {
    let p = point.in_unit_space;
    let normal = normalize(cross(dpdx(p), dpdy(p)));
    if is_cut_away(p) {
        discard;
    }
    let facing = abs(dot(normal, normalize(layer.eye.xyz - p)));
    let sky = 0.5 + 0.5 * abs(normal.y);
    let light = 0.42 + 0.40 * facing + 0.18 * sky;
    return shown(layer.plain.rgb * light, layer.opacity);
}
