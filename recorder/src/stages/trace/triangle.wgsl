// The watertight triangle test: the twin of `stages::trace::triangle`.

struct TriangleRay {
    // Axis that becomes z, and whether x and y are swapped.
    axis: u32,
    is_flipped: bool,
    factors: vec3<f32>,
    origin: vec3<f32>,
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
    let along = select(select(d.z, d.y, axis == 1u), d.x, axis == 0u);
    let is_flipped = along < 0.0;
    let p = permute(d, axis, is_flipped);
    return TriangleRay(axis, is_flipped, vec3(p.x / p.z, p.y / p.z, 1.0 / p.z), permute(origin, axis, is_flipped));
}

fn sheared(shear: TriangleRay, corner: vec3<f32>) -> vec3<f32> {
    let p = permute(corner, shear.axis, shear.is_flipped) - shear.origin;
    return vec3(p.x - shear.factors.x * p.z, p.y - shear.factors.y * p.z, p.z);
}

// p.x·q.y − p.y·q.x in an order of the two that does not depend on which triangle asks, so that a
// device that contracts rounds alike on both sides of an edge.
fn edge(p: vec3<f32>, q: vec3<f32>) -> f32 {
    let is_swapped = p.x > q.x || (p.x == q.x && p.y > q.y);
    let a = select(p.xy, q.xy, is_swapped);
    let b = select(q.xy, p.xy, is_swapped);
    let area = a.x * b.y - a.y * b.x;
    return select(area, -area, is_swapped);
}

fn largest_of(v: vec3<f32>) -> f32 {
    return max(max(abs(v.x), abs(v.y)), abs(v.z));
}

fn error_bound(xs: vec3<f32>, ys: vec3<f32>, depths: vec3<f32>, edges: vec3<f32>, sum: f32) -> f32 {
    let x = largest_of(xs);
    let y = largest_of(ys);
    let z = largest_of(depths);
    let edge_size = largest_of(edges);
    let error_z = GAMMA_3 * z;
    let error_x = GAMMA_5 * (x + z);
    let error_y = GAMMA_5 * (y + z);
    let error_edge = 2.0 * (GAMMA_2 * x * y + error_y * x + error_x * y);
    return 3.0 * (GAMMA_3 * edge_size * z + error_edge * z + error_z * edge_size) / abs(sum);
}

fn intersect(shear: TriangleRay, corner_a: vec3<f32>, corner_b: vec3<f32>, corner_c: vec3<f32>) -> Intersection {
    let p = sheared(shear, corner_a);
    let q = sheared(shear, corner_b);
    let r = sheared(shear, corner_c);
    let a = edge(r, q);
    let b = edge(p, r);
    let c = edge(q, p);
    let is_negative = a < 0.0 || b < 0.0 || c < 0.0;
    let is_positive = a > 0.0 || b > 0.0 || c > 0.0;
    let sum = (a + b) + c;
    if (is_negative && is_positive) || sum == 0.0 {
        return Intersection(false, 0.0, 0.0, 0.0);
    }
    let az = shear.factors.z * p.z;
    let bz = shear.factors.z * q.z;
    let cz = shear.factors.z * r.z;
    let scaled_t = (a * az + b * bz) + c * cz;
    let t = scaled_t / sum;
    let error = error_bound(vec3(p.x, q.x, r.x), vec3(p.y, q.y, r.y), vec3(az, bz, cz), vec3(a, b, c), sum);
    if t <= error {
        return Intersection(false, 0.0, 0.0, 0.0);
    }
    return Intersection(true, t, abs(b / sum), abs(c / sum));
}
