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

// Of a wall's distance from the middle of a room, part of that of the room's box in its direction.
const WALLS_FROM: f32 = 0.4;

// Whether a wall stands between the eye and the middle of a room that is seen from outside.
fn is_in_front(p: vec3<f32>, normal: vec3<f32>) -> bool {
    let middle = 0.5 * layer.room.xyz;
    let to_middle = dot(normal, middle - p);
    let is_between = to_middle * dot(normal, layer.eye.xyz - p) < 0.0;
    return layer.room.w > 0.0 && is_between && abs(to_middle) > WALLS_FROM * dot(abs(normal), middle);
}

@fragment
fn mesh_fragment(point: MeshPoint) -> @location(0) vec4<f32> {
    let p = point.in_unit_space;
    let normal = normalize(cross(dpdx(p), dpdy(p)));
    if is_cut_away(p) || is_in_front(p, normal) {
        discard;
    }
    let facing = abs(dot(normal, normalize(layer.eye.xyz - p)));
    let sky = 0.5 + 0.5 * abs(normal.y);
    let light = 0.42 + 0.40 * facing + 0.18 * sky;
    return shown(layer.plain.rgb * light, layer.opacity);
}
