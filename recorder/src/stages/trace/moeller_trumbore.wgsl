// The triangle test of Möller and Trumbore: the same on threads is `stages::trace::moeller_trumbore`.

struct TriangleRay {
    origin: vec3<f32>,
    direction: vec3<f32>,
}

fn triangle_ray_new(origin: vec3<f32>, direction: vec3<f32>) -> TriangleRay {
    return TriangleRay(origin, direction);
}

fn weights(at: Intersection) -> vec2<f32> {
    return vec2(at.b, at.c);
}

// Tests every triangle to the end, whatever the limit.
fn intersect(ray: TriangleRay, corner_a: vec3<f32>, corner_b: vec3<f32>, corner_c: vec3<f32>, limit: f32) -> Intersection {
    let ab = corner_b - corner_a;
    let ac = corner_c - corner_a;
    let across = cross3(ray.direction, ac);
    let determinant = dot3(ab, across);
    if determinant == 0.0 {
        return NO_INTERSECTION;
    }
    let inverse = quotient(1.0, determinant);
    let from_a = ray.origin - corner_a;
    let u = rounded(dot3(from_a, across) * inverse);
    let along = cross3(from_a, ab);
    let v = rounded(dot3(ray.direction, along) * inverse);
    let is_inside = u >= 0.0 && v >= 0.0 && u + v <= 1.0;
    return Intersection(is_inside, dot3(ac, along) * inverse, u, v, 1.0);
}
