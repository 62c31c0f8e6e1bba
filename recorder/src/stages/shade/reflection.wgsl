// What the kernels share that follow a path on from its surface.

fn is_miss(surface: SurfaceData) -> bool {
    return bitcast<u32>(surface.t) == infinity_bits;
}

fn path_state(index: u32) -> PathState {
    let bits = states[index];
    return PathState(bitcast<vec3<f32>>(bits.xyz), bitcast<f32>(bits.w));
}

// The surface of a path, of which a dispatch keeps its own.
fn surface_at(index: u32) -> SurfaceData {
    return surfaces[index - params.first];
}

// The numbers that a path draws at its surface: those of the light first, then those of the next ray.
fn random_at(index: u32) -> u32 {
    return random_start(params.seed, path_ids[index], params.pass_index, params.bounce + 1u);
}

// How a surface reflects, and its frame, in which directions are local.
struct Reflection {
    surface: Bsdf,
    frame: Basis,
    normal: vec3<f32>,
    // Back along the ray that met it, local.
    out_direction: vec3<f32>,
}

fn reflection_at(surface: SurfaceData, direction: vec3<f32>) -> Reflection {
    var at: Reflection;
    at.surface = surface_new(surface.base_color, surface.metallic, surface.roughness);
    at.frame = basis(surface.shading_normal);
    at.normal = surface.shading_normal;
    at.out_direction = to_local(at, -direction);
    return at;
}

fn to_local(at: Reflection, v: vec3<f32>) -> vec3<f32> {
    return vec3(dot3(v, at.frame.tangent), dot3(v, at.frame.bitangent), dot3(v, at.normal));
}

fn to_world(at: Reflection, v: vec3<f32>) -> vec3<f32> {
    return at.frame.tangent * v.x + at.frame.bitangent * v.y + at.normal * v.z;
}

fn is_bright(color: vec3<f32>) -> bool {
    let brightness = luminance(color);
    return brightness > 0.0 && brightness < F32_MAX;
}
