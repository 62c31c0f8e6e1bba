// A ray on its way through a hierarchy, and what it has found: the same on threads is `stages::trace::cpu_query`.

struct Intersection {
    is_hit: bool,
    t: f32,
    // Weights of the second and third corner, and what they are to be divided by: that is for hits that count.
    b: f32,
    c: f32,
    sum: f32,
}

const NO_INTERSECTION = Intersection(false, 0.0, 0.0, 0.0, 1.0);

struct Query {
    origin: vec3<f32>,
    direction: vec3<f32>,
    inverse: vec3<f32>,
    t_min: f32,
    triangle_ray: TriangleRay,
    best_t: f32,
    best_triangle: u32,
    best_u: f32,
    best_v: f32,
    work: vec2<u32>,
}

fn reciprocal(d: f32) -> f32 {
    if abs(d) > RECIPROCAL_THRESHOLD {
        return quotient(1.0, d);
    }
    return bitcast<f32>(bitcast<u32>(RECIPROCAL_LIMIT) | (bitcast<u32>(d) & 0x80000000u));
}

fn query_new(origin: vec4<f32>, direction: vec4<f32>) -> Query {
    var query: Query;
    query.origin = origin.xyz;
    query.direction = direction.xyz;
    query.t_min = origin.w;
    query.inverse = vec3(reciprocal(direction.x), reciprocal(direction.y), reciprocal(direction.z));
    query.triangle_ray = triangle_ray_new(origin.xyz, direction.xyz);
    query.best_t = min(direction.w, F32_MAX);
    query.best_triangle = NO_TRIANGLE;
    return query;
}

fn query_limit(query: ptr<function, Query>) -> f32 {
    return (*query).best_t * PADDING;
}

// Takes a hit if it is nearer; true if the search is over.
fn query_offer(query: ptr<function, Query>, at: Intersection, triangle: u32) -> bool {
    let is_nearer = at.t < (*query).best_t || (at.t == (*query).best_t && triangle < (*query).best_triangle);
    if !(at.is_hit && at.t >= (*query).t_min && is_nearer) {
        return false;
    }
    let uv = weights(at);
    if is_hole(triangle, uv.x, uv.y) {
        return false;
    }
    (*query).best_t = abs(at.t);
    (*query).best_triangle = triangle;
    (*query).best_u = uv.x;
    (*query).best_v = uv.y;
    return ANY;
}

// Tests the triangle in a leaf slot; true if the search is over.
fn query_test(query: ptr<function, Query>, slot: u32) -> bool {
    if COUNT {
        (*query).work.y += 1u;
    }
    let leaf = leaf_at(slot);
    let at = intersect((*query).triangle_ray, leaf.a, leaf.b, leaf.c, (*query).best_t);
    return query_offer(query, at, leaf.triangle);
}
