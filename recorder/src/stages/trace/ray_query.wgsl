// Traversal by the driver, its hits evaluated again by our own triangle test, so that pictures agree.
//
// The driver's test is its own affair: near the start of a ray it may find the surface that the ray
// leaves. So a hit that our test rejects is not believed, and the ray is traced once more with every
// triangle offered to our test first. That is slower, and rare.

// RayDesc flags of WGSL's ray query.
const FORCE_NO_OPAQUE = 2u;
const TERMINATE_ON_FIRST_HIT = 4u;

fn scene_intersection(query: ptr<function, Query>, triangle: u32) -> Intersection {
    let leaf = leaf_at(triangle);
    return intersect((*query).triangle_ray, leaf.a, leaf.b, leaf.c, (*query).best_t);
}

fn is_accepted(query: ptr<function, Query>, at: Intersection) -> bool {
    return at.is_hit && at.t >= (*query).t_min && at.t <= (*query).best_t;
}

// Whether the driver may commit to a triangle.
fn is_confirmed(query: ptr<function, Query>, triangle: u32) -> bool {
    let at = scene_intersection(query, triangle);
    if !is_accepted(query, at) {
        return false;
    }
    let uv = weights(at);
    return !is_hole(triangle, uv.x, uv.y);
}

// Takes what the driver committed to; false if our test rejects it.
fn is_taken(query: ptr<function, Query>, committed: RayIntersection) -> bool {
    if committed.kind != RAY_QUERY_INTERSECTION_TRIANGLE {
        return true;
    }
    let at = scene_intersection(query, committed.primitive_index);
    if !is_accepted(query, at) {
        return false;
    }
    (*query).best_triangle = committed.primitive_index;
    (*query).best_t = abs(at.t);
    let uv = weights(at);
    (*query).best_u = uv.x;
    (*query).best_v = uv.y;
    return true;
}

fn traverse(query: ptr<function, Query>) {
    let flags = select(0u, TERMINATE_ON_FIRST_HIT, ANY);
    let origin = (*query).origin;
    let direction = (*query).direction;
    let range = vec2((*query).t_min, (*query).best_t);
    var driver: ray_query;
    rayQueryInitialize(&driver, hierarchy, RayDesc(flags, 0xffu, range.x, range.y, origin, direction));
    while rayQueryProceed(&driver) {
        if is_confirmed(query, rayQueryGetCandidateIntersection(&driver).primitive_index) {
            rayQueryConfirmIntersection(&driver);
        }
    }
    if is_taken(query, rayQueryGetCommittedIntersection(&driver)) {
        return;
    }
    var careful: ray_query;
    rayQueryInitialize(&careful, hierarchy, RayDesc(flags | FORCE_NO_OPAQUE, 0xffu, range.x, range.y, origin, direction));
    while rayQueryProceed(&careful) {
        if is_confirmed(query, rayQueryGetCandidateIntersection(&careful).primitive_index) {
            rayQueryConfirmIntersection(&careful);
        }
    }
    // Nothing that our test rejects was committed.
    _ = is_taken(query, rayQueryGetCommittedIntersection(&careful));
}
