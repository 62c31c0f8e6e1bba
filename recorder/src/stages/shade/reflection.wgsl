// What the kernels share that follow a path on from its surface.

fn is_miss(surface: SurfaceData) -> bool {
    return bitcast<u32>(surface.t) == infinity_bits;
}

fn path_state(index: u32) -> PathState {
    let bits = states[index];
    return PathState(bitcast<vec3<f32>>(bits.xyz), bitcast<f32>(bits.w));
}

fn to_local(frame: Basis, normal: vec3<f32>, v: vec3<f32>) -> vec3<f32> {
    return vec3(dot3(v, frame.tangent), dot3(v, frame.bitangent), dot3(v, normal));
}

fn to_world(frame: Basis, normal: vec3<f32>, v: vec3<f32>) -> vec3<f32> {
    return frame.tangent * v.x + frame.bitangent * v.y + normal * v.z;
}

fn is_bright(color: vec3<f32>) -> bool {
    let brightness = luminance(color);
    return brightness > 0.0 && brightness < F32_MAX;
}
