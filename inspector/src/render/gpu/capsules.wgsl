// Capsules: two spheres and the cone that touches both, one per instance, as silhouettes: clear but at the outline.
struct CapsulePoint {
    @builtin(position) position: vec4<f32>,
    @location(0) in_unit_space: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) value: f32,
}

const QUARTER: f32 = 1.57079632679;

// corner: which sphere, how far along its cap, cosine and sine around the axis.
@vertex
fn capsule_vertex(
    @location(0) corner: vec4<f32>,
    @location(1) origins: vec4<f32>,
    @location(2) ends: vec4<f32>,
    @location(3) value: f32,
) -> CapsulePoint {
    let between = ends.xyz - origins.xyz;
    let apart = length(between);
    let difference = origins.w - ends.w;
    // One sphere inside the other: the larger one alone.
    let is_nested = apart <= abs(difference);
    let larger = select(ends, origins, difference >= 0.0);
    let first = select(origins, larger, is_nested);
    let second = select(ends, larger, is_nested);
    let axis = select(vec3<f32>(0.0, 0.0, 1.0), between / max(apart, 1e-12), apart > 1e-9);
    let tangent = select(asin(clamp(difference / max(apart, 1e-12), -1.0, 1.0)), 0.0, is_nested);
    let other = select(vec3<f32>(0.0, 1.0, 0.0), vec3<f32>(1.0, 0.0, 0.0), abs(axis.x) < 0.7);
    let right = normalize(cross(other, axis));
    let up = cross(axis, right);
    let is_first = corner.x < 0.5;
    let low = select(tangent, -QUARTER, is_first);
    let high = select(QUARTER, tangent, is_first);
    let angle = mix(low, high, corner.y);
    let sphere = select(second, first, is_first);
    let normal = sin(angle) * axis + cos(angle) * (corner.z * right + corner.w * up);
    var point: CapsulePoint;
    point.in_unit_space = sphere.xyz + sphere.w * normal;
    point.position = layer.clip_from_unit * vec4<f32>(point.in_unit_space, 1.0);
    point.normal = normal;
    point.value = value;
    return point;
}

@fragment
fn capsule_fragment(point: CapsulePoint) -> @location(0) vec4<f32> {
    let facing = dot(normalize(point.normal), normalize(layer.eye.xyz - point.in_unit_space));
    // A far side has no outline of its own: from inside it would be fog.
    let is_near = clamp(facing / max(fwidth(facing), 1e-6), 0.0, 1.0);
    let outline = pow(1.0 - max(facing, 0.0), 6.0);
    let alpha = clamp(layer.opacity * (0.15 + 7.0 * outline), 0.0, 1.0);
    return shown(colour_of(point.value), is_near * alpha);
}
