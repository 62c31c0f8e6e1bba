// The surface at a hit: the twin of `stages::shade::surface`.

struct HitSurface {
    point: vec3<f32>,
    origin: vec3<f32>,
    geometric_normal: vec3<f32>,
    shading_normal: vec3<f32>,
    material: MaterialData,
    base_color: vec3<f32>,
}

fn largest(v: vec3<f32>) -> f32 {
    return max(max(abs(v.x), abs(v.y)), abs(v.z));
}

fn offset_origin(point: vec3<f32>, normal: vec3<f32>, pq: vec3<f32>, pr: vec3<f32>) -> vec3<f32> {
    let step = largest(point) * OFFSET_OF_POINT + max(largest(pq), largest(pr)) * OFFSET_OF_TRIANGLE;
    return point + normal * step;
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
    let point = p + pq * u + pr * v;
    return HitSurface(
        point,
        offset_origin(point, geometric_normal, pq, pr),
        geometric_normal,
        shading_normal(triangle, u, v, geometric_normal, direction),
        material,
        material.base_color * texture_factor(triangle, material, u, v),
    );
}
