// Where rays leave a triangle: the same on threads is `stages::shade::surface::offset_origin`.

fn largest(v: vec3<f32>) -> f32 {
    return max(max(abs(v.x), abs(v.y)), abs(v.z));
}

fn offset_origin(point: vec3<f32>, normal: vec3<f32>, pq: vec3<f32>, pr: vec3<f32>) -> vec3<f32> {
    let step = largest(point) * OFFSET_OF_POINT + max(largest(pq), largest(pr)) * OFFSET_OF_TRIANGLE;
    return point + normal * step;
}
