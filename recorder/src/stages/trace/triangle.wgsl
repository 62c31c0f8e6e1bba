// The watertight triangle test: the same on threads is `stages::trace::triangle`.

struct TriangleRay {
    // Axis that becomes z, and whether x and y are swapped.
    axis: u32,
    is_flipped: bool,
    factors: vec3<f32>,
    origin: vec3<f32>,
    // Axes as they are.
    start: vec3<f32>,
    direction: vec3<f32>,
    // Reciprocals of the direction, axes permuted.
    inverse: vec3<f32>,
}

fn permute(v: vec3<f32>, axis: u32, is_flipped: bool) -> vec3<f32> {
    let p = select(select(v.xyz, v.zxy, axis == 1u), v.yzx, axis == 0u);
    return select(p, p.yxz, is_flipped);
}

fn triangle_ray_new(origin: vec3<f32>, d: vec3<f32>) -> TriangleRay {
    let size = abs(d);
    var axis = 2u;
    if size.x >= size.y {
        axis = select(2u, 0u, size.x >= size.z);
    } else {
        axis = select(2u, 1u, size.y >= size.z);
    }
    let main_component = select(select(d.z, d.y, axis == 1u), d.x, axis == 0u);
    let is_flipped = main_component < 0.0;
    let p = permute(d, axis, is_flipped);
    let factors = vec3(quotient(p.x, p.z), quotient(p.y, p.z), quotient(1.0, p.z));
    let inverse = permute(vec3(reciprocal(d.x), reciprocal(d.y), reciprocal(d.z)), axis, is_flipped);
    return TriangleRay(axis, is_flipped, factors, permute(origin, axis, is_flipped), origin, d, inverse);
}

fn moved(shear: TriangleRay, corner: vec3<f32>) -> vec3<f32> {
    return permute(corner, shear.axis, shear.is_flipped) - shear.origin;
}

fn sheared(shear: TriangleRay, p: vec3<f32>) -> vec2<f32> {
    return vec2(p.x - rounded(shear.factors.x * p.z), p.y - rounded(shear.factors.y * p.z));
}

fn edge(p: vec2<f32>, q: vec2<f32>) -> f32 {
    return rounded(p.x * q.y) - rounded(p.y * q.x);
}

fn least(v: vec3<f32>) -> f32 {
    return min(min(v.x, v.y), v.z);
}

// Distance to the plane of a triangle, at least `nearest`; negative if that is not to be believed. `z` says where the
// line comes to the corners' z.
fn distance_to(shear: TriangleRay, p: vec3<f32>, q: vec3<f32>, r: vec3<f32>, nearest: f32, z: vec3<f32>) -> f32 {
    let across = vec3(dot3(r - q, r - q), dot3(p - r, p - r), dot3(q - p, q - p));
    // The corner opposite the longest edge, and the two others.
    let first = across.x >= across.y && across.x >= across.z;
    let second = across.y >= across.z;
    let base = select(select(r, q, second), p, first);
    let a = select(select(p, r, second), q, first) - base;
    let b = select(select(q, p, second), r, first) - base;
    let to_base = base - shear.start;
    let normal = cross3(a, b);
    let height = dot3(normal, to_base);
    let approach = dot3(normal, shear.direction);
    let sizes = abs(rounded3(a.yzx * b.zxy)) + abs(rounded3(a.zxy * b.yzx));
    let is_certain = abs(height) > GAMMA_8 * dot3(sizes, abs(to_base))
        && abs(approach) > GAMMA_8 * dot3(sizes, abs(shear.direction));
    let ahead = least(z);
    let farthest = max(max(z.x, z.y), z.z);
    let plain = quotient(height, approach);
    if !select(ahead > 0.0 && approach != 0.0, plain > 0.0, is_certain) {
        return -1.0;
    }
    let t = select(farthest, plain, plain < farthest);
    return select(nearest, t, t > nearest);
}

// Weights of the second and third corner.
fn weights(at: Intersection) -> vec2<f32> {
    return vec2(abs(quotient(at.b, at.sum)), abs(quotient(at.c, at.sum)));
}

// What lies beyond `limit` is no hit.
fn intersect(shear: TriangleRay, corner_a: vec3<f32>, corner_b: vec3<f32>, corner_c: vec3<f32>, limit: f32) -> Intersection {
    let moved_a = moved(shear, corner_a);
    let moved_b = moved(shear, corner_b);
    let moved_c = moved(shear, corner_c);
    let p = sheared(shear, moved_a);
    let q = sheared(shear, moved_b);
    let r = sheared(shear, moved_c);
    let a = edge(r, q);
    let b = edge(p, r);
    let c = edge(q, p);
    let is_inside = (a >= 0.0 && b >= 0.0 && c >= 0.0) || (a <= 0.0 && b <= 0.0 && c <= 0.0);
    let sum = (a + b) + c;
    if !is_inside || sum == 0.0 {
        return NO_INTERSECTION;
    }
    let x = shear.inverse.x * vec3(moved_a.x, moved_b.x, moved_c.x);
    let y = shear.inverse.y * vec3(moved_a.y, moved_b.y, moved_c.y);
    let z = shear.inverse.z * vec3(moved_a.z, moved_b.z, moved_c.z);
    let nearest = max(max(least(x), least(y)), least(z));
    if nearest > limit {
        return NO_INTERSECTION;
    }
    let t = distance_to(shear, corner_a, corner_b, corner_c, nearest, z);
    return Intersection(t >= 0.0, t, b, c, sum);
}
