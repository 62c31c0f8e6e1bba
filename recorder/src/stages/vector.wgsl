// Vector products with a fixed order of evaluation: the same on threads is `stages::vector`.

fn dot3(a: vec3<f32>, b: vec3<f32>) -> f32 {
    return rounded(a.x * b.x) + rounded(a.y * b.y) + rounded(a.z * b.z);
}

fn cross3(a: vec3<f32>, b: vec3<f32>) -> vec3<f32> {
    return rounded3(a.yzx * b.zxy) - rounded3(a.zxy * b.yzx);
}

fn normalize3(a: vec3<f32>) -> vec3<f32> {
    return a * (1.0 / sqrt(dot3(a, a)));
}

struct Basis {
    tangent: vec3<f32>,
    bitangent: vec3<f32>,
}

fn basis(n: vec3<f32>) -> Basis {
    let sign = select(-1.0, 1.0, n.z >= 0.0);
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    return Basis(
        vec3(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x),
        vec3(b, sign + n.y * n.y * a, -n.y),
    );
}

fn luminance(color: vec3<f32>) -> f32 {
    return 0.2126 * color.x + 0.7152 * color.y + 0.0722 * color.z;
}
