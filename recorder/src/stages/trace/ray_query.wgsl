// Traversal by the driver. The hit that it commits is evaluated again by our own triangle test, so
// that pictures agree; where ours says miss, the driver's numbers stay.

fn scene_intersection(query: ptr<function, Query>, triangle: u32) -> Intersection {
    let corners = leaves[triangle];
    return intersect((*query).shear, positions[corners.x].xyz, positions[corners.y].xyz, positions[corners.z].xyz);
}

fn traverse(query: ptr<function, Query>) {
    var driver: ray_query;
    let flags = select(0u, 4u, ANY);
    rayQueryInitialize(&driver, hierarchy, RayDesc(flags, 0xffu, (*query).t_min, (*query).best_t, (*query).origin, (*query).direction));
    while rayQueryProceed(&driver) {
        let candidate = rayQueryGetCandidateIntersection(&driver);
        if !is_hole(candidate.primitive_index, candidate.barycentrics.x, candidate.barycentrics.y) {
            rayQueryConfirmIntersection(&driver);
        }
    }
    let committed = rayQueryGetCommittedIntersection(&driver);
    if committed.kind != RAY_QUERY_INTERSECTION_TRIANGLE {
        return;
    }
    let triangle = committed.primitive_index;
    let ours = scene_intersection(query, triangle);
    (*query).best_triangle = triangle;
    if ours.is_hit && ours.t >= (*query).t_min && ours.t <= (*query).best_t {
        (*query).best_t = abs(ours.t);
        (*query).best_u = ours.u;
        (*query).best_v = ours.v;
    } else {
        (*query).best_t = committed.t;
        (*query).best_u = committed.barycentrics.x;
        (*query).best_v = committed.barycentrics.y;
    }
}
