// The surface at a hit: the twin of `stages::shade::surface`.

struct HitSurface {
    point: vec3<f32>,
    geometric_normal: vec3<f32>,
    shading_normal: vec3<f32>,
    material: MaterialData,
    base_color: vec3<f32>,
}

fn offset_along(p: f32, n: f32) -> f32 {
    if abs(p) < OFFSET_ORIGIN {
        return p + OFFSET_STEP * n;
    }
    let ulps = i32(OFFSET_ULPS * n);
    return bitcast<f32>(bitcast<i32>(p) + select(ulps, -ulps, p < 0.0));
}

fn offset_origin(point: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    return vec3(
        offset_along(point.x, normal.x),
        offset_along(point.y, normal.y),
        offset_along(point.z, normal.z),
    );
}

fn hit_surface(direction: vec3<f32>, triangle_index: u32, u: f32, v: f32) -> HitSurface {
    let triangle = triangles[triangle_index];
    let material = materials[triangle.w];
    let p = positions[triangle.x].xyz;
    let pq = positions[triangle.y].xyz - p;
    let pr = positions[triangle.z].xyz - p;
    var geometric_normal = normalize3(cross3(pq, pr));
    if dot3(geometric_normal, direction) > 0.0 {
        geometric_normal = -geometric_normal;
    }
    return HitSurface(
        p + pq * u + pr * v,
        geometric_normal,
        shading_normal(triangle, u, v, geometric_normal, direction),
        material,
        material.base_color * texture_factor(triangle, material, u, v),
    );
}
