// Interpolated vertex normals, composed in where a scene has them.

fn shading_normal(triangle: vec4<u32>, u: f32, v: f32, geometric_normal: vec3<f32>, direction: vec3<f32>) -> vec3<f32> {
    let a = normals[triangle.x].xyz;
    let b = normals[triangle.y].xyz;
    let c = normals[triangle.z].xyz;
    let sum = a * (1.0 - u - v) + b * u + c * v;
    let length2 = dot3(sum, sum);
    if length2 < 1e-12 {
        return geometric_normal;
    }
    var normal = sum * (1.0 / sqrt(length2));
    if dot3(normal, geometric_normal) < 0.0 {
        normal = -normal;
    }
    return select(normal, geometric_normal, dot3(normal, direction) > -1e-3);
}
