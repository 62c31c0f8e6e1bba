// Surfaces, flat-shaded by a soft sky above and a faint lamp at the eye.
struct MeshPoint {
    @builtin(position) position: vec4<f32>,
    @location(0) in_unit_space: vec3<f32>,
    @location(1) colour: vec4<f32>,
}

// How much of a colour is left beside its grey, so that colours of data are told from it.
const SATURATION: f32 = 0.75;
// What black is drawn as: a shape, not a hole.
const BLACK: f32 = 0.2;

@vertex
fn mesh_vertex(
    @location(0) corner: vec3<f32>,
    @location(1) colour: vec4<f32>,
    @builtin(instance_index) grid: u32,
) -> MeshPoint {
    // Cells along a unit length, a power of two; each corner is drawn in the middle of its cell. 0 is no grid.
    let cells = bitcast<f32>((127u + FINEST_BITS - grid) << 23u);
    let drawn = select((floor(corner * cells) + 0.5) / cells, corner, grid == 0u);
    var point: MeshPoint;
    point.position = layer.clip_from_unit * vec4<f32>(drawn, 1.0);
    // Surfaces are shaded as they are, not as they are drawn.
    point.in_unit_space = corner;
    point.colour = colour;
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

// Light on a surface that faces the eye, in the encoding of colours.
fn light_on(normal: vec3<f32>, to_eye: vec3<f32>) -> f32 {
    let facing = dot(normal, to_eye);
    let sky = 0.5 + 0.5 * sign(facing) * normal.y;
    return 0.55 + 0.27 * sky + 0.18 * abs(facing);
}

@fragment
fn mesh_fragment(point: MeshPoint) -> @location(0) vec4<f32> {
    let p = point.in_unit_space;
    let normal = normalize(cross(dpdx(p), dpdy(p)));
    if is_cut_away(p) || is_in_front(p, normal) {
        discard;
    }
    let light = light_on(normal, normalize(layer.eye.xyz - p));
    if layer.faded.a * point.colour.a == 0.0 {
        return shown(layer.plain.rgb * light, layer.opacity);
    }
    let grey = vec3<f32>(dot(point.colour.rgb, vec3<f32>(0.299, 0.587, 0.114)));
    let lit = mix(vec3<f32>(BLACK), vec3<f32>(1.0), mix(grey, point.colour.rgb, SATURATION)) * light;
    return shown(mix(layer.faded.rgb, lit, layer.faded.a), layer.opacity);
}
